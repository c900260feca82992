//! The rows of the filter bank that the constant stencil does not serve: one for each irregular even vertex.

use super::Wavelet;
use super::coarse_discs::{CoarseDiscs, Rings, Scratch};
use super::cones::{self, Cones, OnCoarsest, OnLevel};
use super::regular_disc::RegularDisc;
use super::regularity::{irregular_sites, is_coarse};
use super::weights::WeightSolver;
use crate::hierarchy::{BaseMesh, Layout, Odd, Slot};
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Odd vertices looked at one after another by one thread.
const RUN: usize = 256;

/// What is solved, or to be solved, whatever the level.
pub(super) struct Known {
    pub(super) solver: WeightSolver,
    pub(super) regular: RegularDisc,
    pub(super) cones: Cones,
    pub(super) coarse: CoarseDiscs,
}

impl Known {
    /// Cost: the base mesh's valences.
    pub(super) fn new(base: &BaseMesh, wavelet: Wavelet) -> Self {
        let solver = WeightSolver::default();
        let regular = RegularDisc::new(&solver, wavelet);
        let cones = cones::cones(&solver, &regular, base, wavelet);
        Self { solver, regular, cones, coarse: CoarseDiscs::default() }
    }
}

/// The rows of one level.
#[derive(Debug, Default)]
pub(super) struct ExplicitRows {
    /// The row of a slot; empty on coarse levels, where every vertex has one, in their order.
    numbers: FxHashMap<u32, u32>,
    /// The vertex of each row, by slot; empty on coarse levels.
    slots: Vec<u32>,
    /// Where each row begins, and where the last ends.
    starts: Vec<u32>,
    /// Those of a row, the last odd vertex last.
    taps: Vec<(Odd, i32)>,
}

impl ExplicitRows {
    /// Collects them in parallel; the same for any number of threads. Cost: the irregular vertices and what updates them.
    pub(super) fn new(known: &Known, (layout, finer): (&Layout, &Layout), wavelet: Wavelet) -> Self {
        let Wavelet::Disc(k) = wavelet else { return Self::default() };
        let base = layout.base();
        let all_apexes = (0..base.vertex_count()).all(|v| cones::is_apex(base, v));
        if is_coarse(layout, wavelet) {
            let odds: Vec<Odd> = (0..layout.odd_len()).map(Odd).collect();
            let at_coarsest = layout.level() == cones::COARSEST;
            let cones = at_coarsest.then(|| OnCoarsest::new(&known.cones, (layout, finer)));
            // Every odd vertex is near some base vertex.
            let rings = (cones.is_none() || !all_apexes).then(|| Rings::new(layout));
            let (starts, taps) =
                collected(&odds, layout.len(), cones.as_ref(), |run, scratch, found, ends| {
                    let mut discs = known.coarse.run();
                    for &odd in run {
                        if !cones.as_ref().is_some_and(|cones| cones.tells(odd)) {
                            let rings = rings.as_ref().expect("no cone for want of an apex alone");
                            discs.updated(&known.solver, (layout, rings), (odd, k), scratch, found);
                        }
                        ends.push(found.len());
                    }
                    discs.finish(found);
                });
            return Self { numbers: FxHashMap::default(), slots: Vec::new(), starts, taps };
        }
        let mut sites = if all_apexes { Vec::new() } else { irregular_sites(layout, wavelet) };
        sites.retain(|&site| !cones::is_in_cone(layout, site, k));
        let mut slots: Vec<u32> = sites.iter().map(|&site| layout.slot(site).0).collect();
        let mut numbers: FxHashMap<u32, u32> = slots.iter().zip(0..).map(|(&slot, at)| (slot, at)).collect();
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
        let (mut starts, mut taps) = collected(&odds, sites.len() as u32, None, |run, _, found, ends| {
            for &odd in run {
                let site = layout.odd_site(odd);
                let solve = || known.solver.stencil(layout, site, wavelet);
                let stencil = known.regular.stencil(layout, site).unwrap_or_else(solve);
                for (v, weight) in stencil.vertices.into_iter().zip(stencil.weights) {
                    if let Some(&row) = numbers.get(&layout.slot(v).0) {
                        found.push((row, weight));
                    }
                }
                ends.push(found.len());
            }
        });
        let cones: FxHashMap<usize, OnLevel> =
            known.cones.iter().map(|(&valence, cone)| (valence, cone.on(layout))).collect();
        for vertex in (0..base.vertex_count()).filter(|&v| cones::is_apex(base, v) && !base.is_regular(v)) {
            cones[&base.fan(vertex).corners.len()].each_row(vertex, &mut taps, |site, taps| {
                slots.push(layout.slot(site).0);
                starts.push(taps.len() as u32);
            });
        }
        numbers.reserve(slots.len() - numbers.len());
        numbers.extend((sites.len()..slots.len()).map(|at| (slots[at], at as u32)));
        Self { numbers, slots, starts, taps }
    }

    /// The irregular vertices of a level that is not coarse, by slot, each with its taps.
    pub(super) fn all(&self) -> impl IndexedParallelIterator<Item = (Slot, &[(Odd, i32)])> {
        let rows = self.starts.par_windows(2).map(|ends| &self.taps[ends[0] as usize..ends[1] as usize]);
        self.slots.par_iter().map(|&slot| Slot(slot)).zip(rows)
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

/// What odd vertices update, by row: where each begins, and the taps, which stay in the order of the odd vertices. `updated` tells
/// for a run of them what each updates that no cone tells, and where that ends.
fn collected(
    odds: &[Odd],
    count: u32,
    cones: Option<&OnCoarsest>,
    updated: impl Fn(&[Odd], &mut Scratch, &mut Vec<(u32, i32)>, &mut Vec<usize>) + Sync,
) -> (Vec<u32>, Vec<(Odd, i32)>) {
    let of_run = |scratch: &mut Scratch, run: &[Odd]| {
        let (mut found, mut ends) = (Vec::new(), Vec::with_capacity(run.len()));
        updated(run, scratch, &mut found, &mut ends);
        (found, ends)
    };
    let per_run = (odds.len() / 64).max(RUN);
    let by_odd: Vec<_> = odds.par_chunks(per_run).map_init(Scratch::default, of_run).collect();
    // What cones tell is asked again each time: that is less work than keeping it.
    let mut starts = vec![0; count as usize + 1];
    let mut count_one = |row: u32| starts[row as usize + 1] += 1;
    by_odd.iter().flat_map(|(found, _)| found).for_each(|&(row, _)| count_one(row));
    if let Some(cones) = cones {
        odds.iter().for_each(|&odd| _ = cones.updated(odd, |row, _| count_one(row)));
    }
    for row in 0..count as usize {
        starts[row + 1] += starts[row];
    }
    let mut next = starts.clone();
    let mut taps = vec![(Odd(0), 0); starts[count as usize] as usize];
    let mut put = |row: u32, odd: Odd, weight: i32| {
        let at = &mut next[row as usize];
        taps[*at as usize] = (odd, weight);
        *at += 1;
    };
    for (run, (found, ends)) in odds.chunks(per_run).zip(&by_odd) {
        let mut from = 0;
        for (&odd, &end) in run.iter().zip(ends) {
            found[from..end].iter().for_each(|&(row, weight)| put(row, odd, weight));
            if let Some(cones) = cones {
                cones.updated(odd, |row, weight| put(row, odd, weight));
            }
            from = end;
        }
    }
    (starts, taps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::{Hierarchy, Level};
    use crate::mesh::shapes;
    use crate::wavelet::Filters;
    use std::sync::Arc;

    /// Whatever way weights are found, they are those that are solved for each odd vertex on its own.
    #[test]
    fn rows_hold_what_every_odd_vertex_solves() {
        for (name, mesh) in shapes::awkward() {
            for sharp in [0, 3] {
                let marks: Vec<[u32; 2]> = mesh.faces.iter().take(sharp).map(|f| [f[0], f[1]]).collect();
                let base =
                    BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &marks).expect(name);
                let finest = if mesh.faces.len() > 24 { Level(4) } else { Level(5) };
                let hierarchy = Hierarchy::new(Arc::new(base), finest).expect("small");
                for wavelet in Wavelet::ALL {
                    let filters = Filters::new(&hierarchy, wavelet).expect("small valences");
                    let solver = WeightSolver::default();
                    for j in 0..finest.0 {
                        let layout = hierarchy.layout(Level(j));
                        let mut wanted = vec![Vec::new(); layout.len() as usize];
                        for odd in (0..layout.odd_len()).map(Odd) {
                            let stencil = solver.stencil(layout, layout.odd_site(odd), wavelet);
                            for (&v, &weight) in stencil.vertices.iter().zip(&stencil.weights) {
                                wanted[layout.slot(v).index()].push((odd, weight));
                            }
                        }
                        for (slot, wanted) in (0..).zip(wanted) {
                            let mut found = Vec::new();
                            let site = layout.site(Slot(slot));
                            filters.for_each_tap(layout, site, |odd, weight| found.push((odd, weight)));
                            if let Some(row) = filters.explicit_row(layout, site) {
                                assert!(row.iter().max() == row.last(), "{name}: the last comes last");
                            }
                            found.sort_unstable();
                            assert!(found == wanted, "{name}, {wavelet}, level {j}, {sharp} marks: {site:?}");
                        }
                    }
                }
            }
        }
    }
}
