//! Local re-synthesis and local analysis: the cost follows the edit, the result is that of the whole transform.
//!
//! An edit at level j changes a set of vertices there. Downwards, predict and update are repeated for exactly the
//! coefficients whose inputs changed; upwards, even vertices pass their change on unaltered (the details that
//! update them did not change) and odd vertices are predicted anew.

use super::{Changes, Marks, Moved, Surface, Vector, within_limit};
use crate::hierarchy::{Layout, Level, Odd, PublicId, Site, Slot};
use crate::wavelet::lifting::{minus, plus, predicted, rounded};
use crate::wavelet::rows::synthesise_level;

/// A change of position: what was added to `c^j` at a slot.
type Step = (Slot, Vector);

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
        let mut changes = Changes::none(self.scaling.len());
        let steps: Vec<Step> = deltas.iter().copied().filter(|&(_, delta)| delta != [0; 3]).collect();
        for &(slot, delta) in &steps {
            let value = &mut self.scaling[level.index()][slot.index()];
            let old = *value;
            *value = plus(old, delta);
            changes.beyond_limit |= !value.iter().all(|&x| within_limit(x));
            if level == Level::BASE {
                let new = *value;
                self.sum.replace(PublicId(slot.0), old, new);
            }
        }
        let mut down = steps.clone();
        for j in (0..level.0).rev() {
            down = self.descend(Level(j), &down, &mut changes);
            record(&mut changes, Level(j), &down);
        }
        record(&mut changes, level, &steps);
        self.climb_to(reach, level, steps, &[], &mut changes);
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
        self.climb_to(reach, level, Vec::new(), &changed, &mut changes);
        changes
    }

    /// Replaces all wavelet coefficients of level j and re-synthesises the finer levels whole. `O(n_J)`. Returns
    /// the old coefficients beside the changes.
    ///
    /// # Panics
    /// If the block does not have the level's length.
    pub fn replace_wavelets(&mut self, level: Level, details: Vec<Vector>) -> (Vec<Vector>, Changes) {
        assert_eq!(details.len(), self.wavelets[level.index()].len());
        let old = std::mem::replace(&mut self.wavelets[level.index()], details);
        for j in level.0..self.finest().0 {
            let (scaling, wavelets) = (&self.scaling[usize::from(j)], &self.wavelets[usize::from(j)]);
            self.scaling[usize::from(j) + 1] =
                synthesise_level(&self.hierarchy, &self.filters, Level(j), scaling, wavelets);
        }
        self.sum = self.full_sum();
        let mut changes = Changes::none(self.scaling.len());
        changes.moved[level.index() + 1..].fill(Moved::Everything);
        changes.beyond_limit = !self.is_within_limit();
        (old, changes)
    }

    /// One level of local analysis: from the changes of `c^{j+1}` to those of `d^j` and `c^j`.
    fn descend(&mut self, level: Level, finer_steps: &[Step], changes: &mut Changes) -> Vec<Step> {
        let hierarchy = self.hierarchy.clone();
        let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
        let mut marks = std::mem::take(&mut self.marks);
        let [odds, evens] = &mut marks;

        // Details whose own vertex or whose parents moved. The fine neighbours of an even vertex are odd.
        odds.reset(coarse.odd_len());
        evens.reset(coarse.len());
        for &(slot, _) in finer_steps {
            let site = fine.site(slot);
            match Layout::coarsen(site) {
                None => {
                    odds.insert(coarse.odd_at(site).0);
                }
                Some(even) => {
                    evens.insert(coarse.slot(even).0);
                    fine.for_each_neighbour(site, |odd| {
                        odds.insert(coarse.odd_at(odd).0);
                    });
                }
            }
        }
        let radius = self.form.wavelet.disc_radius();
        let mut ends = Vec::new();
        for &odd in odds.members() {
            let odd = Odd(odd);
            let site = coarse.odd_site(odd);
            let parents = coarse.parents(site);
            let [u, w] =
                parents.map(|p| self.scaling[level.index() + 1][fine.slot(Layout::refine(p)).index()]);
            let own = self.scaling[level.index() + 1][fine.slot(site).index()];
            let detail = minus(own, predicted(u, w));
            if detail != self.wavelets[level.index()][odd.index()] {
                self.store_wavelet(level, odd, detail, changes);
                ends.extend(parents);
            }
        }
        // Even vertices that moved, and those in the discs of changed details.
        if let Some(k) = radius {
            spread(coarse, &ends, k, odds, evens);
        }
        let mut steps = Vec::new();
        for &slot in evens.members() {
            let slot = Slot(slot);
            let site = coarse.site(slot);
            let finer = self.scaling[level.index() + 1][fine.slot(Layout::refine(site)).index()];
            let new = plus(finer, rounded(self.filters.gather(coarse, site, &self.wavelets[level.index()])));
            if let Some(step) = self.store_scaling(level, slot, new, changes) {
                steps.push(step);
            }
        }
        self.marks = marks;
        steps
    }

    /// Local synthesis of the levels up to `reach` from the changes of `c^j` and the changed details of level j.
    fn climb_to(
        &mut self,
        reach: Level,
        level: Level,
        steps: Vec<Step>,
        details: &[Odd],
        changes: &mut Changes,
    ) {
        let mut steps = steps;
        for j in level.0..reach.0 {
            let changed = if j == level.0 { details } else { &[] };
            steps = self.climb(Level(j), &steps, changed, changes);
            record(changes, Level(j + 1), &steps);
        }
    }

    /// One level of local synthesis: from the changes of `c^j` and `d^j` to those of `c^{j+1}`.
    fn climb(
        &mut self,
        level: Level,
        coarser_steps: &[Step],
        details: &[Odd],
        changes: &mut Changes,
    ) -> Vec<Step> {
        let hierarchy = self.hierarchy.clone();
        let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
        let mut marks = std::mem::take(&mut self.marks);
        let [odds, evens] = &mut marks;
        odds.reset(coarse.odd_len());
        evens.reset(coarse.len());

        // Even vertices in the discs of changed details are updated anew.
        if let (Some(k), false) = (self.form.wavelet.disc_radius(), details.is_empty()) {
            let ends: Vec<_> = details.iter().flat_map(|&odd| coarse.parents(coarse.odd_site(odd))).collect();
            spread(coarse, &ends, k, odds, evens);
        }
        let mut steps: Vec<Step> = Vec::with_capacity(4 * coarser_steps.len());
        for &slot in evens.members() {
            let site = coarse.site(Slot(slot));
            let sum = self.filters.gather(coarse, site, &self.wavelets[level.index()]);
            let new = minus(self.scaling[level.index()][slot as usize], rounded(sum));
            let at = fine.slot(Layout::refine(site));
            steps.extend(self.store_scaling(level.finer(), at, new, changes));
        }
        // All others pass their change on.
        for &(slot, delta) in coarser_steps.iter().filter(|(slot, _)| !evens.contains(slot.0)) {
            let at = fine.slot(Layout::refine(coarse.site(slot)));
            let new = plus(self.scaling[level.index() + 1][at.index()], delta);
            steps.extend(self.store_scaling(level.finer(), at, new, changes));
        }
        // Odd vertices whose detail or whose parents changed are predicted anew.
        odds.reset(coarse.odd_len());
        for odd in details {
            odds.insert(odd.0);
        }
        for &(slot, _) in &steps {
            fine.for_each_neighbour(fine.site(slot), |odd| {
                odds.insert(coarse.odd_at(odd).0);
            });
        }
        for &odd in odds.members() {
            let odd = Odd(odd);
            let site = coarse.odd_site(odd);
            let finer = &self.scaling[level.index() + 1];
            let [u, w] = coarse.parents(site).map(|p| finer[fine.slot(Layout::refine(p)).index()]);
            let new = plus(self.wavelets[level.index()][odd.index()], predicted(u, w));
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

    fn store_wavelet(&mut self, level: Level, odd: Odd, new: Vector, changes: &mut Changes) {
        let id = self.wavelet_id(level, odd);
        let old = std::mem::replace(&mut self.wavelets[level.index()][odd.index()], new);
        changes.beyond_limit |= !new.iter().all(|&x| within_limit(x));
        self.sum.replace(id, old, new);
    }
}

/// Adds to `reached` everything within `k` edges of `ends`. `seen` is scratch space.
fn spread(layout: &Layout, ends: &[Site], k: u8, seen: &mut Marks, reached: &mut Marks) {
    seen.reset(layout.len());
    for &end in ends {
        seen.insert(layout.slot(end).0);
    }
    let mut from = 0;
    for _ in 0..k {
        let to = seen.members().len();
        for at in from..to {
            let site = layout.site(Slot(seen.members()[at]));
            layout.for_each_neighbour(site, |neighbour| {
                seen.insert(layout.slot(neighbour).0);
            });
        }
        from = to;
    }
    for &slot in seen.members() {
        reached.insert(slot);
    }
}

fn record(changes: &mut Changes, level: Level, steps: &[Step]) {
    if !steps.is_empty() {
        changes.moved[level.index()] = Moved::Some(steps.iter().map(|&(slot, _)| slot).collect());
    }
}
