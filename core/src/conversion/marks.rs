//! Marks of sharp edges on a mesh that has subdivision connectivity: base edges that are marked all along become sharp.

use crate::hierarchy::detection::Detected;
use crate::hierarchy::{BaseMesh, Hierarchy};
use rustc_hash::FxHashSet;
use std::sync::Arc;

/// What was detected, with the base edges made sharp that consist of `marked` edges (pairs of vertices of the mesh, ends
/// ascending), and how many of those are left over. Linear in the vertices along base edges; nothing without marks.
pub(super) fn mark(detected: Detected, marked: &[[u32; 2]]) -> (Detected, usize) {
    if marked.is_empty() {
        return (detected, 0);
    }
    let marked: FxHashSet<[u32; 2]> = marked.iter().copied().collect();
    let Detected { hierarchy, source } = detected;
    let (base, layout) = (hierarchy.base(), hierarchy.layout(hierarchy.finest()));
    let is_marked = |edge: u32| {
        layout.edges_along(edge).all(|ends| {
            let [a, b] = ends.map(|slot| source[slot.index()]);
            marked.contains(&[a.min(b), a.max(b)])
        })
    };
    let sharp: Vec<u32> = (0..base.edges().len() as u32).filter(|&edge| is_marked(edge)).collect();
    let left = marked.len() - sharp.len() * layout.segments() as usize;
    let ends: Vec<[u32; 2]> = sharp.iter().map(|&edge| base.edges()[edge as usize]).collect();
    let base =
        BaseMesh::new(base.vertex_count(), base.faces().to_vec(), &ends).expect("it was a base mesh before");
    let hierarchy = Hierarchy::new(Arc::new(base), hierarchy.finest()).expect("as many vertices as before");
    (Detected { hierarchy, source }, left)
}
