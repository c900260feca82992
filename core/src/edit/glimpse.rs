//! What a coarse level shows at once of a step that is large: undone or redone there first, and everywhere after.

use super::apply::{Direction, Settling, Sizes, add_up_to};
use super::{Deltas, Step};
use crate::hierarchy::Level;
use crate::surface::{Changes, Surface};

/// Vertices that a level may have to be shown in place of another: followed and sampled, some 5 ms on one core.
const MOST_SHOWN: usize = 1 << 17;
/// Coefficients that may be read and changed: as long.
const MOST_CHANGED: usize = 1 << 14;
/// Scaling coefficients that may move where what is coarser has to be analysed, vertex by vertex: as long.
const MOST_ANALYSED: usize = 1 << 14;

/// A step undone or redone up to a level, finer levels as they were. It has to be taken back before anything else changes
/// the surface.
#[derive(Debug, Clone)]
pub(crate) struct Glimpse {
    deltas: Deltas,
    reach: Level,
    direction: Direction,
    settling: Settling,
}

impl Step {
    /// The finest level, coarser than the last, that can show at once what going this way brings; none if the first level where
    /// anything moves is too fine for that.
    pub(crate) fn shown_at_once(&self, surface: &Surface, direction: Direction) -> Option<Level> {
        if self.reshapes() {
            return None;
        }
        let Sizes { scaling, wavelets } = &self.sizes;
        let details = wavelets.iter().map(|&(level, _)| level.finer()).min();
        let home = scaling.map(|(level, _)| level).or(details)?;
        if self.settling(direction) == Settling::Coarser
            && scaling.is_some_and(|(_, count)| count > MOST_ANALYSED)
        {
            return None;
        }
        let quick = |&seen: &Level| {
            let coarser = wavelets.iter().filter(|(level, _)| *level < seen);
            let changed = coarser.fold(0, |sum, &(_, count)| sum + count);
            changed <= MOST_CHANGED && surface.scaling(seen).len() <= MOST_SHOWN
        };
        (home.0..surface.finest().0).rev().map(Level).find(quick)
    }

    /// Levels coarser than scaling coefficients need not follow them if they are put back before anything reads those levels;
    /// but where their detail is changed after, it has to be added to what they then are.
    fn settling(&self, direction: Direction) -> Settling {
        let coarser = |(of, _): (Level, usize)| self.sizes.wavelets.iter().any(|&(level, _)| level < of);
        match direction {
            Direction::Forwards if self.sizes.scaling.is_some_and(coarser) => Settling::Coarser,
            _ => Settling::Nothing,
        }
    }

    /// Undoes or redoes the step on the levels up to `reach`. Cost: the support there.
    ///
    /// # Errors
    /// What is kept of the step cannot be read; nothing has changed.
    pub(crate) fn glimpse(
        &self,
        surface: &mut Surface,
        reach: Level,
        direction: Direction,
    ) -> std::io::Result<(Glimpse, Changes)> {
        let seen = self.sizes.wavelets.iter().filter(|(level, _)| *level < reach).count();
        let mut deltas = self.packed().unpack_first(seen)?;
        deltas.scaling = deltas.scaling.filter(|(level, _)| *level <= reach);
        let settling = self.settling(direction);
        let changes = add_up_to(surface, &deltas, reach, direction, settling);
        Ok((Glimpse { deltas, reach, direction, settling }, changes))
    }
}

impl Glimpse {
    /// Puts the surface back, bit for bit.
    pub(crate) fn take_back(self, surface: &mut Surface) -> Changes {
        let back = match self.direction {
            Direction::Forwards => Direction::Backwards,
            Direction::Backwards => Direction::Forwards,
        };
        let mut changes = add_up_to(surface, &self.deltas, self.reach, back, self.settling);
        changes.beyond_limit = false;
        changes
    }
}
