//! The rows of the filter bank that the constant stencil does not serve: one for each irregular even vertex.

use super::Wavelet;
use super::regular_disc::RegularDisc;
use super::regularity::{irregular_sites, is_coarse};
use super::weights::WeightSolver;
use crate::hierarchy::{Layout, Odd, Slot};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Odd vertices looked at one after another by one thread.
const RUN: usize = 256;

/// The rows of one level.
#[derive(Debug, Default)]
pub(super) struct ExplicitRows {
    /// The row of a slot; empty on coarse levels, where every vertex has one, in their order.
    numbers: FxHashMap<u32, u32>,
    /// Where each row begins, and where the last ends.
    starts: Vec<u32>,
    /// Those of a row by odd vertex.
    taps: Vec<(Odd, i32)>,
}

impl ExplicitRows {
    /// Collects them in parallel; the same for any number of threads. Cost: the irregular vertices and what updates them.
    pub(super) fn new(
        solver: &WeightSolver,
        regular: &RegularDisc,
        layout: &Layout,
        wavelet: Wavelet,
    ) -> Self {
        let Wavelet::Disc(k) = wavelet else { return Self::default() };
        let (numbers, count, odds) = if is_coarse(layout, wavelet) {
            (FxHashMap::default(), layout.len(), (0..layout.odd_len()).map(Odd).collect())
        } else {
            let sites = irregular_sites(layout, wavelet);
            let numbers = sites.iter().zip(0..).map(|(&site, at)| (layout.slot(site).0, at)).collect();
            // Every odd vertex whose disc can reach one of these: edges with an end within k edges of one.
            let mut odds: Vec<Odd> = layout
                .disc(&sites, k)
                .par_iter()
                .with_min_len(RUN)
                .flat_map_iter(|&end| {
                    let around = layout.ring(end).around.into_iter();
                    around.map(move |neighbour| layout.odd_at(layout.midpoint(end, neighbour)))
                })
                .collect();
            odds.par_sort_unstable();
            odds.dedup();
            (numbers, sites.len() as u32, odds)
        };
        let number = |slot: Slot| match numbers.is_empty() {
            true => Some(slot.0),
            false => numbers.get(&slot.0).copied(),
        };
        let taps_of = |&odd: &Odd| {
            let site = layout.odd_site(odd);
            let stencil =
                regular.stencil(layout, site).unwrap_or_else(|| solver.stencil(layout, site, wavelet));
            let taps = stencil.vertices.into_iter().zip(stencil.weights);
            taps.filter_map(move |(v, weight)| Some((number(layout.slot(v))?, odd, weight)))
        };
        let by_odd: Vec<(u32, Odd, i32)> = odds.par_iter().with_min_len(RUN).flat_map_iter(taps_of).collect();

        // Counted into rows; within a row they stay in the order of the odd vertices.
        let mut starts = vec![0; count as usize + 1];
        by_odd.iter().for_each(|&(row, ..)| starts[row as usize + 1] += 1);
        for row in 0..count as usize {
            starts[row + 1] += starts[row];
        }
        let (mut next, mut taps) = (starts.clone(), vec![(Odd(0), 0); by_odd.len()]);
        for (row, odd, weight) in by_odd {
            let at = &mut next[row as usize];
            taps[*at as usize] = (odd, weight);
            *at += 1;
        }
        Self { numbers, starts, taps }
    }

    /// The taps of an irregular vertex.
    pub(super) fn row(&self, slot: Slot) -> &[(Odd, i32)] {
        let at = match self.numbers.is_empty() {
            true => slot.index(),
            false => *self.numbers.get(&slot.0).expect("irregular vertices have explicit rows") as usize,
        };
        &self.taps[self.starts[at] as usize..self.starts[at + 1] as usize]
    }
}
