//! Whether a base mesh is its own mirror image.

use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Site};
use glam::DVec3;
use std::collections::BTreeSet;

/// Finds for each base vertex the one nearest to its mirror image in the plane x = `plane`, and checks that this is a map of the
/// base mesh onto itself that turns it inside out: of faces, sharp edges and the boundary. Returns how many vertices
/// are their own image. `uneven` is how far the surface is from being symmetric.
pub(crate) fn check(
    name: &str,
    hierarchy: &Hierarchy,
    positions: &[[f64; 3]],
    plane: f64,
    uneven: f64,
) -> usize {
    let base = hierarchy.base();
    let layout = hierarchy.layout(hierarchy.finest());
    let at = |v: u32| DVec3::from(positions[layout.slot(Site::Base(v)).index()]);
    let vertices = 0..base.vertex_count();
    let image = |v: u32| {
        let p = at(v);
        let mirrored = DVec3::new(2.0 * plane - p.x, p.y, p.z);
        let near = |w: &u32| at(*w).distance(mirrored);
        let w = vertices.clone().min_by(|a, b| near(a).total_cmp(&near(b))).expect("vertices");
        let edges = base.fan(v).corners.iter().map(|&(f, k)| {
            let next = base.faces()[f as usize][(usize::from(k) + 1) % 3];
            at(next).distance(p)
        });
        let shortest = edges.fold(f64::INFINITY, f64::min);
        assert!(
            near(&w) < 0.2 * shortest + uneven,
            "{name}: vertex {v} is {} off, its edges {shortest}",
            near(&w)
        );
        w
    };
    let images: Vec<u32> = vertices.clone().map(image).collect();
    let of = |v: u32| images[v as usize];
    assert!(vertices.clone().all(|v| of(of(v)) == v), "{name}: an image has another image");
    let first = |[a, b, c]: [u32; 3]| [[a, b, c], [b, c, a], [c, a, b]].into_iter().min().expect("three");
    let faces: BTreeSet<[u32; 3]> = base.faces().iter().map(|&face| first(face)).collect();
    let lost = base.faces().iter().find(|&&[a, b, c]| !faces.contains(&first([a, c, b].map(of))));
    assert!(lost.is_none(), "{name}: the image of face {lost:?} is no face");
    let sorted = |[a, b]: [u32; 2]| [a.min(b), a.max(b)];
    let is_sharp: fn(&BaseMesh, u32) -> bool = |base, e| base.is_sharp(e);
    for wanted in [is_sharp, |base, e| base.is_boundary_edge(e)] {
        let edges: Vec<[u32; 2]> = (0..base.edges().len() as u32)
            .filter(|&e| wanted(base, e))
            .map(|e| base.edges()[e as usize])
            .collect();
        let own: BTreeSet<[u32; 2]> = edges.iter().map(|&ends| sorted(ends)).collect();
        let mirrored: BTreeSet<[u32; 2]> = edges.iter().map(|ends| sorted(ends.map(of))).collect();
        assert_eq!(own, mirrored, "{name}");
    }
    vertices.filter(|&v| of(v) == v).count()
}
