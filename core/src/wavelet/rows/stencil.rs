//! The constant stencil, its taps ordered by weight.

use super::window::Place;
use std::collections::BTreeMap;

/// The taps of the constant stencil by weight, in groups of six and twelve: the orbits of the lattice's symmetries.
#[derive(Debug)]
pub struct Stencil {
    sixes: Vec<(i32, [Place; 6])>,
    twelves: Vec<(i32, [Place; 12])>,
}

impl Stencil {
    /// From taps `(dr, di, weight)` in steps of level j + 1, relative to the even vertex.
    pub(crate) fn new(taps: impl Iterator<Item = (i32, i32, i32)>) -> Self {
        let mut classes: BTreeMap<i32, Vec<Place>> = BTreeMap::new();
        for (dr, di, weight) in taps {
            classes.entry(weight).or_default().push(Place::of_odd(dr, di));
        }
        let (mut sixes, mut twelves) = (Vec::new(), Vec::new());
        for (weight, places) in classes {
            let (pairs, rest) = places.as_chunks::<12>();
            twelves.extend(pairs.iter().map(|&group| (weight, group)));
            let (single, none) = rest.as_chunks::<6>();
            sixes.extend(single.iter().map(|&group| (weight, group)));
            assert!(none.is_empty(), "orbits have six or twelve members");
        }
        Self { sixes, twelves }
    }

    /// The taps as distances within an array, from the place of the even vertex in it.
    pub(super) fn placed(&self, offset: impl Fn(Place) -> u32) -> PlacedStencil {
        PlacedStencil {
            sixes: self.sixes.iter().map(|&(w, group)| (w, group.map(&offset))).collect(),
            twelves: self.twelves.iter().map(|&(w, group)| (w, group.map(&offset))).collect(),
        }
    }
}

/// A [`Stencil`] addressed within one array of details.
#[derive(Debug)]
pub(super) struct PlacedStencil {
    pub(super) sixes: Vec<(i32, [u32; 6])>,
    pub(super) twelves: Vec<(i32, [u32; 12])>,
}
