//! A stroke's many small changes of one level: finer levels follow each, coarser ones wait for the stroke's end.
//!
//! Nothing coarser than the edited level is read while brushes work there, and analysis depends on the positions alone,
//! so one analysis at the end gives the bits that one after every change would give.

use super::local::runs_of;
use super::{Changes, Surface, Vector, within_limit};
use crate::hierarchy::{Level, PublicId, Slot};
use crate::wavelet::lifting::plus;

impl Surface {
    /// Adds to `c^j` and everything finer in the support, leaving what is coarser as it was. Slots must differ. Cost: the
    /// support. The surface is whole again after [`Surface::settle`].
    pub(crate) fn raise(&mut self, level: Level, deltas: &[(Slot, Vector)]) -> Changes {
        let mut changes = Changes::none(self.scaling.len());
        let steps: Vec<_> = deltas.iter().copied().filter(|&(_, delta)| delta != [0; 3]).collect();
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
        changes.record(level, runs_of(&steps));
        self.climb(self.finest(), level, &steps, &mut changes);
        self.follow_bounds(&changes);
        changes
    }

    /// Brings the coefficients coarser than `c^j` up to date with what [`Surface::raise`] changed at these slots.
    pub(crate) fn settle(&mut self, level: Level, slots: &[Slot]) -> Changes {
        let mut changes = Changes::none(self.scaling.len());
        let layout = self.hierarchy.layout(level);
        let mut moved: Vec<_> = slots.iter().map(|&slot| layout.site(slot)).collect();
        for j in (0..level.0).rev().map(Level) {
            moved = self.descend(j, &moved, &mut changes);
            let layout = self.hierarchy.layout(j);
            let slots = moved.iter().map(|&site| layout.slot(site).0).collect();
            changes.record(j, super::Runs::of_slots(slots));
        }
        changes
    }
}
