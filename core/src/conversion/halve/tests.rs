use super::*;
use crate::mesh::shapes;
use std::collections::BTreeMap;

fn connected(mesh: &TriangleMesh) -> Connectivity<'static> {
    Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone()).expect("a manifold")
}

/// In a box of diagonal 1 around x = 0.
fn centred(mut mesh: TriangleMesh) -> TriangleMesh {
    let bounds = mesh.bounds().expect("faces");
    let middle = 0.5 * (bounds.min[0] + bounds.max[0]);
    for p in &mut mesh.positions {
        *p = [p[0] - middle, p[1], p[2]].map(|x| x / bounds.diagonal());
    }
    mesh
}

fn check(name: &str, mesh: &TriangleMesh) -> Half {
    let connectivity = connected(mesh);
    let half = Half::of(mesh, &connectivity).expect(name);
    let figures = |c: &Connectivity| (c.genus(), c.components(), c.boundary_loops());
    assert_eq!(figures(&half.whole_connectivity), figures(&connectivity), "{name}");
    let key = |p: [f64; 3]| p.map(|x| (x + 0.0).to_bits());
    let mut count: BTreeMap<[u64; 3], i32> = BTreeMap::new();
    for &[x, y, z] in &half.whole.positions {
        *count.entry(key([x, y, z])).or_default() += 1;
        *count.entry(key([0.0 - x, y, z])).or_default() -= 1;
    }
    assert!(count.values().all(|&count| count == 0), "{name}: the whole is not its own mirror image");
    let seam = |v: u32| half.seam[v as usize];
    for (v, &[x, ..]) in (0..).zip(&half.mesh.positions) {
        assert!(if seam(v) { x == 0.0 } else { x >= 0.0 }, "{name}: {x}");
    }
    for h in 0..3 * half.mesh.faces.len() as u32 {
        let (a, b) = (half.connectivity.origin(h), half.connectivity.target(h));
        let bridge = seam(a) && seam(b) && half.connectivity.twin(h) != NONE;
        assert!(!bridge, "{name}: an edge bridges the seam");
    }
    half
}

#[test]
fn halves_make_wholes_of_the_same_topology() {
    for (name, mesh) in [
        ("octahedron", shapes::octahedron()),
        ("ball", shapes::subdivide(&shapes::octahedron(), 4)),
        ("torus", shapes::torus(12, 16)),
        ("odd torus", shapes::torus(7, 13)),
        ("pretzel", shapes::subdivide(&shapes::pretzel(2), 1)),
        ("pretzel of three", shapes::pretzel(3)),
        ("disc", shapes::subdivide(&shapes::disc(8), 2)),
        ("triangle", shapes::triangle()),
    ] {
        check(name, &centred(mesh));
    }
}

/// A part on each side, of which one reaches over to the other side.
#[test]
fn parts_that_lap_over_the_plane_stay_on_their_side() {
    let ball = |x: f64| {
        let mut ball = shapes::subdivide(&shapes::octahedron(), 5);
        for p in &mut ball.positions {
            let at = DVec3::from(*p).normalize() * 0.25;
            *p = [at.x + x, at.y, at.z];
        }
        ball
    };
    let mesh = shapes::together(&[ball(-0.249), ball(0.249)]);
    let half = check("balls", &mesh);
    assert!(half.seam.iter().all(|seam| !seam));
    assert_eq!(half.connectivity.components(), 1);
}

#[test]
fn marks_are_cut_with_their_edges() {
    let mesh = centred(shapes::torus(12, 17));
    let ring = |v: &u32| v.is_multiple_of(12);
    let edges = mesh.faces.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
    let marked: Vec<[u32; 2]> = edges.filter(|ends| ends.iter().all(ring)).collect();
    let mesh = mesh.with_sharp_edges(marked);
    let half = check("torus", &mesh);
    let length = |mesh: &TriangleMesh| -> f64 {
        let way = |ends: &[u32; 2]| {
            let [p, q] = ends.map(|v| DVec3::from(mesh.positions[v as usize]));
            p.distance(q)
        };
        mesh.sharp_edges.iter().map(way).sum()
    };
    assert!(!mesh.sharp_edges.is_empty());
    assert!(
        (length(&half.whole) / length(&mesh) - 1.0).abs() < 0.02,
        "{} {}",
        length(&half.whole),
        length(&mesh)
    );
    let creases = Creases::marked(&half.whole, &half.whole_connectivity);
    let own = half.creases(&creases);
    let corners = own.corners.iter().filter(|corner| **corner).count();
    assert_eq!(corners, 2, "the ring meets the seam twice");
}
