use super::*;
use crate::mesh::shapes;

fn checked(mesh: &TriangleMesh) -> Cleaned {
    let cleaned = clean(mesh, 0.0).expect("faces are left");
    let used = cleaned.connectivity.faces().iter().flatten().max().map_or(0, |v| v + 1);
    assert_eq!(used as usize, cleaned.positions.len());
    cleaned
}

#[test]
fn sound_meshes_stay_as_they_are() {
    for (name, mesh) in shapes::awkward() {
        let cleaned = checked(&mesh);
        assert_eq!(cleaned.positions, mesh.positions, "{name}");
        assert!(cleaned.report.sentences().is_empty(), "{name}: {:?}", cleaned.report);
        assert_eq!(cleaned.connectivity.faces().len(), mesh.faces.len(), "{name}");
    }
}

#[test]
fn a_soup_is_welded() {
    let whole = shapes::subdivide(&shapes::octahedron(), 2);
    let positions = whole.faces.iter().flatten().map(|&v| whole.positions[v as usize]).collect::<Vec<_>>();
    let faces = (0..whole.faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
    let cleaned = checked(&TriangleMesh::new(positions, faces));
    assert_eq!(cleaned.positions.len(), whole.positions.len());
    assert_eq!((cleaned.connectivity.genus(), cleaned.connectivity.boundary_loops()), (0, 0));
    assert_eq!(cleaned.report.welded, 3 * whole.faces.len() - whole.positions.len());
}

#[test]
fn nearby_vertices_are_welded_within_the_tolerance_only() {
    let mut mesh = shapes::octahedron();
    mesh.positions.push([1.0 + 1e-4, 0.0, -1e-4]);
    mesh.faces[3] = [3, 6, 4];
    let strict = clean(&mesh, 0.0).expect("faces");
    assert_eq!(strict.connectivity.boundary_loops(), 1);
    let loose = clean(&mesh, 1e-3).expect("faces");
    assert_eq!((loose.connectivity.boundary_loops(), loose.report.welded), (0, 1));
}

#[test]
fn faces_are_oriented_with_the_majority() {
    let mut mesh = shapes::subdivide(&shapes::octahedron(), 1);
    for f in [0, 7, 12] {
        mesh.faces[f].swap(1, 2);
    }
    let cleaned = checked(&mesh);
    assert_eq!(cleaned.report.turned, 3);
    let volume: f64 = cleaned
        .connectivity
        .faces()
        .iter()
        .map(|f| {
            let [a, b, c] = f.map(|v| glam::DVec3::from(cleaned.positions[v as usize]));
            a.dot(b.cross(c))
        })
        .sum();
    let original = shapes::subdivide(&shapes::octahedron(), 1);
    let [a, b, c] = original.corners(crate::mesh::FaceIndex(5)).map(glam::DVec3::from);
    assert!(volume * a.dot(b.cross(c)) > 0.0);
}

#[test]
fn a_fin_is_cut_off_and_a_shared_vertex_doubled() {
    let mut mesh = shapes::octahedron();
    mesh.positions.push([2.0, 2.0, 2.0]);
    mesh.faces.push([0, 2, 6]);
    let cleaned = checked(&mesh);
    assert_eq!(cleaned.report.cut_edges, 1);
    assert_eq!(cleaned.connectivity.components(), 2);

    let mut pair = shapes::together(&[shapes::octahedron(), shapes::octahedron()]);
    pair.faces.iter_mut().flatten().filter(|v| **v == 7).for_each(|v| *v = 0);
    let cleaned = checked(&pair);
    assert_eq!((cleaned.report.cut_vertices, cleaned.report.unreferenced), (1, 1));
    assert_eq!((cleaned.connectivity.components(), cleaned.connectivity.boundary_loops()), (2, 0));
}

#[test]
fn fins_leave_no_crack_and_walls_no_slit() {
    let ball = shapes::subdivide(&shapes::octahedron(), 2);
    let mut hairy = ball.clone();
    // Two fins on neighbouring edges: a slit along both would open the ball.
    let [a, b, c] = hairy.faces[0];
    for (p, q) in [(a, b), (b, c)] {
        hairy.positions.push([2.0 + f64::from(q), 2.0, 2.0]);
        hairy.faces.push([p, q, hairy.positions.len() as u32 - 1]);
    }
    let cleaned = checked(&hairy);
    assert_eq!((cleaned.connectivity.components(), cleaned.connectivity.boundary_loops()), (3, 2));
    assert_eq!((cleaned.report.cut_edges, cleaned.report.dropped), (2, 0));

    // A sheet that stands on a flat one, from edge to edge: the flat one goes on under it.
    let at = |x: f64, y: f64, z: f64| [x, y, z];
    let positions =
        vec![at(0.0, 0.0, 0.0), at(0.0, 1.0, 0.0), at(1.0, 0.0, 0.0), at(-1.0, 0.0, 0.0), at(0.0, 0.0, 1.0)];
    let wall = TriangleMesh::new(positions, vec![[0, 2, 1], [0, 1, 3], [0, 1, 4]]);
    let cleaned = checked(&wall);
    assert_eq!((cleaned.connectivity.components(), cleaned.connectivity.faces().len()), (2, 3));
}

#[test]
fn a_one_sided_band_is_cut_open() {
    let positions = (0..5)
        .map(|i| {
            let t = f64::from(i) * 1.2566;
            [t.cos(), t.sin(), 0.3 * f64::from(i % 2)]
        })
        .collect();
    let faces = (0..5u32).map(|i| [i, (i + 1) % 5, (i + 2) % 5]).collect();
    let cleaned = checked(&TriangleMesh::new(positions, faces));
    assert!(cleaned.report.one_sided > 0);
    assert!(cleaned.connectivity.boundary_loops() >= 1);
}

#[test]
fn rubbish_is_left_out() {
    let mut mesh = shapes::octahedron();
    mesh.faces.push([0, 0, 1]);
    mesh.faces.push([4, 0, 2]);
    mesh.positions.extend([[9.0; 3], [9.0; 3], [9.5; 3], [10.0; 3]]);
    mesh.faces.push([7, 8, 9]);
    let cleaned = checked(&mesh);
    let report = &cleaned.report;
    assert_eq!((report.degenerate, report.doubled, report.islands, report.unreferenced), (1, 1, 1, 1));
    assert_eq!(cleaned.connectivity.faces().len(), 8);
    let nothing = TriangleMesh::new(vec![[0.0; 3]; 3], vec![[0, 0, 1], [0, 1, 2]]);
    assert!(clean(&nothing, 0.0).is_none());
}
