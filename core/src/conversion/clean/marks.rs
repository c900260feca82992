//! The marks of sharp edges, found again after a repair by the places of their ends: vertices are numbered anew by then,
//! and some are there twice.

use super::weld::place;
use crate::mesh::{Connectivity, TriangleMesh};
use rustc_hash::{FxHashMap, FxHashSet};

/// The marked edges by the places of their ends.
pub(super) struct Marks {
    places: FxHashMap<[u64; 3], u32>,
    edges: FxHashSet<[u32; 2]>,
}

impl Marks {
    /// The marks of a mesh whose vertices are `merged` with others.
    pub(super) fn new(mesh: &TriangleMesh, merged: &[u32]) -> Self {
        let mut marks = Self { places: FxHashMap::default(), edges: FxHashSet::default() };
        for ends in &mesh.sharp_edges {
            let [a, b] = ends.map(|v| {
                let next = marks.places.len() as u32;
                *marks.places.entry(place(mesh.positions[merged[v as usize] as usize])).or_insert(next)
            });
            marks.edges.insert([a.min(b), a.max(b)]);
        }
        marks
    }

    /// The marked ones among the edges of a mesh. Linear; nothing without marks.
    pub(super) fn found(&self, positions: &[[f64; 3]], connectivity: &Connectivity) -> Vec<[u32; 2]> {
        if self.edges.is_empty() {
            return Vec::new();
        }
        let places: Vec<Option<&u32>> = positions.iter().map(|&p| self.places.get(&place(p))).collect();
        let marked = |&[a, b]: &[u32; 2]| match (places[a as usize], places[b as usize]) {
            (Some(a), Some(b)) => self.edges.contains(&[*a.min(b), *a.max(b)]),
            _ => false,
        };
        let sides = connectivity.faces().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        sides.filter(marked).collect()
    }
}
