use super::*;
use crate::conversion::domain::tests::{place, unchanged};
use crate::conversion::parameterise::OnFace;
use crate::hierarchy::Level;
use crate::mesh::TriangleMesh;

/// Places of the lattice on the faces themselves.
fn places(domain: &Domain, mesh: &TriangleMesh, lattice: &Lattice) -> Places {
    let at = lattice.addresses.iter().map(|&address| place(&domain.base, mesh, address)).collect();
    Places { points: Vec::<OnFace>::new(), at, density: Vec::new() }
}

/// A flat sheet of slanted cells, each cut along its longer diagonal or its shorter one.
fn sheet(longer: bool, size: u32) -> TriangleMesh {
    let across = size + 1;
    let place = |v: u32| {
        let (x, y) = (f64::from(v % across), f64::from(v / across));
        [x + 0.5 * y, 0.866 * y, 0.0]
    };
    let cell = |v: u32| {
        let [a, b, c, d] = [v, v + 1, v + across + 1, v + across];
        if longer { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
    };
    let cells = (0..size * size).map(|k| k / size * across + k % size);
    TriangleMesh::new((0..across * across).map(place).collect(), cells.flat_map(cell).collect())
}

/// Edges of a base mesh that are longer than a side of the cells.
fn long_edges(base: &BaseMesh, mesh: &TriangleMesh) -> usize {
    let length = |[a, b]: [u32; 2]| {
        let [p, q] = [a, b].map(|v| mesh.positions[v as usize]);
        (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt()
    };
    base.edges().iter().filter(|&&ends| length(ends) > 1.2).count()
}

#[test]
fn edges_flip_until_faces_are_equilateral() {
    let mesh = sheet(true, 6);
    let (working, map) = unchanged(&mesh, 0);
    let domain = Domain::new(&working, &map).expect("a base mesh");
    let mut lattice = Lattice::over(&domain, Level(2)).expect("it fits");
    let before = long_edges(lattice.hierarchy.base(), &mesh);
    let mut rounds = 0;
    while let Some(next) = flipped(&lattice, &domain, &places(&domain, &mesh, &lattice)) {
        assert_eq!(next.hierarchy.base().faces().len(), mesh.faces.len());
        lattice = next;
        rounds += 1;
        assert!(rounds < 20, "it ends");
    }
    let after = long_edges(lattice.hierarchy.base(), &mesh);
    assert!(before == 36 && after < 8, "{before} long edges before, {after} after {rounds} rounds");
}

#[test]
fn good_edges_and_sharp_ones_stay() {
    for (longer, sharp) in [(false, 0), (true, usize::MAX)] {
        let mesh = sheet(longer, 4);
        let (working, map) = unchanged(&mesh, sharp);
        let domain = Domain::new(&working, &map).expect("a base mesh");
        let lattice = Lattice::over(&domain, Level(2)).expect("it fits");
        let sharp = lattice.hierarchy.base().sharp_edges();
        match flipped(&lattice, &domain, &places(&domain, &mesh, &lattice)) {
            None => assert!(!longer || !sharp.is_empty()),
            Some(next) => {
                assert!(longer, "nothing was to gain");
                assert_eq!(next.hierarchy.base().sharp_edges(), sharp);
            }
        }
    }
}
