//! The equaliser under the hand: the surface follows its gains, one line is logged at the end.

use super::{Session, SessionError};
use crate::edit::{Equalise, Equaliser, Over};
use crate::hierarchy::Level;
use crate::surface::Changes;

/// Vertices that a step of the equaliser may synthesise anew: some 10 ms on one core, with their normals.
const MOST_SYNTHESISED: u32 = 1 << 18;

impl Session {
    /// The finest level that can follow the gain of a level as fast as the hand: a step synthesises whole levels, no more
    /// than 2^18 vertices; but always the level on which the gain's wavelets are seen. The same on every machine.
    pub fn affordable_gains(&self, level: Level) -> Level {
        let (hierarchy, finest) = (self.model.surface.hierarchy(), self.model.surface.finest());
        let fits = |&j: &Level| hierarchy.layout(j).len() <= MOST_SYNTHESISED;
        let affordable = (0..=finest.0).rev().map(Level).find(fits).unwrap_or(Level::BASE);
        affordable.max(level.finer()).min(finest)
    }

    /// Begins to equalise, every gain at 1. Ends a stroke that is under way.
    ///
    /// # Errors
    /// The surface has no wavelets.
    pub fn begin_equaliser(&mut self, over: Over) -> Result<(), SessionError> {
        self.end_stroke();
        self.equaliser = Some(Equaliser::begin(&self.model.surface, over)?);
        Ok(())
    }

    /// The gains by level while equalising, and where they act.
    pub fn equaliser(&self) -> Option<&Equalise> {
        self.equaliser.as_ref().map(Equaliser::words)
    }

    /// Goes to other gains. Levels finer than `reach` follow at the end only, for surfaces too large to follow whole.
    /// Cost: the levels up to `reach`.
    ///
    /// # Errors
    /// Gains that mean nothing or lead out of the range of coordinates; the surface stays as it was.
    pub fn set_gains(&mut self, gains: &[f64], reach: Level) -> Result<Changes, SessionError> {
        let surface = &mut self.model.surface;
        let reach = reach.min(surface.finest());
        match &mut self.equaliser {
            Some(equaliser) => Ok(equaliser.set(surface, gains, reach)?),
            None => Ok(Changes::nothing(surface)),
        }
    }

    pub(super) fn end_equaliser(&mut self, equaliser: Equaliser) -> Changes {
        let surface = &mut self.model.surface;
        if equaliser.is_flat() {
            return equaliser.cancel(surface);
        }
        match equaliser.finish(surface) {
            Ok((step, changes)) => {
                self.record_step(step);
                changes
            }
            Err(_) => Changes { beyond_limit: true, ..Changes::all(&self.model.surface) },
        }
    }
}
