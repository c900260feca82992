//! Simplification to a base mesh: edge collapses in the order of their quadric error, each flattened and recorded.
//!
//! Garland & Heckbert 1997 with plane, boundary and point quadrics; link condition after Dey et al. 1999. Cost grows
//! with slivers, with valences away from six, and with what the new vertex would stand for by the density. An edge that cannot be collapsed is passed over and tried again when
//! its neighbourhood has changed; when nothing is left to try, the demands are lowered ([`LADDER`]).
//!
//! Guarantees: genus, components and boundary loops stay; the mesh stays simplicial; the same input gives the same
//! base mesh. Non-guarantees: the number of faces asked for, where topology or flattening does not allow it.

use super::collapse::{Attempt, CollapseRules, Collapser};
use super::costs::Costs;
use super::density::Density;
use super::parameterise::Parameterisation;
use super::working_mesh::WorkingMesh;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Demands, strictest first: used one after another while faces remain to be removed.
pub(super) const LADDER: [CollapseRules; 4] = [
    CollapseRules {
        valences: (4, 8),
        least_on_boundary: 3,
        least_sine: 0.08,
        least_quality: 0.25,
        least_cosine: 0.3,
    },
    CollapseRules {
        valences: (4, 9),
        least_on_boundary: 3,
        least_sine: 0.04,
        least_quality: 0.1,
        least_cosine: 0.0,
    },
    CollapseRules {
        valences: (3, 11),
        least_on_boundary: 3,
        least_sine: 0.01,
        least_quality: 0.02,
        least_cosine: -0.5,
    },
    CollapseRules {
        valences: (3, 24),
        least_on_boundary: 2,
        least_sine: 1e-4,
        least_quality: 0.0,
        least_cosine: -1.0,
    },
];

/// Attempts between two calls of the progress function.
pub(super) const STRIDE: usize = 512;

/// The progress function asked to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Cancelled;

/// Whether to go on, as a result.
pub(super) fn ask(go_on: &dyn Fn() -> bool) -> Result<(), Cancelled> {
    if go_on() { Ok(()) } else { Err(Cancelled) }
}

/// An edge in the queue. The least cost comes first; ties go to the lower vertices.
#[derive(Debug, Clone, Copy)]
struct Candidate {
    cost: f64,
    ends: [u32; 2],
    stamps: [u32; 2],
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then(other.ends.cmp(&self.ends))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

/// Collapses edges until at most `target` faces are left or nothing more can go, recording each in `map`.
/// `progress` takes the fraction done and returns whether to go on. Cost: `O(n log n)` for n faces, about 12 µs a
/// collapse.
///
/// # Errors
/// The progress function asked to stop.
pub(super) fn simplify(
    mesh: &mut WorkingMesh,
    map: &mut Parameterisation,
    target: usize,
    density: &Density,
    progress: &dyn Fn(f32) -> bool,
) -> Result<(), Cancelled> {
    let start = mesh.live_count();
    let done =
        |mesh: &WorkingMesh| (start - mesh.live_count()) as f32 / start.saturating_sub(target).max(1) as f32;
    let mut costs = Costs::new(mesh, density, target);
    let mut stamps = vec![0u32; mesh.positions.len()];
    let mut collapser = Collapser::default();
    let mut neighbours = Vec::new();
    let mut attempts = 0usize;
    for rules in &LADDER {
        let mut queue = BinaryHeap::new();
        let mut edges = live_edges(mesh);
        loop {
            for (at, &ends) in edges.iter().enumerate() {
                if at % STRIDE == STRIDE - 1 && !progress(done(mesh)) {
                    return Err(Cancelled);
                }
                if let Some((cost, shape)) = collapser.cost(mesh, &costs.quadrics, ends, rules) {
                    let cost = (cost + costs.crowding(ends)) * shape;
                    queue.push(Candidate { cost, ends, stamps: ends.map(|v| stamps[v as usize]) });
                }
            }
            if mesh.live_count() <= target {
                return Ok(());
            }
            edges.clear();
            let Some(candidate) = queue.pop() else { break };
            let Candidate { ends, .. } = candidate;
            if candidate.stamps != ends.map(|v| stamps[v as usize]) {
                continue;
            }
            attempts += 1;
            if attempts.is_multiple_of(STRIDE) && !progress(done(mesh)) {
                return Err(Cancelled);
            }
            let Attempt::Done { kept, gone } =
                collapser.collapse(mesh, Some(map), &costs.quadrics, ends, rules)
            else {
                continue;
            };
            costs.join(mesh, kept, gone);
            stamps[kept as usize] += 1;
            stamps[gone as usize] += 1;
            mesh.neighbours(kept, &mut neighbours);
            edges.extend(neighbours.iter().map(|&w| [kept.min(w), kept.max(w)]));
        }
    }
    Ok(())
}

/// Every edge of the live faces once, ends ascending.
fn live_edges(mesh: &WorkingMesh) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = mesh
        .live_faces()
        .flat_map(|f| {
            let [a, b, c] = mesh.face(f);
            [[a, b], [b, c], [c, a]]
        })
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}

#[cfg(test)]
pub(super) mod tests;
