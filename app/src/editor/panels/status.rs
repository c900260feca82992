//! The status bar: what the mouse does now, the counts, work under way.

use super::Seen;
use crate::editor::command::Command;
use crate::editor::theme;
use crate::figures::grouped;

/// Draws the bar.
pub(crate) fn status(ui: &mut egui::Ui, seen: &Seen<'_>) -> Vec<Command> {
    let mut commands = Vec::new();
    ui.horizontal_centered(|ui| {
        if let Some(work) = seen.work.filter(|work| !work.converts()) {
            ui.label(&work.title);
            ui.add(egui::ProgressBar::new(work.done()).desired_width(160.0).show_percentage());
            if ui.small_button("Cancel").clicked() {
                commands.push(Command::CancelWork);
            }
        } else {
            ui.colored_label(theme::FAINT, &seen.hint);
        }
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if let Some(document) = seen.document.filter(|_| seen.preview.is_none()) {
                let hierarchy = document.surface().hierarchy();
                let (shown, until) = match document.preview() {
                    Some(level) if document.session.equaliser().is_some() => {
                        (level, ", shown until the gains are applied")
                    }
                    Some(level) => (level, ", shown until you let go"),
                    None => (seen.settings.shown, ""),
                };
                let vertices = grouped(u64::from(hierarchy.layout(shown).len()));
                let faces = grouped(hierarchy.face_count(shown));
                ui.label(format!("{vertices} vertices, {faces} faces at level {shown}{until}"));
                let mark = if document.session.is_unsaved() { " •" } else { "" };
                ui.colored_label(theme::FAINT, format!("{}{mark}", document.name()));
            }
        });
    });
    commands
}
