//! Gains under the hand carried out: the surface follows the equaliser's sliders, on a coarser level if it is large.

use super::Editor;
use super::command::Command;
use bozzetto_core::hierarchy::Level;

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
                    let last = gains.iter().rposition(|&gain| gain != 1.0).unwrap_or(0);
                    self.set_gains(&gains, Level(last as u8));
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

    /// Goes to gains of which that of a level is in the hand: on what can follow it, which shows that level's detail in any case.
    fn set_gains(&mut self, gains: &[f64], level: Level) {
        let Some(document) = &mut self.document else { return };
        let session = &mut document.session;
        let started = match session.equaliser() {
            Some(_) => Ok(()),
            None => session.begin_equaliser(self.settings.over),
        };
        let reach = session.affordable_gains(level);
        let changes = match started.and_then(|()| session.set_gains(gains, reach)) {
            Ok(changes) => changes,
            Err(error) => return self.fail(error.to_string()),
        };
        let preview = (reach < self.settings.shown).then_some(reach);
        if preview != document.preview() {
            document.end_preview();
            if let Some(level) = preview {
                document.preview_level(level);
            }
            self.scenery.replace_surface();
        }
        self.follow(&changes);
    }

    fn cancel_equaliser(&mut self) {
        let Some(document) = &mut self.document else { return };
        if document.session.equaliser().is_none() {
            return;
        }
        if document.end_preview() {
            self.scenery.replace_surface();
        }
        let changes = document.session.cancel_stroke();
        self.follow(&changes);
    }

    /// Makes the gains under the hand an edit, if there are any.
    pub(super) fn end_equaliser(&mut self) {
        if self.document.as_ref().is_some_and(|document| document.session.equaliser().is_some()) {
            self.let_go();
        }
    }
}
