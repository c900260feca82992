//! Gains under the hand carried out: the surface follows the equaliser's sliders, on a coarser level if it is large.

use super::Editor;
use super::command::Command;
use bozzetto_core::edit::EditError;
use bozzetto_core::hierarchy::Level;
use bozzetto_core::session::Session;
use std::time::{Duration, Instant};

/// A step that takes longer than this shows a coarser level.
const LONGEST_STEP: Duration = Duration::from_millis(40);

impl Editor {
    /// Carries out a command of the equaliser.
    pub(super) fn equalise(&mut self, command: &Command) {
        match *command {
            Command::SetGain(level, gain) => self.set_gain(level, gain),
            Command::SetOver(over) => {
                self.settings.over = over;
                // The gains stay where they are, over another part.
                let Some(document) = &mut self.document else { return };
                let gains = document.session.equaliser().map(|words| words.gains.clone());
                if let Some(gains) = gains {
                    self.cancel_equaliser();
                    self.set_gains(&gains, Level::BASE);
                }
            }
            Command::CancelEqualiser => self.cancel_equaliser(),
            _ => self.end_equaliser(),
        }
    }

    fn set_gain(&mut self, level: u8, gain: f64) {
        let Some(document) = &mut self.document else { return };
        let finest = document.surface().finest();
        let mut gains = match document.session.equaliser() {
            Some(words) => words.gains.clone(),
            None => vec![1.0; finest.index()],
        };
        if let Some(of_level) = gains.get_mut(usize::from(level)) {
            *of_level = gain;
            self.set_gains(&gains, Level(level));
        }
    }

    /// Goes to gains of which that of a level is in the hand.
    fn set_gains(&mut self, gains: &[f64], level: Level) {
        let Some(document) = &mut self.document else { return };
        let finest = document.surface().finest();
        let begun = Instant::now();
        let session = &mut document.session;
        let started = match session.equaliser() {
            Some(_) => Ok(()),
            None => session.begin_equaliser(self.settings.over),
        };
        // What the hand changes is to be seen.
        let reach = document.preview().unwrap_or(finest).max(level.finer()).min(finest);
        if document.preview().is_some_and(|shown| shown < reach) {
            document.preview_level(reach);
            self.scenery.replace_surface();
        }
        match started.and_then(|()| document.session.set_gains(gains, reach)) {
            Ok(changes) => self.follow(&changes),
            Err(error) => return self.fail(error.to_string()),
        }
        let took = begun.elapsed().as_secs_f64() / LONGEST_STEP.as_secs_f64();
        let Some(document) = &mut self.document else { return };
        let drop = (took.log2() / 2.0).ceil().max(0.0) as u8;
        let shown = document.vertices().level();
        let preview = Level(reach.0.saturating_sub(drop)).max(level.finer());
        if drop > 0 && preview < shown {
            document.preview_level(preview);
            self.scenery.replace_surface();
        }
    }

    fn cancel_equaliser(&mut self) {
        self.leave_equaliser(Session::cancel_stroke);
    }

    /// Makes the gains under the hand an edit, if there are any.
    pub(super) fn end_equaliser(&mut self) {
        self.leave_equaliser(Session::end_stroke);
    }

    fn leave_equaliser(&mut self, leave: fn(&mut Session) -> bozzetto_core::surface::Changes) {
        let Some(document) = &mut self.document else { return };
        if document.session.equaliser().is_none() {
            return;
        }
        let previewed = document.end_preview();
        let changes = leave(&mut document.session);
        if previewed {
            self.scenery.replace_surface();
        }
        let refused = changes.beyond_limit;
        self.follow(&changes);
        if refused {
            self.fail(EditError::BeyondLimit.to_string());
        }
    }
}
