//! What the next undo or redo will bring, shown on a coarse level before all levels follow.

use super::Session;
use crate::edit::Direction;
use crate::hierarchy::Level;
use crate::surface::Changes;

impl Session {
    /// The finest level that can show at once what the next undo brings, for surfaces too large to follow whole; none if there is
    /// nothing to undo or no level coarser than the last can. The same on every machine. For [`Session::preview_undo`].
    pub fn undo_shown_at_once(&self) -> Option<Level> {
        self.step_shown_at_once(self.record.head().checked_sub(1)?, Direction::Backwards)
    }

    /// [`Session::undo_shown_at_once`] of the next redo.
    pub fn redo_shown_at_once(&self) -> Option<Level> {
        self.step_shown_at_once(self.record.head(), Direction::Forwards)
    }

    /// Puts the levels up to `reach` where the next undo leaves them; finer ones and the history stay, and the hash means nothing
    /// meanwhile. Whatever is asked of the session next that changes it, [`Session::undo`] too, takes this back first, bit for
    /// bit. Cost: the support on those levels.
    pub fn preview_undo(&mut self, reach: Level) -> Changes {
        self.preview_step(self.record.head().checked_sub(1), reach, Direction::Backwards)
    }

    /// [`Session::preview_undo`] of the next redo.
    pub fn preview_redo(&mut self, reach: Level) -> Changes {
        self.preview_step(Some(self.record.head()), reach, Direction::Forwards)
    }

    fn step_shown_at_once(&self, at: usize, direction: Direction) -> Option<Level> {
        self.record.entries().nth(at)?.as_ref().shown_at_once(&self.model.surface, direction)
    }

    fn preview_step(&mut self, at: Option<usize>, reach: Level, direction: Direction) -> Changes {
        self.end_stroke();
        let surface = &mut self.model.surface;
        let step = at.and_then(|at| self.record.entries().nth(at)).map(AsRef::as_ref);
        let Some(step) = step.filter(|step| !step.reshapes()) else { return Changes::nothing(surface) };
        match step.glimpse(surface, reach.min(surface.finest()), direction) {
            Ok((glimpse, changes)) => {
                self.glimpse = Some(glimpse);
                changes
            }
            // The step itself will say so.
            Err(_) => Changes::nothing(surface),
        }
    }

    /// Takes back what is shown before it is.
    pub(super) fn end_glimpse(&mut self) -> Changes {
        match self.glimpse.take() {
            Some(glimpse) => glimpse.take_back(&mut self.model.surface),
            None => Changes::default(),
        }
    }
}
