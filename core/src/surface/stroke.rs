//! Many small changes of one level: finer levels follow each, coarser ones wait until the hand rests.
//!
//! Nothing coarser than the edited level is read while a hand works there, and analysis depends on the positions alone,
//! so one analysis at the end gives the bits that one after every change would give.

use super::local::{Step, runs_of};
use super::{Changes, LIMIT, Runs, Surface, Vector};
use crate::hierarchy::{Level, PublicId, Slot};
use crate::wavelet::lifting::plus;
use crate::wavelet::rows::add_steps;

impl Surface {
    /// Adds to `c^j` and everything finer in the support, leaving what is coarser as it was. Slots must differ. Cost: the
    /// support. The surface is whole again after [`Surface::settle`].
    pub(crate) fn raise(&mut self, level: Level, deltas: &[(Slot, Vector)]) -> Changes {
        self.raise_up_to(level, deltas, self.finest())
    }

    /// [`Surface::raise`] without the levels finer than `reach`, as [`Surface::raise_runs`].
    pub(crate) fn raise_up_to(&mut self, level: Level, deltas: &[(Slot, Vector)], reach: Level) -> Changes {
        let (runs, steps) = in_order(deltas);
        self.raise_runs(level, (&runs, &steps), reach)
    }

    /// [`Surface::raise`] slot by slot over runs of them, and without the levels finer than `reach`, which stay as they
    /// were. The surface is whole again once the same is subtracted with the same reach; or, where the reach is the finest
    /// level, after [`Surface::settle`].
    pub(crate) fn raise_runs(
        &mut self,
        level: Level,
        (runs, steps): (&Runs, &[Vector]),
        reach: Level,
    ) -> Changes {
        let mut changes = Changes::none(self.scaling.len());
        if steps.iter().all(|step| *step == [0; 3]) {
            return changes;
        }
        let mut rest = steps;
        for run in runs.iter() {
            let (steps, after) = rest.split_at(run.len());
            let values = &mut self.scaling[level.index()][run.start as usize..run.end as usize];
            if level == Level::BASE {
                for ((id, &old), &step) in run.zip(values.iter()).zip(steps) {
                    self.sum.replace(PublicId(id), old, plus(old, step));
                }
            }
            changes.beyond_limit |= add_steps(values, steps, LIMIT);
            rest = after;
        }
        changes.record(level, runs.clone());
        if reach > level {
            let steps: Vec<Step> = runs.slots().zip(steps.iter().copied()).collect();
            self.climb(reach, level, &steps, &mut changes);
        }
        self.follow_bounds(&changes);
        changes
    }

    /// Brings the coefficients coarser than `c^j` up to date with what has changed in these runs of slots. Cost: what
    /// depends on them.
    pub(crate) fn settle(&mut self, level: Level, runs: &Runs) -> Changes {
        let mut changes = Changes::none(self.scaling.len());
        let layout = self.hierarchy.layout(level);
        let mut moved: Vec<_> = match level {
            Level::BASE => Vec::new(),
            _ => runs.slots().map(|slot| layout.site(slot)).collect(),
        };
        for j in (0..level.0).rev().map(Level) {
            moved = self.descend(j, &moved, &mut changes);
            let layout = self.hierarchy.layout(j);
            let slots = moved.iter().map(|&site| layout.slot(site).0).collect();
            changes.record(j, Runs::of_slots(slots));
        }
        changes
    }
}

/// Additions that are not zero, as runs of slots and what each of them gets.
pub(super) fn in_order(deltas: &[(Slot, Vector)]) -> (Runs, Vec<Vector>) {
    let mut deltas: Vec<Step> = deltas.iter().copied().filter(|&(_, delta)| delta != [0; 3]).collect();
    deltas.sort_unstable_by_key(|&(slot, _)| slot);
    (runs_of(&deltas), deltas.into_iter().map(|(_, delta)| delta).collect())
}
