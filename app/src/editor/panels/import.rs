//! The import dialog: what is chosen before a conversion, and how far one is.

use super::Seen;
use crate::editor::choices::{ImportChoices, ImportFrom, UNITS};
use crate::editor::command::Command;
use crate::editor::dialog::Dialog;
use crate::editor::theme;
use crate::editor::worker::Work;
use bozzetto_core::conversion::{Axis, Remesh};
use bozzetto_core::surface::{PRECISIONS, UpAxis};
use bozzetto_core::wavelet::Wavelet;
use egui::{Role, Ui, WidgetInfo};
use lucide_icons::Icon;

/// What a number begins with when it is no longer automatic.
const LEVELS: u8 = 4;
const BASE_FACES: usize = 200;
const TOLERANCE: f64 = 1e-3;
const SHARP_ANGLE: f64 = 30.0;

/// Draws the choices.
pub(super) fn choices(ui: &mut Ui, before: &ImportChoices, seen: &Seen<'_>, commands: &mut Vec<Command>) {
    let mut now = before.clone();
    let mut confirmed = false;
    match &mut now.from {
        ImportFrom::File(path) => {
            ui.heading("Import a mesh");
            ui.add_space(6.0);
            confirmed = super::dialogs::path_field(ui, path, commands);
        }
        ImportFrom::Surface(name) => {
            ui.heading(format!("Remesh {name}"));
            ui.add_space(2.0);
            ui.colored_label(
                theme::FAINT,
                "Converts the finest level again, as a new surface. The open one and its files stay as they are.",
            );
        }
    }
    if now.from != before.from {
        now.found.clear();
    }
    if !now.found.is_empty() {
        ui.add(egui::Label::new(egui::RichText::new(&now.found).color(theme::FAINT)).wrap());
    }
    ui.add_space(8.0);
    super::dialogs::scrolled(ui, 220.0, |ui| {
        egui::Grid::new("import").num_columns(2).min_col_width(92.0).spacing([14.0, 8.0]).show(ui, |ui| {
            sizes(ui, &mut now);
            form(ui, &mut now);
        });
    });
    if now != *before {
        commands.push(Command::Ask(Dialog::Import(Box::new(now.clone()))));
    }
    ui.add_space(12.0);
    let ready = match &now.from {
        ImportFrom::File(path) => !path.trim().is_empty(),
        ImportFrom::Surface(_) => seen.document.is_some(),
    };
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        let preview = egui::Button::new("Preview").fill(theme::ACCENT);
        let tip = "Converts, and shows base mesh and error before anything is opened";
        if (ui.add_enabled(ready, preview).on_hover_text(tip).clicked() || confirmed) && ready {
            commands.push(Command::CloseDialog);
            commands.push(Command::Convert(Box::new(now)));
        }
        if ui.button("Cancel").clicked() {
            commands.push(Command::CloseDialog);
            commands.push(Command::CancelImport);
        }
    });
}

/// How the hierarchy is found.
fn sizes(ui: &mut Ui, now: &mut ImportChoices) {
    if matches!(now.from, ImportFrom::File(_)) {
        ui.label("convert");
        ui.horizontal(|ui| {
            for (remesh, name, tip) in [
                (Remesh::Auto, "if needed", "A mesh with subdivision connectivity keeps its vertices"),
                (Remesh::Always, "always", "Repairs and converts in any case"),
                (
                    Remesh::Never,
                    "never",
                    "Takes a mesh without subdivision connectivity as its own base mesh",
                ),
            ] {
                ui.selectable_value(&mut now.remesh, remesh, name).on_hover_text(tip);
            }
        });
        ui.end_row();
    }
    automatic(
        ui,
        "levels",
        "Choose the levels from the size of the mesh",
        &mut now.levels,
        LEVELS,
        |ui, levels| ui.add(egui::DragValue::new(levels).range(1..=8).speed(0.05)),
    );
    automatic(
        ui,
        "base faces",
        "Choose the base mesh's faces from the size of the mesh",
        &mut now.base_faces,
        BASE_FACES,
        |ui, faces| ui.add(egui::DragValue::new(faces).range(4..=100_000).speed(2.0).prefix("at most ")),
    );
    automatic(
        ui,
        "tolerance",
        "Demand nothing of the distance; it is measured and said either way",
        &mut now.tolerance,
        TOLERANCE,
        |ui, tolerance| {
            let mut percent = *tolerance * 100.0;
            let field = egui::DragValue::new(&mut percent)
                .range(1e-4..=10.0)
                .speed(0.005)
                .max_decimals(4)
                .suffix(" % of the diagonal");
            let response = ui.add(field);
            *tolerance = percent / 100.0;
            response
        },
    );
    automatic(
        ui,
        "sharp edges",
        "Keep edges sharp on meshes that look made, and none on scans",
        &mut now.sharp_angle,
        SHARP_ANGLE,
        |ui, angle| {
            ui.add(egui::DragValue::new(angle).range(1.0..=180.0).speed(0.2).prefix("above ").suffix("°"))
        },
    );
    symmetry(ui, &mut now.symmetric);
}

/// Whether the base mesh is to be its own mirror image, and along which axis.
fn symmetry(ui: &mut Ui, symmetric: &mut Option<Axis>) {
    ui.label("symmetry");
    ui.horizontal(|ui| {
        for axis in std::iter::once(None).chain(Axis::ALL.map(Some)) {
            let (name, tip) = match axis {
                None => ("none".to_owned(), "The base mesh follows the mesh alone".to_owned()),
                Some(axis) => (
                    axis.to_string(),
                    format!("Mirrors the base mesh along {axis}, for a mesh whose sides are nearly alike"),
                ),
            };
            let response = ui.selectable_value(symmetric, axis, name.as_str()).on_hover_text(tip);
            let selected = *symmetric == axis;
            response.widget_info(|| {
                WidgetInfo::selected(Role::RadioButton, true, selected, format!("Symmetry {name}"))
            });
        }
    });
    ui.end_row();
}

/// What the surface is made of, and how it stands.
fn form(ui: &mut Ui, now: &mut ImportChoices) {
    ui.label("wavelet");
    ui.horizontal(|ui| {
        for kind in Wavelet::ALL {
            ui.selectable_value(&mut now.wavelet, kind, kind.to_string());
        }
    });
    ui.end_row();
    ui.label("precision");
    let bits = egui::Slider::new(&mut now.precision, PRECISIONS).suffix(" bits");
    let response = ui.add(bits);
    let value = f64::from(now.precision);
    response.widget_info(|| WidgetInfo::slider(true, value, "Precision"));
    ui.end_row();
    ui.label("up axis");
    ui.horizontal(|ui| {
        for up in UpAxis::ALL {
            let response = ui.selectable_value(&mut now.up, up, up.to_string());
            let selected = now.up == up;
            response
                .widget_info(|| WidgetInfo::selected(Role::RadioButton, true, selected, format!("Up {up}")));
        }
    });
    ui.end_row();
    ui.label("unit");
    ui.horizontal(|ui| {
        for unit in UNITS {
            let shown = if unit.is_empty() { "unknown" } else { unit };
            let response = ui.selectable_label(now.unit == unit, shown);
            let selected = now.unit == unit;
            response.widget_info(|| {
                WidgetInfo::selected(Role::RadioButton, true, selected, format!("Unit {shown}"))
            });
            if response.clicked() {
                now.unit = unit.to_owned();
            }
        }
    });
    ui.end_row();
}

/// A row whose value is chosen by the program or by hand.
fn automatic<T: Copy>(
    ui: &mut Ui,
    name: &str,
    tip: &str,
    value: &mut Option<T>,
    first: T,
    edit: impl FnOnce(&mut Ui, &mut T) -> egui::Response,
) {
    ui.label(name);
    ui.horizontal(|ui| {
        let mut by_itself = value.is_none();
        let word = if name == "tolerance" { "none" } else { "automatic" };
        let check = ui.checkbox(&mut by_itself, word).on_hover_text(tip);
        check.widget_info(|| WidgetInfo::selected(Role::CheckBox, true, by_itself, format!("{name} {word}")));
        if check.changed() {
            *value = (!by_itself).then_some(first);
        }
        if let Some(value) = value {
            let field = edit(ui, value);
            field.widget_info(|| WidgetInfo::labeled(Role::SpinButton, true, format!("chosen {name}")));
        }
    });
    ui.end_row();
}

/// Draws how far a conversion is, stage by stage.
pub(super) fn progress(ui: &mut Ui, work: &Work, commands: &mut Vec<Command>) {
    ui.heading(&work.title);
    ui.add_space(8.0);
    let stage = work.stage();
    let current = work.stages.iter().position(|&s| s == stage).unwrap_or(0);
    for (at, stage) in work.stages.iter().enumerate() {
        ui.horizontal(|ui| {
            let (icon, colour) = match at.cmp(&current) {
                std::cmp::Ordering::Less => (Icon::Check, theme::FAINT),
                std::cmp::Ordering::Equal => (Icon::ChevronRight, theme::ACCENT),
                std::cmp::Ordering::Greater => (Icon::Dot, theme::FAINT),
            };
            ui.label(theme::icon(icon, 13.0).color(colour));
            let text = egui::RichText::new(stage.name());
            ui.label(if at == current { text.strong() } else { text.color(theme::FAINT) });
        });
    }
    ui.add_space(8.0);
    let done = work.done();
    let bar = ui.add(egui::ProgressBar::new(done).show_percentage());
    bar.widget_info(|| WidgetInfo::labeled(Role::ProgressIndicator, true, "Progress"));
    ui.add_space(8.0);
    ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
        if ui.button("Cancel").clicked() {
            commands.push(Command::CancelWork);
        }
    });
}
