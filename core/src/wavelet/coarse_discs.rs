//! Weights on levels so coarse that next to every disc is irregular: neighbours are listed once, and a disc that has been solved is
//! known again by who neighbours whom in it.

use super::Wavelet;
use super::solving::{LANES, Systems};
use super::weights::{WeightSolver, is_on_sharp};
use crate::hierarchy::{Layout, Odd, Slot};
use rayon::prelude::*;
use rustc_hash::FxHashSet;
use std::borrow::Borrow;
use std::hash::{Hash, Hasher};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

/// Larger discs are left to the solver: neighbours in a disc are bits of a word.
const LARGEST: usize = 64;
/// Words of a key for each vertex of a disc, and for the halved edge.
const PER_VERTEX: usize = 3;
const EDGE: usize = 4;
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

/// A disc: what it is known by, and its weights once they are solved.
struct Disc {
    key: Box<[u64]>,
    weights: OnceLock<Vec<i32>>,
}

impl Disc {
    /// How many vertices it has.
    fn len(&self) -> usize {
        (self.key.len() - EDGE) / PER_VERTEX
    }
}

/// A disc that is found by its key.
struct ByKey(Arc<Disc>);

impl Borrow<[u64]> for ByKey {
    fn borrow(&self) -> &[u64] {
        &self.0.key
    }
}

impl Hash for ByKey {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.0.key.hash(state);
    }
}

impl PartialEq for ByKey {
    fn eq(&self, other: &Self) -> bool {
        self.0.key == other.0.key
    }
}

impl Eq for ByKey {}

/// The discs that have been met.
#[derive(Default)]
pub(super) struct CoarseDiscs {
    met: Mutex<FxHashSet<ByKey>>,
}

/// The discs of a run of odd vertices, of which some have not been solved.
pub(super) struct Run<'a> {
    discs: &'a CoarseDiscs,
    /// Which disc's weights taps are to get, and where these begin.
    waiting: Vec<(Arc<Disc>, usize)>,
}

impl CoarseDiscs {
    pub(super) fn run(&self) -> Run<'_> {
        Run { discs: self, waiting: Vec::new() }
    }

    fn disc(&self, key: &[u64]) -> Arc<Disc> {
        // Whole discs go in, so a panic of another thread leaves nothing half done.
        let mut met = self.met.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(ByKey(disc)) = met.get(key) {
            return disc.clone();
        }
        let disc = Arc::new(Disc { key: key.into(), weights: OnceLock::new() });
        met.insert(ByKey(disc.clone()));
        disc
    }
}

impl Run<'_> {
    /// Adds a tap, by slot, for each vertex that an odd one updates; its weight may be missing until [`Run::finish`]. Cost: the
    /// disc's rings.
    pub(super) fn updated(
        &mut self,
        solver: &WeightSolver,
        (layout, rings): (&Layout, &Rings),
        (odd, k): (Odd, u8),
        scratch: &mut Scratch,
        taps: &mut Vec<(u32, i32)>,
    ) {
        let site = layout.odd_site(odd);
        let parents = layout.parents(site).map(|site| layout.slot(site).0);
        if is_on_sharp(layout, site) || !scratch.look_at(rings, parents, k) {
            let stencil = solver.stencil(layout, site, Wavelet::Disc(k));
            taps.extend(stencil.vertices.iter().map(|&v| layout.slot(v).0).zip(stencil.weights));
            return;
        }
        self.waiting.push((self.discs.disc(&scratch.key), taps.len()));
        taps.extend(scratch.disc.iter().map(|&slot| (slot, 0)));
    }

    /// Solves what is to be solved, and fills in the weights.
    pub(super) fn finish(self, taps: &mut [(u32, i32)]) {
        let discs = self.waiting.iter().map(|(disc, _)| &**disc);
        let mut unsolved: Vec<&Disc> = discs.filter(|disc| disc.weights.get().is_none()).collect();
        // Those of a size beside each other: no lane is idle.
        unsolved.sort_by_key(|disc| (disc.len(), &raw const **disc));
        unsolved.dedup_by_key(|disc| &raw const **disc);
        let mut systems = Systems::default();
        for beside in unsolved.chunks(LANES) {
            systems.start(beside.iter().map(|disc| disc.len()));
            beside.iter().enumerate().for_each(|(lane, disc)| assemble(&mut systems, lane, disc));
            for (disc, weights) in beside.iter().zip(systems.solve()) {
                // Another thread may have been faster, with the same.
                let _ = disc.weights.set(weights);
            }
        }
        for (disc, from) in &self.waiting {
            let weights = disc.weights.get().expect("solved by now");
            taps[*from..].iter_mut().zip(weights).for_each(|((_, tap), &weight)| *tap = weight);
        }
    }
}

/// The system of a disc, from what it is known by: for each vertex of it the neighbours in it across edges of two faces and of
/// one, and its own faces; then the faces at the halved edge, its ends, and the vertices across either face.
fn assemble(systems: &mut Systems, lane: usize, disc: &Disc) {
    let (rows, edge) = disc.key.split_at(PER_VERTEX * disc.len());
    for (at, of) in rows.chunks_exact(PER_VERTEX).enumerate() {
        for (faces, mut neighbours) in [(2.0, of[0]), (1.0, of[1])] {
            while neighbours != 0 {
                systems.set(lane, [at, neighbours.trailing_zeros() as usize], 4.0 * faces);
                neighbours &= neighbours - 1;
            }
        }
        let is = |bits: u64| bits >> at & 1;
        let right = if is(edge[1]) == 1 { 5 * edge[0] } else { 2 * (is(edge[2]) + is(edge[3])) };
        systems.set_sides(lane, at, (8 * of[2]) as f64, right as f64);
    }
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
            if rings.closed[slot as usize] {
                beside = [around.iter().fold(0, |bits, &neighbour| bits | bit(neighbour)); 2];
            } else {
                for (at, &neighbour) in around.iter().enumerate() {
                    let bit = bit(neighbour);
                    for (beside, there) in beside.iter_mut().zip(rings.faces_beside(slot, at)) {
                        *beside |= if there { bit } else { 0 };
                    }
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
