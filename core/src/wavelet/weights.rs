//! Weights of the k-disc wavelets, solved from connectivity alone.
//!
//! Based on: Lounsbery, DeRose, Warren, "Multiresolution Analysis for Surfaces of Arbitrary Topological Type",
//! ACM TOG 16(1), 1997: `ψ_i = φ_i^{j+1} − Σ_{v∈N_k} s_iv φ_v^j` with `s` minimising the projection of `ψ_i` onto
//! `V^j`, so `Σ_v ⟨φ_u,φ_v⟩ s_iv = ⟨φ_u,φ_i^{j+1}⟩` for all `u ∈ N_k`. Every face of `M^0` counts as having the
//! same area; in units of a 48th of a face of `M^j` all inner products are small integers.
//!
//! Sharp edges: a wavelet off a sharp curve leaves the vertices on it alone; one on it uses only the vertices
//! within `k` edges along the curve.

use super::Wavelet;
use super::solving::solve;
use crate::hierarchy::{Layout, Ring, Site};
use rustc_hash::FxHashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Weights are integers: `w = round(s · 2^20)`.
pub const WEIGHT_BITS: u32 = 20;

/// The largest disc that is solved. A disc is larger only around vertices of valence in the hundreds.
pub const LARGEST_DISC: usize = 1200;

/// The vertices that one odd vertex updates, and how much.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OddStencil {
    /// Even vertices of level j, `N_k` without those that sharp curves exclude.
    pub vertices: Vec<Site>,
    /// Their weights `w`.
    pub weights: Vec<i32>,
}

/// Solves stencils and remembers the answers, which repeat from level to level and from place to place.
#[derive(Debug, Default)]
pub struct WeightSolver {
    solved: Mutex<FxHashMap<Vec<i32>, Vec<i32>>>,
}

impl WeightSolver {
    /// The stencil of an odd vertex: `odd` is a site of the level above `layout`'s. Cost: the disc's rings, and
    /// `O(|N_k|³)` for a neighbourhood not met before. Threads may share a solver.
    pub fn stencil(&self, layout: &Layout, odd: Site, wavelet: Wavelet) -> OddStencil {
        let Wavelet::Disc(k) = wavelet else {
            return OddStencil { vertices: Vec::new(), weights: Vec::new() };
        };
        let parents = layout.parents(odd);
        let vertices = updated_vertices(layout, odd, parents, k);
        let system = System::assemble(layout, parents, &vertices);
        let known = self.solved().get(&system.entries).cloned();
        let weights = known.unwrap_or_else(|| {
            let weights = system.solve(vertices.len());
            self.solved().insert(system.entries, weights.clone());
            weights
        });
        OddStencil { vertices, weights }
    }

    fn solved(&self) -> MutexGuard<'_, FxHashMap<Vec<i32>, Vec<i32>>> {
        // Whole entries go in, so a panic of another thread leaves nothing half done.
        self.solved.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// `N_k` of an odd vertex, as sharp curves cut it.
fn updated_vertices(layout: &Layout, odd: Site, parents: [Site; 2], k: u8) -> Vec<Site> {
    if is_on_sharp(layout, odd) {
        return along_sharp(layout, parents, k);
    }
    let mut disc = layout.disc(&parents, k);
    disc.retain(|&v| !is_on_sharp(layout, v));
    disc
}

/// Whether a vertex (of any level) lies on a sharp curve.
pub fn is_on_sharp(layout: &Layout, site: Site) -> bool {
    match site {
        Site::Base(v) => layout.base().sharp_valence(v) > 0,
        Site::Edge { edge, .. } => layout.base().is_sharp(edge),
        Site::Face { .. } => false,
    }
}

/// The vertices within `k` sharp edges of the parents.
fn along_sharp(layout: &Layout, parents: [Site; 2], k: u8) -> Vec<Site> {
    let mut found = parents.to_vec();
    let mut from = 0;
    for _ in 0..k {
        let to = found.len();
        for at in from..to {
            for neighbour in sharp_neighbours(layout, found[at]) {
                if !found.contains(&neighbour) {
                    found.push(neighbour);
                }
            }
        }
        from = to;
    }
    found
}

fn sharp_neighbours(layout: &Layout, site: Site) -> Vec<Site> {
    let base = layout.base();
    let n = layout.segments();
    match site {
        Site::Edge { edge, t } => vec![layout.along_edge(edge, t - 1), layout.along_edge(edge, t + 1)],
        Site::Base(v) => {
            let fan = base.fan(v);
            let last = fan.corners.last().filter(|_| !fan.closed).map(|&(f, c)| (f, (c + 2) % 3));
            let edges = fan.corners.iter().copied().chain(last);
            edges
                .map(|(f, k)| base.face_edges(f)[usize::from(k)])
                .filter(|&edge| base.is_sharp(edge))
                .map(|edge| {
                    layout.along_edge(edge, if base.edges()[edge as usize][0] == v { 1 } else { n - 1 })
                })
                .collect()
        }
        Site::Face { .. } => Vec::new(),
    }
}

/// The normal equations of one stencil in units of `A / 48`: the upper triangle row by row, then the right side.
struct System {
    entries: Vec<i32>,
}

impl System {
    /// `⟨φ_u,φ_u⟩ = 8` per face at `u`; `⟨φ_u,φ_v⟩ = 4` per shared face; `⟨φ_u,φ_i⟩ = 5` per face at the halved edge
    /// for its ends and 2 for the vertices opposite it.
    fn assemble(layout: &Layout, parents: [Site; 2], vertices: &[Site]) -> Self {
        let local: FxHashMap<Site, usize> = vertices.iter().zip(0..).map(|(&v, at)| (v, at)).collect();
        let n = vertices.len();
        let mut entries = Vec::with_capacity(n * (n + 3) / 2);
        let mut row = vec![0; n];
        for (u, &site) in vertices.iter().enumerate() {
            let ring = layout.ring(site);
            row.fill(0);
            row[u] = 8 * ring.faces() as i32;
            for (at, neighbour) in ring.around.iter().enumerate() {
                if let Some(&v) = local.get(neighbour) {
                    row[v] += 4 * shared_faces(&ring, at);
                }
            }
            entries.extend_from_slice(&row[u..]);
        }
        let ring = layout.ring(parents[0]);
        let at = ring.around.iter().position(|&v| v == parents[1]).expect("parents are neighbours");
        let opposite = neighbours_in_ring(&ring, at);
        let faces = opposite.iter().flatten().count() as i32;
        entries.extend(vertices.iter().map(|v| {
            if parents.contains(v) {
                5 * faces
            } else {
                2 * opposite.iter().flatten().filter(|&&o| ring.around[o] == *v).count() as i32
            }
        }));
        Self { entries }
    }
}

/// Faces at the edge to the ring's vertex `at`.
fn shared_faces(ring: &Ring<Site>, at: usize) -> i32 {
    neighbours_in_ring(ring, at).iter().flatten().count() as i32
}

/// The ring positions before and after `at`, where there are faces.
fn neighbours_in_ring(ring: &Ring<Site>, at: usize) -> [Option<usize>; 2] {
    let len = ring.around.len();
    let before = if at > 0 { Some(at - 1) } else { ring.closed.then_some(len - 1) };
    let after = if at + 1 < len { Some(at + 1) } else { ring.closed.then_some(0) };
    [before, after]
}

impl System {
    fn solve(&self, n: usize) -> Vec<i32> {
        let mut matrix = vec![0.0; n * n];
        let mut entries = self.entries.iter().map(|&x| f64::from(x));
        for i in 0..n {
            for (j, entry) in (i..n).zip(&mut entries) {
                matrix[i * n + j] = entry;
                matrix[j * n + i] = entry;
            }
        }
        solve(&matrix, &entries.collect::<Vec<f64>>())
    }
}
