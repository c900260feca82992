//! Messages over the surface: errors stay until dismissed, notes too.

use crate::editor::command::Command;
use crate::editor::theme;

/// A message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Banner {
    /// The sentences.
    pub text: String,
    /// Whether something failed.
    pub failed: bool,
}

/// Draws the message at the top of the picture.
pub(crate) fn banner(ctx: &egui::Context, picture: egui::Rect, banner: Option<&Banner>) -> Vec<Command> {
    let mut commands = Vec::new();
    let Some(message) = banner else { return commands };
    let at = egui::pos2(picture.center().x, picture.top() + 12.0);
    egui::Area::new(egui::Id::unique("banner")).pivot(egui::Align2::CENTER_TOP).fixed_pos(at).show(
        ctx,
        |ui| {
            let edge = if message.failed { egui::Color32::from_rgb(214, 84, 72) } else { theme::ACCENT };
            egui::Frame::window(ui.style()).stroke(egui::Stroke::new(1.0, edge)).show(ui, |ui| {
                ui.set_max_width((picture.width() - 80.0).clamp(120.0, 640.0));
                ui.horizontal(|ui| {
                    ui.add(egui::Label::new(&message.text).wrap());
                    if ui.button("Dismiss").clicked() {
                        commands.push(Command::DismissBanner);
                    }
                });
            });
        },
    );
    commands
}
