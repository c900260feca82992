//! The panel of a preview: what the conversion came to, what to look at, and whether to open it.

use crate::display::HeatScale;
use crate::editor::command::Command;
use crate::editor::preview::{Facts, Preview, PreviewView};
use crate::editor::theme;
use crate::figures::{length, percent};
use egui::{Role, Ui, WidgetInfo};

/// Draws the panel.
pub(crate) fn preview(ui: &mut Ui, preview: &Preview) -> Vec<Command> {
    let mut commands = Vec::new();
    ui.add_space(6.0);
    ui.heading("Preview of the import");
    ui.add_space(2.0);
    let note = "Nothing is opened yet; the surface that was open stays as it was until you import.";
    ui.add(egui::Label::new(egui::RichText::new(note).color(theme::FAINT).small()).wrap());
    ui.add_space(10.0);
    for (view, name, tip) in [
        (PreviewView::Surface, "Converted surface", "The finest level"),
        (PreviewView::Base, "Base mesh", "Level 0 and its edges"),
        (PreviewView::Error, "Error", "The distance of every vertex from the mesh, in colours"),
    ] {
        if ui.radio(preview.view() == view, name).on_hover_text(tip).clicked() {
            commands.push(Command::LookAt(view));
        }
    }
    if preview.view() == PreviewView::Error {
        ui.add_space(6.0);
        legend(ui, preview);
    }
    ui.add_space(10.0);
    ui.separator();
    facts(ui, preview.facts());
    ui.separator();
    ui.add_space(8.0);
    ui.horizontal(|ui| {
        if ui.add(egui::Button::new("Import").fill(theme::ACCENT)).clicked() {
            commands.push(Command::CommitImport);
        }
        if ui.button("Change").on_hover_text("Back to the choices").clicked() {
            commands.push(Command::ChangeImport);
        }
        if ui.button("Cancel").on_hover_text("Back to the surface that was open").clicked() {
            commands.push(Command::CancelImport);
        }
    });
    commands
}

fn facts(ui: &mut Ui, facts: &Facts) {
    ui.add_space(4.0);
    for (name, figure) in &facts.rows {
        ui.small(egui::RichText::new(*name).color(theme::FAINT));
        ui.add(egui::Label::new(figure).wrap());
    }
    if let Some((met, sentence)) = &facts.tolerance {
        ui.small(egui::RichText::new("tolerance").color(theme::FAINT));
        let text = egui::RichText::new(sentence);
        let text = if *met { text } else { text.color(theme::ACCENT) };
        ui.add(egui::Label::new(text).wrap());
    }
    ui.small(egui::RichText::new("repairs").color(theme::FAINT));
    if facts.cleaned.is_empty() {
        ui.label("none needed");
    }
    for sentence in &facts.cleaned {
        ui.add(egui::Label::new(sentence).wrap());
    }
    ui.add_space(4.0);
}

/// The colours and what they stand for.
fn legend(ui: &mut Ui, preview: &Preview) {
    let width = ui.available_width();
    let (rect, response) = ui.allocate_exact_size(egui::vec2(width, 10.0), egui::Sense::hover());
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, "Colours of the error"));
    let mut mesh = egui::Mesh::default();
    const STEPS: u32 = 40;
    for step in 0..=STEPS {
        let share = step as f32 / STEPS as f32;
        let [r, g, b] = HeatScale::colour(f64::from(share));
        let x = egui::lerp(rect.x_range(), share);
        mesh.colored_vertex(egui::pos2(x, rect.top()), egui::Color32::from_rgb(r, g, b));
        mesh.colored_vertex(egui::pos2(x, rect.bottom()), egui::Color32::from_rgb(r, g, b));
        if step > 0 {
            let at = 2 * step;
            mesh.add_triangle(at - 2, at - 1, at);
            mesh.add_triangle(at - 1, at, at + 1);
        }
    }
    ui.painter().add(mesh);
    let (diagonal, unit) = &preview.facts().diagonal;
    let end = preview.scale().end();
    let says = format!("from 0 to {} ({}) and more", percent(end), length(end * diagonal, unit));
    ui.small(egui::RichText::new(says).color(theme::FAINT));
}
