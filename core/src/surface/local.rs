//! Local re-synthesis and local analysis: the cost follows the edit, the result is that of the whole transform.
//!
//! An edit at level j changes a set of vertices there. Downwards, predict and update are repeated for exactly the
//! coefficients whose inputs changed, vertex by vertex, for they are few; upwards, where the support grows fourfold a
//! level, whole runs of rows go through [`refine`].

use super::stroke::in_order;
use super::{Changes, LIMIT, Marks, Runs, Surface, Vector, within_limit};
use crate::hierarchy::{Layout, Level, Odd, PublicId, Site, Slot};
use crate::wavelet::lifting::{minus, plus, predicted, rounded};
use crate::wavelet::rows::{Patch, refine};

/// A change of position: what was added to `c^j` at a slot.
pub(super) type Step = (Slot, Vector);

impl Surface {
    /// Adds to scaling coefficients of level j: `c^j`, everything finer in their support, and every coarser
    /// coefficient that depends on them. Slots must differ. Cost: the support.
    pub fn add_scaling(&mut self, level: Level, deltas: &[(Slot, Vector)]) -> Changes {
        self.add_scaling_up_to(level, deltas, self.finest())
    }

    /// [`Surface::add_scaling`] without the levels finer than `reach`, which stay as they were: for showing a coarse
    /// level while a hand moves. The surface is whole again once the same is subtracted with the same reach.
    pub(crate) fn add_scaling_up_to(
        &mut self,
        level: Level,
        deltas: &[(Slot, Vector)],
        reach: Level,
    ) -> Changes {
        let (runs, steps) = in_order(deltas);
        let mut changes = self.raise_runs(level, (&runs, &steps), reach);
        changes.join(self.settle(level, &runs));
        changes
    }

    /// Adds to wavelet coefficients of level j: `d^j` and everything finer in their support. Coarser levels, and
    /// `c^j` itself, stay. Odd vertices must differ. Cost: the support.
    pub fn add_wavelets(&mut self, level: Level, deltas: &[(Odd, Vector)]) -> Changes {
        self.add_wavelets_up_to(level, deltas, self.finest())
    }

    /// [`Surface::add_wavelets`] without the levels finer than `reach`, as [`Surface::add_scaling_up_to`].
    pub(crate) fn add_wavelets_up_to(
        &mut self,
        level: Level,
        deltas: &[(Odd, Vector)],
        reach: Level,
    ) -> Changes {
        let mut changes = Changes::none(self.scaling.len());
        let mut changed = Vec::with_capacity(deltas.len());
        for &(odd, delta) in deltas.iter().filter(|&&(_, delta)| delta != [0; 3]) {
            let new = plus(self.wavelets[level.index()][odd.index()], delta);
            self.store_wavelet(level, odd, new, &mut changes);
            changed.push(odd);
        }
        if reach > level {
            let steps = self.climb_from_details(level, &changed, &mut changes);
            changes.record(level.finer(), runs_of(&steps));
            self.climb(reach, level.finer(), &steps, &mut changes);
        }
        self.follow_bounds(&changes);
        changes
    }

    /// One level of local analysis: from the vertices of `M^{j+1}` that moved to those of `M^j` that did.
    pub(super) fn descend(&mut self, level: Level, moved: &[Site], changes: &mut Changes) -> Vec<Site> {
        let hierarchy = self.hierarchy.clone();
        let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
        let mut marks = std::mem::take(&mut self.marks);
        let [odds, evens] = &mut marks;

        // Details whose own vertex or whose parents moved. The fine neighbours of an even vertex are odd.
        odds.reset(coarse.odd_len());
        evens.reset(coarse.len());
        for &site in moved {
            match Layout::coarsen(site) {
                None => {
                    odds.insert(coarse.odd_at(site).0, site);
                }
                Some(even) => {
                    evens.insert(coarse.slot(even).0, even);
                    fine.for_each_neighbour(site, |odd| {
                        odds.insert(coarse.odd_at(odd).0, odd);
                    });
                }
            }
        }
        let mut ends = Vec::with_capacity(2 * odds.members().len());
        for &(odd, site) in odds.members() {
            let finer = &self.scaling[level.index() + 1];
            let parents = coarse.parents(site);
            let at = |p| finer[fine.slot(Layout::refine(p)).index()];
            let (u, w) = (at(parents[0]), at(parents[1]));
            let detail = minus(finer[fine.slot(site).index()], predicted(u, w));
            if detail != self.wavelets[level.index()][odd as usize] {
                self.store_wavelet(level, Odd(odd), detail, changes);
                ends.extend(parents);
            }
        }
        // Even vertices that moved, and those in the discs of changed details.
        if let Some(k) = self.form.wavelet.disc_radius() {
            spread(coarse, &ends, k, odds, evens);
        }
        let mut steps = Vec::with_capacity(evens.members().len());
        for &(slot, site) in evens.members() {
            let finer = self.scaling[level.index() + 1][fine.slot(Layout::refine(site)).index()];
            let sum = self.filters.sum_within_limit(coarse, site, &self.wavelets[level.index()]);
            if self.store_scaling(level, Slot(slot), plus(finer, rounded(sum)), changes).is_some() {
                steps.push(site);
            }
        }
        self.marks = marks;
        steps
    }

    /// Local synthesis of the levels up to `reach` from the changes of `c^j`.
    pub(super) fn climb(&mut self, reach: Level, level: Level, steps: &[Step], changes: &mut Changes) {
        if reach <= level {
            return;
        }
        let mut patches = Patch::of(self.hierarchy.layout(level), steps);
        for j in level.0 + 1..=reach.0 {
            let fine = self.hierarchy.layout(Level(j));
            let finer = &mut self.scaling[usize::from(j)];
            let refined = refine(fine, &mut patches, finer, LIMIT, j == reach.0);
            changes.beyond_limit |= refined.beyond;
            changes.record(Level(j), Runs::of_runs(refined.runs));
        }
    }

    /// One level of local synthesis from changed details of level j, where `c^j` stays: the changes of `c^{j+1}`.
    fn climb_from_details(&mut self, level: Level, details: &[Odd], changes: &mut Changes) -> Vec<Step> {
        let hierarchy = self.hierarchy.clone();
        let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
        let mut marks = std::mem::take(&mut self.marks);
        let [odds, evens] = &mut marks;
        odds.reset(coarse.odd_len());
        evens.reset(coarse.len());

        // Even vertices in the discs of changed details are updated anew.
        let sites: Vec<Site> = details.iter().map(|&odd| coarse.odd_site(odd)).collect();
        if let Some(k) = self.form.wavelet.disc_radius() {
            let ends: Vec<Site> = sites.iter().flat_map(|&site| coarse.parents(site)).collect();
            spread(coarse, &ends, k, odds, evens);
        }
        odds.reset(coarse.odd_len());
        for (&odd, &site) in details.iter().zip(&sites) {
            odds.insert(odd.0, site);
        }
        let mut steps: Vec<Step> = Vec::with_capacity(4 * evens.members().len());
        for &(slot, site) in evens.members() {
            let sum = self.filters.sum_within_limit(coarse, site, &self.wavelets[level.index()]);
            let new = minus(self.scaling[level.index()][slot as usize], rounded(sum));
            let site = Layout::refine(site);
            if let Some(step) = self.store_scaling(level.finer(), fine.slot(site), new, changes) {
                steps.push(step);
                fine.for_each_neighbour(site, |odd| {
                    odds.insert(coarse.odd_at(odd).0, odd);
                });
            }
        }
        // Odd vertices whose detail or whose parents changed are predicted anew.
        for &(odd, site) in odds.members() {
            let finer = &self.scaling[level.index() + 1];
            let at = |p| finer[fine.slot(Layout::refine(p)).index()];
            let [p, q] = coarse.parents(site);
            let (u, w) = (at(p), at(q));
            let new = plus(self.wavelets[level.index()][odd as usize], predicted(u, w));
            steps.extend(self.store_scaling(level.finer(), fine.slot(site), new, changes));
        }
        self.marks = marks;
        steps
    }

    /// Writes one position; the step it made, if any.
    fn store_scaling(
        &mut self,
        level: Level,
        slot: Slot,
        new: Vector,
        changes: &mut Changes,
    ) -> Option<Step> {
        let value = &mut self.scaling[level.index()][slot.index()];
        let old = std::mem::replace(value, new);
        if old == new {
            return None;
        }
        changes.beyond_limit |= !new.iter().all(|&x| within_limit(x));
        if level == Level::BASE {
            self.sum.replace(PublicId(slot.0), old, new);
        }
        Some((slot, minus(new, old)))
    }

    pub(super) fn store_wavelet(&mut self, level: Level, odd: Odd, new: Vector, changes: &mut Changes) {
        let id = self.wavelet_id(level, odd);
        let old = std::mem::replace(&mut self.wavelets[level.index()][odd.index()], new);
        changes.beyond_limit |= !new.iter().all(|&x| within_limit(x));
        self.sum.replace(id, old, new);
    }
}

pub(super) fn runs_of(steps: &[Step]) -> Runs {
    Runs::of_slots(steps.iter().map(|&(slot, _)| slot.0).collect())
}

/// Adds to `reached` everything within `k` edges of `ends`. `seen` is scratch space.
fn spread(layout: &Layout, ends: &[Site], k: u8, seen: &mut Marks, reached: &mut Marks) {
    seen.reset(layout.len());
    for &end in ends {
        seen.insert(layout.slot(end).0, end);
    }
    let mut from = 0;
    for _ in 0..k {
        let to = seen.members().len();
        for at in from..to {
            layout.for_each_neighbour(seen.members()[at].1, |neighbour| {
                seen.insert(layout.slot(neighbour).0, neighbour);
            });
        }
        from = to;
    }
    for &(slot, site) in seen.members() {
        reached.insert(slot, site);
    }
}
