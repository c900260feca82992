//! A brush stroke under way: dabs change the surface as they come, one line is logged at the end.

use super::{Session, SessionError};
use crate::edit::{BrushStroke, Dab, Stroke};
use crate::hierarchy::Level;
use crate::surface::Changes;

impl Session {
    /// Begins a brush stroke with everything but its dabs. Ends one that is under way.
    ///
    /// # Errors
    /// Numbers that mean nothing, an unknown level or version.
    pub fn begin_brush(&mut self, words: Stroke) -> Result<(), SessionError> {
        self.end_stroke();
        self.brush = Some(BrushStroke::begin(&self.model.surface, words)?);
        Ok(())
    }

    /// Touches the surface with the brush. The dab is shortened first to the decimals that will be logged. A stroke that
    /// has no room for more is ended and goes on as a new one. Cost: what the brush reaches.
    ///
    /// # Errors
    /// A dab that means nothing, or would take the surface beyond its range; the stroke stays as it was.
    pub fn dab(&mut self, dab: Dab) -> Result<Changes, SessionError> {
        let Some(brush) = &self.brush else { return Ok(Changes::nothing(&self.model.surface)) };
        let mut changes = Changes::nothing(&self.model.surface);
        if !brush.has_room() {
            let words = next_words(brush.words(), &dab);
            changes.join(self.end_stroke());
            self.begin_brush(words)?;
        }
        let Some(brush) = &mut self.brush else { return Ok(changes) };
        let dab = dab.shortened(brush.words().radius);
        changes.join(brush.dab(&mut self.model.surface, dab)?);
        Ok(changes)
    }

    /// The level whose vertices the brush stroke under way moves.
    pub fn brush_level(&self) -> Option<Level> {
        self.brush.as_ref().map(|brush| brush.moving_level(&self.model.surface))
    }

    /// The words and dabs of the brush stroke under way.
    pub fn brush_words(&self) -> Option<&Stroke> {
        self.brush.as_ref().map(BrushStroke::words)
    }

    pub(super) fn end_brush(&mut self, brush: BrushStroke) -> Changes {
        if brush.is_empty() {
            return Changes::nothing(&self.model.surface);
        }
        match brush.finish(&mut self.model.surface) {
            Ok((step, changes)) => {
                self.record_step(step);
                changes
            }
            Err(_) => Changes { beyond_limit: true, ..Changes::all(&self.model.surface) },
        }
    }
}

/// The words with which a stroke goes on at a dab.
fn next_words(words: &Stroke, dab: &Dab) -> Stroke {
    let from = words.from.zip(words.dabs.first());
    let from = from.map(|(from, first)| std::array::from_fn(|c| from[c] + dab.at[c] - first.at[c]));
    Stroke { from, dabs: Vec::new(), ..words.clone() }
}
