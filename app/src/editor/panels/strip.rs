//! The slim strip on the left: files, undo, views.

use super::{Seen, icon_button, scrolled_icons};
use crate::editor::choices::ImportChoices;
use crate::editor::command::Command;
use crate::editor::dialog::{Dialog, PathTask};
use crate::render::View;
use lucide_icons::Icon;

/// Draws the strip.
pub(crate) fn strip(ui: &mut egui::Ui, seen: &Seen<'_>) -> Vec<Command> {
    let mut commands = Vec::new();
    let idle = seen.work.is_none() && seen.preview.is_none();
    let open = idle && seen.document.is_some();
    let looking = open || seen.preview.is_some();
    let import = Dialog::Import(Box::new(ImportChoices::file(String::new())));
    let finest = seen.document.map_or(0, |d| d.surface().finest().0);
    let export = PathTask::Export { level: finest };
    let (undo, redo) = seen.document.map_or((false, false), |d| {
        (d.session.steps() > 0 || d.session.in_stroke(), d.session.steps() < d.session.history_len())
    });
    scrolled_icons(ui, |ui| {
        let mut button = |ui: &mut egui::Ui, enabled, icon, name: &str, tip: &str, command: Command| {
            if icon_button(ui, enabled, icon, name, tip) {
                commands.push(command);
            }
        };
        let ask = |task: PathTask| Command::Ask(task.dialog());
        button(
            ui,
            idle,
            Icon::FolderOpen,
            "Open",
            "Open a wavelet file or mesh (Ctrl+O)",
            ask(PathTask::Open),
        );
        button(ui, idle, Icon::Import, "Import mesh", "Import a mesh, with choices", Command::Ask(import));
        button(
            ui,
            open,
            Icon::RefreshCw,
            "Remesh",
            "Convert the finest level again, as a new surface",
            Command::AskRemesh,
        );
        button(ui, open, Icon::Save, "Save", "Save (Ctrl+S)", Command::Save);
        button(ui, open, Icon::SaveAll, "Save as", "Save as (Ctrl+Shift+S)", ask(PathTask::SaveAs));
        button(
            ui,
            open,
            Icon::FileBox,
            "Save a copy",
            "Save a baked copy, without history",
            ask(PathTask::SaveCopy),
        );
        button(ui, open, Icon::Share, "Export", "Export a level as a mesh", ask(export));
        ui.add_space(4.0);
        ui.separator();
        ui.add_space(4.0);
        button(ui, open && undo, Icon::Undo2, "Undo", "Undo (Ctrl+Z)", Command::Undo);
        button(ui, open && redo, Icon::Redo2, "Redo", "Redo (Ctrl+Shift+Z)", Command::Redo);
        ui.add_space(4.0);
        ui.separator();
        ui.add_space(4.0);
        button(ui, looking, Icon::Maximize, "Fit", "Fit the surface into the picture (Home)", Command::Fit);
        button(
            ui,
            looking,
            Icon::Square,
            "Front view",
            "Look from the front (1)",
            Command::Look(View::FRONT),
        );
        button(
            ui,
            looking,
            Icon::PanelRight,
            "Right view",
            "Look from the right (3)",
            Command::Look(View::RIGHT),
        );
        button(ui, looking, Icon::PanelTop, "Top view", "Look from the top (7)", Command::Look(View::TOP));
        ui.add_space(4.0);
        ui.separator();
        ui.add_space(4.0);
        button(ui, true, Icon::Keyboard, "Keys", "Keys and mouse (F1)", Command::Ask(Dialog::Keys));
    });
    commands
}
