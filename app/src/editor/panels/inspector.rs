//! The inspector on the right: level, coefficient, display, history.

use super::Seen;
use super::equaliser::equaliser;
use super::hand::hand;
use crate::editor::command::{Command, Overlay};
use crate::editor::document::Document;
use crate::editor::settings::Settings;
use crate::editor::theme;
use crate::figures::grouped;
use crate::render::Shading;
use bozzetto_core::edit::{Edit, Falloff, Gain, Kind, LevelChange, Levels};
use bozzetto_core::hierarchy::Level;

/// Draws the inspector.
pub(crate) fn inspector(ui: &mut egui::Ui, seen: &Seen<'_>) -> Vec<Command> {
    let mut commands = Vec::new();
    let Some(document) = seen.document else {
        ui.add_space(8.0);
        ui.colored_label(theme::FAINT, if seen.work.is_some() { "Working…" } else { "No surface is open." });
        return commands;
    };
    ui.add_enabled_ui(seen.work.is_none(), |ui| {
        ui.add_space(4.0);
        section(ui, seen.settings.hand.name(), |ui| {
            hand(ui, seen.settings, document.surface(), &mut commands);
        });
        section(ui, "Level", |ui| levels(ui, document, seen.settings, &mut commands));
        section(ui, "Coefficient", |ui| coefficient(ui, document, seen.settings, &mut commands));
        if document.surface().finest() > Level::BASE {
            closed_section(ui, "Equaliser", |ui| equaliser(ui, document, seen.settings, &mut commands));
        }
        section(ui, "Display", |ui| display(ui, document, seen.settings, &mut commands));
        section(ui, "History", |ui| history(ui, document, &mut commands));
    });
    commands
}

fn section(ui: &mut egui::Ui, title: &str, content: impl FnOnce(&mut egui::Ui)) {
    collapsing(ui, title, true, content);
}

fn closed_section(ui: &mut egui::Ui, title: &str, content: impl FnOnce(&mut egui::Ui)) {
    collapsing(ui, title, false, content);
}

fn collapsing(ui: &mut egui::Ui, title: &str, open: bool, content: impl FnOnce(&mut egui::Ui)) {
    egui::CollapsingHeader::new(egui::RichText::new(title).strong()).default_open(open).show_unindented(
        ui,
        |ui| {
            ui.add_space(2.0);
            content(ui);
            ui.add_space(8.0);
        },
    );
}

fn levels(ui: &mut egui::Ui, document: &Document, settings: &Settings, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        for (kind, name, tip) in [
            (Kind::Scaling, "Scaling", "Scaling coefficients: the form of a level; finer detail rides along"),
            (Kind::Wavelet, "Wavelet", "Wavelet coefficients: the detail of a level; the coarser form stays"),
        ] {
            if ui.selectable_label(settings.kind == kind, name).on_hover_text(tip).clicked() {
                commands.push(Command::SetKind(kind));
            }
        }
    });
    let hierarchy = document.surface().hierarchy();
    let finest = hierarchy.finest();
    let last = Settings::last_level(settings.kind, finest);
    egui::Grid::new("levels").num_columns(4).min_col_width(48.0).spacing([10.0, 2.0]).striped(true).show(
        ui,
        |ui| {
            ui.colored_label(theme::FAINT, "level");
            ui.colored_label(theme::FAINT, "edit");
            ui.colored_label(theme::FAINT, "show");
            ui.colored_label(theme::FAINT, "vertices");
            ui.end_row();
            for level in (0..=finest.0).rev().map(Level) {
                ui.label(level.to_string());
                let edit = ui.add_enabled(level <= last, egui::RadioButton::new(settings.level == level, ""));
                name(&edit, format!("Edit level {level}"));
                if edit.clicked() {
                    commands.push(Command::SetLevel(level.0));
                }
                let show = ui.radio(settings.shown == level, "");
                name(&show, format!("Show level {level}"));
                if show.clicked() {
                    commands.push(Command::SetShown(level.0));
                }
                ui.label(grouped(u64::from(hierarchy.layout(level).len())));
                ui.end_row();
            }
        },
    );
    change_levels(ui, document, settings, commands);
}

/// A level more, or fewer; how many vertices the next would have is said before.
fn change_levels(ui: &mut egui::Ui, document: &Document, settings: &Settings, commands: &mut Vec<Command>) {
    let surface = document.surface();
    let (level, finest) = (settings.level, surface.finest());
    let next = surface.vertices_of_next_level();
    let mut button = |ui: &mut egui::Ui, enabled, name: &str, tip: String, change, level| {
        let button = ui.add_enabled(enabled, egui::Button::new(name));
        if button.on_hover_text(&tip).on_disabled_hover_text(&tip).clicked() {
            commands.push(Command::Edit(Edit::Levels(Levels { change, level, v: 1 })));
        }
    };
    ui.horizontal(|ui| {
        tighten(ui);
        let tip = match next {
            Some(count) => {
                format!("Level {} with {} vertices and no detail yet", finest.finer(), grouped(count.into()))
            }
            None => "Another level would have too many vertices".to_owned(),
        };
        button(ui, next.is_some(), "Add level", tip, LevelChange::Add, None);
        if let Some(count) = next {
            ui.colored_label(theme::FAINT, format!("of {} vertices", grouped(count.into())));
        }
    });
    ui.horizontal(|ui| {
        tighten(ui);
        let tip = format!("Delete the levels finer than {level}, and their detail");
        button(ui, level < finest, "Delete finer", tip, LevelChange::Finest, Some(level.0));
        let tip = format!(
            "Delete the levels coarser than {level}: the surface stays, but level {level} becomes the base mesh"
        );
        button(ui, level > Level::BASE, "Delete coarser", tip, LevelChange::Base, Some(level.0));
    });
}

fn coefficient(ui: &mut egui::Ui, document: &Document, settings: &Settings, commands: &mut Vec<Command>) {
    let surface = document.surface();
    match settings.selected.and_then(|id| document.target(settings.kind, settings.level, id)) {
        None => {
            ui.colored_label(theme::FAINT, "Point at the surface and drag.");
        }
        Some(target) => {
            let layout = surface.hierarchy().layout(target.level);
            let steps = match target.kind {
                Kind::Scaling => {
                    surface.scaling(target.level)[layout.slot(layout.site_of(target.vertex)).index()]
                }
                Kind::Wavelet => surface.wavelets(target.level)[(target.vertex.0 - layout.len()) as usize],
            };
            let placement = &surface.form().placement;
            let value = match target.kind {
                Kind::Scaling => placement.to_model(steps),
                Kind::Wavelet => placement.vector_to_model(steps),
            };
            ui.label(format!("{} {} of level {}", target.kind, target.vertex, target.level));
            ui.monospace(format!("{:+.5} {:+.5} {:+.5}", value[0], value[1], value[2]));
        }
    }
    let mut radius = settings.radius;
    let slider = egui::Slider::new(&mut radius, 0.0..=1.0)
        .text("reach")
        .custom_formatter(|x, _| if x == 0.0 { "one".to_owned() } else { format!("{:.0} %", x * 100.0) });
    if ui
        .add(slider)
        .on_hover_text("Moves the neighbourhood too, up to this share of the model's radius")
        .changed()
    {
        commands.push(Command::SetRadius(radius));
    }
    ui.add_enabled_ui(settings.radius > 0.0, |ui| {
        ui.horizontal(|ui| {
            tighten(ui);
            for (falloff, name) in [
                (Falloff::Smooth, "smooth"),
                (Falloff::Linear, "linear"),
                (Falloff::Sharp, "sharp"),
                (Falloff::Constant, "constant"),
            ] {
                if ui.selectable_label(settings.falloff == falloff, name).clicked() {
                    commands.push(Command::SetFalloff(falloff));
                }
            }
        });
    });
    if surface.finest() > Level::BASE {
        gain(ui, settings, surface.finest(), commands);
    }
}

/// Gain of the edited level's wavelets; for scaling coefficients of the finest level, of the last wavelets.
fn gain(ui: &mut egui::Ui, settings: &Settings, finest: Level, commands: &mut Vec<Command>) {
    let level = settings.level.min(Level(finest.0 - 1)).0;
    ui.horizontal(|ui| {
        tighten(ui);
        ui.label(format!("detail of level {level}"));
        ui.add_space(6.0);
        for (factor, label, tip) in [
            (0.0, "erase", "Set this level's wavelet coefficients to zero"),
            (0.5, "½", "Halve this level's detail"),
            (2.0, "× 2", "Double this level's detail"),
        ] {
            if ui.button(label).on_hover_text(tip).clicked() {
                commands.push(Command::Edit(Edit::Gain(Gain { level, factor, v: 1 })));
            }
        }
    });
}

fn display(ui: &mut egui::Ui, document: &Document, settings: &Settings, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        tighten(ui);
        for (shading, name) in [
            (Shading::Clay, "clay"),
            (Shading::Porcelain, "porcelain"),
            (Shading::Flat, "flat"),
            (Shading::Normals, "normals"),
        ] {
            if ui.selectable_label(settings.shading == shading, name).clicked() {
                commands.push(Command::SetShading(shading));
            }
        }
    });
    for (overlay, on, name, tip) in [
        (Overlay::Edges, settings.edges, "level's edges", "The edges of the edited level, on the surface"),
        (Overlay::Handles, settings.handles, "handles", "A dot at every coefficient of the edited level"),
        (
            Overlay::Support,
            settings.support,
            "support",
            "Where the selected coefficient acts: orange up, blue down",
        ),
        (
            Overlay::Control,
            settings.control,
            "control polyhedron",
            "The coarse surface of the edited level itself",
        ),
    ] {
        let mut checked = on;
        if ui.checkbox(&mut checked, name).on_hover_text(tip).changed() {
            commands.push(Command::Toggle(overlay));
        }
    }
    let form = document.surface().form();
    ui.colored_label(theme::FAINT, format!("{} wavelet, {} bits", form.wavelet, form.precision));
    let unit = if form.placement.unit.is_empty() { "unknown" } else { &form.placement.unit };
    ui.colored_label(theme::FAINT, format!("{} up, unit {unit}", form.placement.up));
}

fn history(ui: &mut egui::Ui, document: &Document, commands: &mut Vec<Command>) {
    let session = &document.session;
    let current = session.steps();
    egui::ScrollArea::vertical().max_height(220.0).auto_shrink([false, true]).stick_to_bottom(true).show(
        ui,
        |ui| {
            if ui.selectable_label(current == 0, "Opened").clicked() {
                commands.push(Command::GoTo(0));
            }
            for (at, title) in session.titles().enumerate() {
                let text = egui::RichText::new(format!("{}  {title}", at + 1));
                let text = if at + 1 > current { text.color(theme::FAINT) } else { text };
                if ui.selectable_label(at + 1 == current, text).clicked() {
                    commands.push(Command::GoTo(at + 1));
                }
            }
        },
    );
}

/// Narrow gaps, for rows of several choices.
pub(super) fn tighten(ui: &mut egui::Ui) {
    ui.spacing_mut().item_spacing.x = 2.0;
    ui.spacing_mut().button_padding.x = 6.0;
}

fn name(response: &egui::Response, name: String) {
    let enabled = response.enabled();
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::RadioButton, enabled, &name));
}
