//! Vertices of a fitted surface that stay on the input's sharp edges: those on marked edges slide along the chain they
//! lie on, those in corners stay.

use super::creases::Creases;
use super::curves::Curves;
use super::normal_equations::Symmetric;
use crate::hierarchy::{Hierarchy, Layout, Site, Slot};
use crate::mesh::{BoundingVolumes, TriangleMesh};
use glam::DVec3;

/// Weight of leaving the curve, against that of the samples.
const STIFF: f64 = 1e4;

/// Where one vertex may go.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Hold {
    Free,
    /// Along a chain; with its neighbours on it.
    Along {
        chain: u32,
        near: [u32; 2],
    },
    Fixed,
}

/// What holds the vertices of a fitted surface; nothing by default.
#[derive(Default)]
pub(super) struct Held {
    /// By vertex; empty if all are free.
    holds: Vec<Hold>,
    chains: Vec<BoundingVolumes>,
}

impl Held {
    /// The vertices of the finest level by the base mesh's marks and `pinned` vertices, with `places` on the input.
    pub(super) fn new(
        hierarchy: &Hierarchy,
        pinned: &[bool],
        places: &[DVec3],
        mesh: &TriangleMesh,
        creases: &Creases,
    ) -> Self {
        let rows = creases.chains();
        let of_segment: Vec<u32> =
            rows.iter().zip(0..).flat_map(|(row, chain)| vec![chain; row.len() - 1]).collect();
        let (base, layout) = (hierarchy.base(), hierarchy.layout(hierarchy.finest()));
        let along = Curves::new(base, pinned);
        let mut held = Self { holds: vec![Hold::Free; places.len()], chains: Vec::new() };
        for v in (0..base.vertex_count()).filter(|&v| pinned[v as usize]) {
            held.holds[layout.slot(Site::Base(v)).index()] = Hold::Fixed;
        }
        let Some(tree) = curves(mesh, &rows) else { return held };
        held.chains = rows.chunks(1).filter_map(|row| curves(mesh, row)).collect();
        for edge in (0..base.edges().len() as u32).filter(|&e| base.is_sharp(e)) {
            let n = layout.segments();
            let slot = |t: u32| layout.slot(layout.along_edge(edge, t));
            let middle = places[slot(n / 2).index()] + places[slot(n.div_ceil(2)).index()];
            let chain = of_segment[tree.closest((middle * 0.5).to_array()).face.0 as usize];
            for t in 1..n {
                held.holds[slot(t).index()] = Hold::Along { chain, near: [slot(t - 1).0, slot(t + 1).0] };
            }
            for v in base.edges()[edge as usize] {
                held.holds[layout.slot(Site::Base(v)).index()] = match along.through(v) {
                    Some(edges) => Hold::Along { chain, near: edges.map(|e| next_to(layout, v, e).0) },
                    None => Hold::Fixed,
                };
            }
        }
        held
    }

    /// The vertices of the finest level on sharp edges of the base mesh, each within its base edge as that runs through
    /// positions; its ends keep their places.
    pub(super) fn on_own_curves(hierarchy: &Hierarchy, positions: &[DVec3]) -> Self {
        let (base, layout) = (hierarchy.base(), hierarchy.layout(hierarchy.finest()));
        let mut held = Self { holds: vec![Hold::Free; positions.len()], chains: Vec::new() };
        let n = layout.segments();
        for edge in (0..base.edges().len() as u32).filter(|&e| base.is_sharp(e)) {
            let slots: Vec<u32> = (0..=n).map(|t| layout.slot(layout.along_edge(edge, t)).0).collect();
            let points = slots.iter().map(|&slot| positions[slot as usize].to_array()).collect();
            let row = TriangleMesh::new(points, Vec::new());
            let Some(chain) = curves(&row, &[(0..=n).collect()]) else { continue };
            for near in slots.windows(3) {
                let chain = held.chains.len() as u32;
                held.holds[near[1] as usize] = Hold::Along { chain, near: [near[0], near[2]] };
            }
            held.chains.push(chain);
            for t in [0, n as usize] {
                held.holds[slots[t] as usize] = Hold::Fixed;
            }
        }
        held
    }

    /// One vertex of so many that keeps its place.
    #[cfg(test)]
    pub(super) fn fixing(v: usize, count: usize) -> Self {
        let mut holds = vec![Hold::Free; count];
        holds[v] = Hold::Fixed;
        Self { holds, chains: Vec::new() }
    }

    fn hold(&self, v: usize) -> Hold {
        self.holds.get(v).copied().unwrap_or(Hold::Free)
    }

    /// Whether a vertex may go anywhere.
    pub(super) fn is_free(&self, v: usize) -> bool {
        self.hold(v) == Hold::Free
    }

    /// Neighbours of a vertex along its chain, if it is held to one.
    pub(super) fn along(&self, v: usize) -> Option<[u32; 2]> {
        if let Hold::Along { near, .. } = self.hold(v) { Some(near) } else { None }
    }

    /// What keeps a vertex from leaving its curve or corner, to be added to its block.
    pub(super) fn stiffness(&self, v: usize, positions: &[DVec3]) -> Option<Symmetric> {
        let tangent = match self.hold(v) {
            Hold::Free => return None,
            Hold::Fixed => return Some(Symmetric::about(DVec3::Z, STIFF, STIFF)),
            Hold::Along { near: [p, q], .. } => positions[q as usize] - positions[p as usize],
        };
        Some(match tangent.try_normalize() {
            Some(tangent) => Symmetric::about(tangent, 0.0, STIFF),
            None => Symmetric::about(DVec3::Z, STIFF, STIFF),
        })
    }

    /// Where a vertex that would go from one place to another may go.
    pub(super) fn put(&self, v: usize, from: DVec3, to: DVec3) -> DVec3 {
        match self.hold(v) {
            Hold::Free => to,
            Hold::Fixed => from,
            Hold::Along { chain, .. } => self.chains[chain as usize].closest(to.to_array()).point.into(),
        }
    }
}

/// Rows of vertices as segments that can be asked for closest points; `None` without rows.
pub(super) fn curves(mesh: &TriangleMesh, rows: &[Vec<u32>]) -> Option<BoundingVolumes> {
    let positions = rows.iter().flatten().map(|&v| mesh.positions[v as usize]).collect();
    let mut faces = Vec::new();
    let mut first = 0;
    for row in rows {
        let last = first + row.len() as u32;
        // Triangles without area are answered as segments.
        faces.extend((first + 1..last).map(|k| [k - 1, k, k]));
        first = last;
    }
    BoundingVolumes::build(&TriangleMesh::new(positions, faces))
}

/// The vertex next to a base vertex on one of its edges.
fn next_to(layout: &Layout, v: u32, edge: u32) -> Slot {
    let low = layout.base().edges()[edge as usize][0] == v;
    layout.slot(layout.along_edge(edge, if low { 1 } else { layout.segments() - 1 }))
}
