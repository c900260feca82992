use super::*;
use crate::conversion::creases::Creases;
use crate::mesh::{TriangleMesh, shapes};
use glam::DVec3;

/// A mesh simplified to a number of faces, and the map to it.
pub(crate) fn simplified(mesh: &TriangleMesh, target: usize) -> (Parameterisation, WorkingMesh) {
    let connectivity = crate::mesh::Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone())
        .expect("a manifold");
    let positions = mesh.positions.iter().map(|&p| DVec3::from(p)).collect();
    let mut working = WorkingMesh::new(positions, &connectivity);
    let mut map = Parameterisation::new(mesh.faces.len() as u32);
    let density = Density::new(mesh, &connectivity, 64.0 * target as f64, &Creases::default());
    simplify(&mut working, &mut map, target, &density, &|_| true).expect("not cancelled");
    (map, working)
}

#[test]
fn topology_is_kept() {
    for (name, mesh) in shapes::awkward() {
        let fine = shapes::subdivide(&mesh, 3);
        let (_, working) = simplified(&fine, mesh.faces.len());
        let faces: Vec<[u32; 3]> = working.live_faces().map(|f| working.face(f)).collect();
        let count = working.positions.len() as u32;
        let after = crate::mesh::Connectivity::build(count, faces).expect(name);
        let before = crate::mesh::Connectivity::build(count, fine.faces.clone()).expect(name);
        let figures = |c: &crate::mesh::Connectivity| (c.genus(), c.components(), c.boundary_loops());
        assert_eq!(figures(&after), figures(&before), "{name}");
        let mut corners: Vec<[u32; 3]> = after.faces().to_vec();
        corners.iter_mut().for_each(|f| f.sort_unstable());
        corners.sort_unstable();
        assert!(corners.windows(2).all(|pair| pair[0] != pair[1]), "{name}");
        assert!(working.live_count() <= 2 * mesh.faces.len() + 4, "{name}: {} faces", working.live_count());
    }
}

#[test]
fn it_can_be_stopped() {
    let mesh = shapes::subdivide(&shapes::octahedron(), 5);
    let connectivity =
        crate::mesh::Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone()).unwrap();
    let positions = mesh.positions.iter().map(|&p| DVec3::from(p)).collect();
    let mut working = WorkingMesh::new(positions, &connectivity);
    let mut map = Parameterisation::new(mesh.faces.len() as u32);
    let density = Density::new(&mesh, &connectivity, 64.0, &Creases::default());
    assert_eq!(simplify(&mut working, &mut map, 8, &density, &|done| done < 0.5), Err(Cancelled));
}

/// Half a tube between two seams, and much too few faces for it: no edge goes from one seam to the other, since its mirror
/// image would be a second edge of the same ends.
#[test]
fn no_edge_bridges_the_seam() {
    let (across, along) = (5u32, 40u32);
    let place = |v: u32| {
        let angle = std::f64::consts::PI * f64::from(v % across) / f64::from(across - 1);
        let x = if [0, across - 1].contains(&(v % across)) { 0.0 } else { libm::sin(angle) };
        [x, 0.6 * f64::from(v / across), libm::cos(angle)]
    };
    let squares = (0..along - 1).flat_map(|y| (0..across - 1).map(move |x| y * across + x));
    let faces = squares.flat_map(|v| [[v, v + 1, v + across], [v + 1, v + across + 1, v + across]]).collect();
    let mesh = TriangleMesh::new((0..across * along).map(place).collect(), faces);
    let connectivity = crate::mesh::Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone())
        .expect("a manifold");
    let positions = mesh.positions.iter().map(|&p| DVec3::from(p)).collect();
    let seam: Vec<bool> = mesh.positions.iter().map(|p| p[0] == 0.0).collect();
    let mut working = WorkingMesh::new(positions, &connectivity).with_seam(seam);
    let mut map = Parameterisation::new(mesh.faces.len() as u32);
    let density = Density::new(&mesh, &connectivity, 640.0, &Creases::default());
    simplify(&mut working, &mut map, 2, &density, &|_| true).expect("not cancelled");
    assert!(working.live_count() < mesh.faces.len() / 4, "{} faces", working.live_count());
    for [a, b] in live_edges(&working) {
        let bridge = working.is_seam(a) && working.is_seam(b) && !working.sides(a, b).contains(&None);
        assert!(!bridge, "{} to {}", working.positions[a as usize], working.positions[b as usize]);
    }
}
