//! Weights on levels so coarse that next to every disc is irregular: neighbours are listed once, and a disc that has been solved is
//! known again by who neighbours whom in it.

use super::Wavelet;
use super::weights::{self, WeightSolver, is_on_sharp};
use crate::hierarchy::{Layout, Odd, Slot};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Larger discs are left to the solver: neighbours in a disc are bits of a word.
const LARGEST: usize = 64;
/// The place of a vertex that a sharp edge keeps out of a disc.
const LEFT_OUT: u32 = 255;

/// The rings of all vertices of a level, by slot.
pub(super) struct Rings {
    starts: Vec<u32>,
    around: Vec<u32>,
    closed: Vec<bool>,
    on_sharp: Vec<bool>,
}

impl Rings {
    pub(super) fn new(layout: &Layout) -> Self {
        let slots = (0..layout.len()).into_par_iter().with_min_len(256);
        let rings = slots.map(|slot| {
            let site = layout.site(Slot(slot));
            (layout.ring(site), is_on_sharp(layout, site))
        });
        let rings: Vec<_> = rings.collect();
        let mut starts = Vec::with_capacity(rings.len() + 1);
        starts.push(0);
        let mut around = Vec::with_capacity(6 * rings.len());
        for (ring, _) in &rings {
            around.extend(ring.around.iter().map(|&site| layout.slot(site).0));
            starts.push(around.len() as u32);
        }
        let closed = rings.iter().map(|(ring, _)| ring.closed).collect();
        Self { starts, around, closed, on_sharp: rings.iter().map(|&(_, sharp)| sharp).collect() }
    }

    fn of(&self, slot: u32) -> &[u32] {
        let slot = slot as usize;
        &self.around[self.starts[slot] as usize..self.starts[slot + 1] as usize]
    }

    /// Whether there is a face on either side of the edge to the ring's vertex `at`.
    fn faces_beside(&self, slot: u32, at: usize) -> [bool; 2] {
        let closed = self.closed[slot as usize];
        [closed || at > 0, closed || at + 1 < self.of(slot).len()]
    }
}

/// What a thread looks up discs with.
#[derive(Default)]
pub(super) struct Scratch {
    /// By slot: in which disc a vertex was last, and where there.
    places: Vec<[u32; 2]>,
    discs: u32,
    disc: Vec<u32>,
    key: Vec<u64>,
}

/// Discs that have been solved.
#[derive(Default)]
pub(super) struct CoarseDiscs {
    solved: Mutex<FxHashMap<Vec<u64>, Arc<[i32]>>>,
}

impl CoarseDiscs {
    /// Calls back for each vertex that an odd one updates, by slot, with its weight. Cost: the disc's rings; once for each
    /// kind of disc what solving it takes.
    pub(super) fn updated(
        &self,
        solver: &WeightSolver,
        (layout, rings): (&Layout, &Rings),
        (odd, k): (Odd, u8),
        scratch: &mut Scratch,
        mut found: impl FnMut(u32, i32),
    ) {
        let site = layout.odd_site(odd);
        let parents = layout.parents(site).map(|site| layout.slot(site).0);
        if is_on_sharp(layout, site) || !scratch.look_at(rings, parents, k) {
            let stencil = solver.stencil(layout, site, Wavelet::Disc(k));
            let taps = stencil.vertices.iter().zip(&stencil.weights);
            taps.for_each(|(&v, &weight)| found(layout.slot(v).0, weight));
            return;
        }
        let solved = || self.solved.lock().unwrap_or_else(PoisonError::into_inner);
        let known = solved().get(scratch.key.as_slice()).cloned();
        let weights = known.unwrap_or_else(|| {
            let weights: Arc<[i32]> = solve(&scratch.key, scratch.disc.len()).into();
            solved().insert(scratch.key.clone(), weights.clone());
            weights
        });
        scratch.disc.iter().zip(&*weights).for_each(|(&slot, &weight)| found(slot, weight));
    }
}

/// The weights of a disc, from what it is known by: for each vertex of it the neighbours in it across edges of two faces and of
/// one, and its own faces; then the faces at the halved edge, its ends, and the vertices across either face.
fn solve(key: &[u64], n: usize) -> Vec<i32> {
    let (rows, edge) = key.split_at(3 * n);
    let mut matrix = vec![0.0; n * n];
    for (at, (row, of)) in matrix.chunks_exact_mut(n.max(1)).zip(rows.chunks_exact(3)).enumerate() {
        for (neighbour, entry) in row.iter_mut().enumerate() {
            *entry = (4 * (2 * (of[0] >> neighbour & 1) + (of[1] >> neighbour & 1))) as f64;
        }
        row[at] = (8 * of[2]) as f64;
    }
    let right: Vec<f64> = (0..n)
        .map(|at| {
            let is = |bits: u64| bits >> at & 1;
            let value = if is(edge[1]) == 1 { 5 * edge[0] } else { 2 * (is(edge[2]) + is(edge[3])) };
            value as f64
        })
        .collect();
    weights::solve(&matrix, &right)
}

impl Scratch {
    /// Finds the disc around an edge, in the order in which the solver has it, and what its weights follow from; whether it is
    /// small enough.
    fn look_at(&mut self, rings: &Rings, parents: [u32; 2], k: u8) -> bool {
        let Self { places, discs, disc, key } = self;
        places.resize(rings.closed.len(), [0; 2]);
        *discs += 1;
        disc.clear();
        for slot in parents {
            places[slot as usize] = [*discs, LEFT_OUT];
            disc.push(slot);
        }
        let mut from = 0;
        for _ in 0..k {
            let to = disc.len();
            for at in from..to {
                for &slot in rings.of(disc[at]) {
                    if places[slot as usize][0] != *discs {
                        places[slot as usize] = [*discs, LEFT_OUT];
                        disc.push(slot);
                    }
                }
            }
            from = to;
        }
        disc.retain(|&slot| !rings.on_sharp[slot as usize]);
        if disc.len() > LARGEST {
            return false;
        }
        for (place, &slot) in (0..).zip(&*disc) {
            places[slot as usize][1] = place;
        }
        key.clear();
        let place = |slot: u32| match places[slot as usize] {
            [of, place] if of == *discs && place != LEFT_OUT => Some(place),
            _ => None,
        };
        let bit = |slot: u32| place(slot).map_or(0, |place| 1u64 << place);
        for &slot in &*disc {
            let around = rings.of(slot);
            // Neighbours in the disc, with a face on the one side of the edge, and on the other.
            let mut beside = [0u64; 2];
            for (at, &neighbour) in around.iter().enumerate() {
                let bit = bit(neighbour);
                for (beside, there) in beside.iter_mut().zip(rings.faces_beside(slot, at)) {
                    *beside |= if there { bit } else { 0 };
                }
            }
            let faces = around.len() as u64 - u64::from(!rings.closed[slot as usize]);
            key.extend([beside[0] & beside[1], beside[0] ^ beside[1], faces]);
        }
        // The halved edge: its ends, and what lies across its faces.
        let around = rings.of(parents[0]);
        let at = around.iter().position(|&slot| slot == parents[1]).expect("parents are neighbours");
        let [before, after] = rings.faces_beside(parents[0], at);
        let len = around.len();
        key.push(u64::from(before) + u64::from(after));
        key.push(bit(parents[0]) | bit(parents[1]));
        key.push(if before { bit(around[(at + len - 1) % len]) } else { 0 });
        key.push(if after { bit(around[(at + 1) % len]) } else { 0 });
        true
    }
}
