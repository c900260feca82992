use super::*;
use crate::conversion::domain::tests::{place, rhombus, unchanged};
use crate::mesh::shapes;
use glam::DVec3;

#[test]
fn one_level_more_is_the_finer_lattice() {
    for (name, mesh) in shapes::awkward() {
        for sharp in [0, 3] {
            let (working, map) = unchanged(&mesh, sharp);
            let domain = Domain::new(&working, &map).expect(name);
            let refined = Lattice::over(&domain, Level(1)).and_then(|coarse| coarse.refined(&domain));
            let (refined, direct) =
                (refined.expect("it fits"), Lattice::over(&domain, Level(2)).expect("it fits"));
            for (slot, (&one, &other)) in refined.addresses.iter().zip(&direct.addresses).enumerate() {
                let [p, q] = [one, other].map(|address| place(&domain.base, &mesh, address));
                assert!(p.distance(q) < 1e-9, "{name}, {sharp} sharp, slot {slot}: {one:?}, {other:?}");
            }
        }
    }
}

/// Flipping the edge inside a rhombus of two equilateral faces: the lattice still covers each place once, and every
/// vertex on the rim stays.
#[test]
fn a_flipped_edge_keeps_the_lattice_one_to_one() {
    let mesh = rhombus(1);
    let (working, map) = unchanged(&mesh, 0);
    let domain = Domain::new(&working, &map).expect("a base mesh");
    let lattice = Lattice::over(&domain, Level(3)).expect("it fits");
    let faces = vec![[0, 1, 3], [0, 3, 2]];
    let base = BaseMesh::new(4, faces.clone(), &[]).expect("a base mesh");
    let was = lattice.hierarchy.base();
    let left = was.faces().iter().position(|f| f.contains(&0)).expect("a face") as u32;
    let flip = Flipped { ends: [1, 2], apexes: [0, 3], faces: [left, 1 - left] };
    let old = faces.iter().map(|&face| (sorted(face), flip)).collect();
    let after = lattice.rebased(&domain, base, &old).expect("it fits");
    let at: Vec<DVec3> = after.addresses.iter().map(|&address| place(&domain.base, &mesh, address)).collect();
    let areas: Vec<f64> = after
        .fitted
        .pattern
        .faces()
        .iter()
        .map(|face| {
            let [a, b, c] = face.map(|v| at[v as usize]);
            0.5 * (b - a).cross(c - a).z
        })
        .collect();
    assert!(areas.iter().all(|&area| area > 1e-4), "{areas:?}");
    assert!((areas.iter().sum::<f64>() - 3f64.sqrt() / 2.0).abs() < 1e-9);
    let layout = after.layout();
    for v in 0..4 {
        let corner = at[layout.slot(Site::Base(v)).index()];
        assert!(corner.distance(DVec3::from(mesh.positions[v as usize])) < 1e-12, "{v}: {corner}");
    }
}

#[test]
fn too_many_vertices_are_refused() {
    let mesh = shapes::octahedron();
    let (working, map) = unchanged(&mesh, 0);
    let domain = Domain::new(&working, &map).expect("a base mesh");
    assert!(Lattice::fits(&domain, Level(3)).is_some() && Lattice::over(&domain, Level(3)).is_some());
    assert!(Lattice::fits(&domain, Level(15)).is_none() && Lattice::over(&domain, Level(15)).is_none());
}
