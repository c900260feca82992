//! Dialogs over the window.

use super::{Seen, import};
use crate::editor::command::Command;
use crate::editor::dialog::{Dialog, PathTask};
use crate::editor::theme;
use std::path::PathBuf;

/// Draws the open dialog, if there is one.
pub(crate) fn dialogs(ctx: &egui::Context, seen: &Seen<'_>) -> Vec<Command> {
    let mut commands = Vec::new();
    if let Some(work) = seen.work.filter(|work| work.converts()) {
        egui::Modal::new(egui::Id::unique("conversion")).show(ctx, |ui| {
            ui.set_width(300.0);
            import::progress(ui, work, &mut commands);
        });
        return commands;
    }
    let Some(dialog) = seen.dialog else { return commands };
    // Each has its own size, which the next one must not inherit.
    let name = match dialog {
        Dialog::Path { task, .. } => task.words().0,
        Dialog::Import(_) => "import",
        Dialog::Losing(_) => "losing",
        Dialog::Closing => "closing",
        Dialog::Keys => "keys",
    };
    let shown = egui::Modal::new(egui::Id::unique(name)).show(ctx, |ui| {
        ui.set_width(if matches!(dialog, Dialog::Keys) { 520.0 } else { 460.0 });
        match dialog {
            Dialog::Path { task, path } => path_dialog(ui, *task, path, seen, &mut commands),
            Dialog::Import(choices) => import::choices(ui, choices, seen, &mut commands),
            Dialog::Losing(command) => losing(ui, command, &mut commands),
            Dialog::Closing => closing(ui, seen, &mut commands),
            Dialog::Keys => keys(ui, &mut commands),
        }
    });
    if shown.should_close() {
        commands.push(Command::CloseDialog);
        if matches!(dialog, Dialog::Import(_)) {
            commands.push(Command::CancelImport);
        }
    }
    commands
}

fn path_dialog(ui: &mut egui::Ui, task: PathTask, path: &str, seen: &Seen<'_>, commands: &mut Vec<Command>) {
    let (title, verb) = task.words();
    ui.heading(title);
    ui.add_space(6.0);
    let mut edited = path.to_owned();
    let mut task_now = task;
    let confirmed = path_field(ui, &mut edited, commands);
    ui.add_space(4.0);
    match &mut task_now {
        PathTask::Export { level } => {
            let finest = seen.document.map_or(0, |d| d.surface().finest().0);
            ui.add(egui::Slider::new(level, 0..=finest).text("level"));
        }
        PathTask::SaveAs => {
            ui.colored_label(theme::FAINT, "The wavelet file and its log; the history goes along.");
        }
        PathTask::SaveCopy => {
            ui.colored_label(theme::FAINT, "One wavelet file as the surface is now, without history.");
        }
        PathTask::Open => {}
    }
    if edited != path || task_now != task {
        commands.push(Command::Ask(Dialog::Path { task: task_now, path: edited.clone() }));
    }
    // The file that is open is saved, not replaced.
    let own = seen.document.and_then(|d| d.session.path());
    let replaced = task_now.target(&edited).filter(|path| path.is_file() && own != Some(path));
    if let Some(name) = replaced.as_ref().and_then(|path| path.file_name()) {
        let log = if task == PathTask::SaveAs { ", and its log with it" } else { "" };
        let text = format!("{} is there already and would be replaced{log}.", name.to_string_lossy());
        ui.colored_label(ui.visuals().warn_fg_color, text);
    }
    ui.add_space(8.0);
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        let ready = !edited.trim().is_empty();
        // Enter alone replaces nothing.
        let (verb, confirmed) = if replaced.is_some() { ("Replace file", false) } else { (verb, confirmed) };
        if (ui.add_enabled(ready, egui::Button::new(verb).fill(theme::ACCENT)).clicked() || confirmed)
            && ready
        {
            commands.push(Command::CloseDialog);
            commands.push(command(task_now, PathBuf::from(edited.trim())));
        }
        if ui.button("Cancel").clicked() {
            commands.push(Command::CloseDialog);
        }
    });
}

/// A field for a path, with a button for the system's dialog; whether Enter was pressed in it.
pub(super) fn path_field(ui: &mut egui::Ui, path: &mut String, commands: &mut Vec<Command>) -> bool {
    let empty = path.is_empty();
    let field = ui
        .horizontal(|ui| {
            let field = ui.add(egui::TextEdit::singleline(path).desired_width(340.0).hint_text("path"));
            field.widget_info(|| egui::WidgetInfo::labeled(egui::Role::TextInput, true, "Path"));
            if ui.button("Browse…").clicked() {
                commands.push(Command::Browse);
            }
            field
        })
        .inner;
    let confirmed = field.lost_focus() && ui.input(|i| i.key_pressed(egui::Key::Enter));
    if empty && !field.has_focus() && !confirmed {
        field.request_focus();
    }
    confirmed
}

/// Content that scrolls where the window is too low for it and what is drawn beside it, so many points high.
pub(super) fn scrolled(ui: &mut egui::Ui, beside: f32, content: impl FnOnce(&mut egui::Ui)) {
    let room = (ui.ctx().content_rect().height() - beside).max(64.0);
    egui::ScrollArea::vertical().max_height(room).min_scrolled_height(room).show(ui, content);
}

fn command(task: PathTask, path: PathBuf) -> Command {
    match task {
        PathTask::Open => Command::Open(path),
        PathTask::SaveAs => Command::SaveAs(path),
        PathTask::SaveCopy => Command::SaveCopy(path),
        PathTask::Export { level } => Command::Export(path, level),
    }
}

fn closing(ui: &mut egui::Ui, seen: &Seen<'_>, commands: &mut Vec<Command>) {
    ui.heading("Close with unsaved edits?");
    ui.add_space(4.0);
    let session = seen.document.map(|d| &d.session);
    let fails = session.is_some_and(|s| s.journal_failure().is_some());
    let has_file = session.is_some_and(|s| s.path().is_some()) && !fails;
    ui.label(match (has_file, fails) {
        (true, _) => "Keep leaves the edits in the log, as they are now. Discard goes back to the last save.",
        (_, true) => "The last edits are not on the disk, for the log cannot be written. Save under another name, or discard them.",
        _ => "This surface has no file yet. Save it, or discard its edits for good.",
    });
    ui.add_space(8.0);
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        if has_file {
            if ui.add(egui::Button::new("Keep edits").fill(theme::ACCENT)).clicked() {
                commands.push(Command::QuitKeeping);
            }
        } else if ui.add(egui::Button::new("Save as…").fill(theme::ACCENT)).clicked() {
            commands.push(Command::Ask(PathTask::SaveAs.dialog()));
        }
        if ui.button("Discard edits").clicked() {
            commands.push(Command::QuitDiscarding);
        }
        if ui.button("Cancel").clicked() {
            commands.push(Command::CloseDialog);
        }
    });
}

fn losing(ui: &mut egui::Ui, command: &Command, commands: &mut Vec<Command>) {
    ui.heading("Lose the edits of this surface?");
    ui.add_space(4.0);
    ui.label("No file keeps them yet, or its log cannot be written. Save them first, or give them up.");
    ui.add_space(8.0);
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        if ui.add(egui::Button::new("Save as…").fill(theme::ACCENT)).clicked() {
            commands.push(Command::Ask(PathTask::SaveAs.dialog()));
        }
        if ui.button("Discard edits").clicked() {
            commands.push(Command::Anyway(Box::new(command.clone())));
        }
        if ui.button("Cancel").clicked() {
            commands.push(Command::CloseDialog);
        }
    });
}

/// Keys and what they do.
const KEYS: [(&str, &str); 24] = [
    ("Left drag on the surface", "use the tool in the hand"),
    ("Left drag beside it", "orbit"),
    ("Middle, right, wheel", "orbit, pan, zoom (more under \"mouse\")"),
    ("Shift, Ctrl with a brush", "smooth, the other way round"),
    ("F, Shift + F", "radius, strength: move, click to keep, Esc"),
    ("[ ]", "smaller, larger brush"),
    ("H G", "handle, grab"),
    ("V C I S A T P R", "draw, clay, inflate, smooth, sharpen, flatten, pinch, crease"),
    ("E K M", "erase detail, copy detail, mask"),
    ("X Y Z", "symmetry"),
    ("X Y Z while dragging", "keep to an axis"),
    ("Ctrl while dragging", "along the normal"),
    ("B while dragging", "show the state before"),
    ("Esc while dragging", "take the drag or stroke back"),
    ("D, Page Up", "edit the next finer level"),
    ("Shift + D, Page Down", "edit the next coarser level"),
    ("W", "scaling or wavelet coefficients"),
    ("1 3 7", "front, right, top"),
    (". Home", "frame the last stroke, everything"),
    ("N", "show or hide the inspector"),
    ("Tab", "move on to the next control"),
    ("Ctrl + Z", "undo"),
    ("Ctrl + Shift + Z, Ctrl + Y", "redo"),
    ("Ctrl + O, S, Shift + S", "open, save, save as"),
];

fn keys(ui: &mut egui::Ui, commands: &mut Vec<Command>) {
    ui.heading("Keys and mouse");
    ui.add_space(6.0);
    scrolled(ui, 150.0, |ui| {
        egui::Grid::new("keys").num_columns(2).spacing([18.0, 4.0]).show(ui, |ui| {
            for (key, does) in KEYS {
                ui.strong(key);
                ui.label(does);
                ui.end_row();
            }
        });
    });
    ui.add_space(8.0);
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        if ui.button("Close").clicked() {
            commands.push(Command::CloseDialog);
        }
    });
}
