//! The detail equaliser: a slider a level with the level's energy behind it, and where they act.

use super::inspector::tighten;
use crate::editor::command::Command;
use crate::editor::document::Document;
use crate::editor::settings::Settings;
use crate::editor::theme;
use bozzetto_core::edit::Over;

/// The greatest gain that a slider gives.
const GREATEST: f64 = 3.0;
const HEIGHT: f32 = 110.0;
/// Room below the sliders for their numbers.
const LABEL: f32 = 32.0;
/// Width of a slider.
const RAIL: f32 = 18.0;
/// Decades of energy below the greatest that a bar shows.
const DECADES: f64 = 8.0;

/// Draws the sliders of all levels.
pub(super) fn equaliser(
    ui: &mut egui::Ui,
    document: &Document,
    settings: &Settings,
    commands: &mut Vec<Command>,
) {
    let words = document.session.equaliser();
    let spectrum = document.spectrum();
    let most = spectrum.iter().copied().fold(0.0, f64::max);
    let share = |energy: f64| {
        if energy > 0.0 { (1.0 + (energy / most).log10() / DECADES).clamp(0.0, 1.0) as f32 } else { 0.0 }
    };
    let width = (ui.available_width() / spectrum.len().max(1) as f32).min(34.0);
    let size = egui::vec2(ui.available_width(), HEIGHT + LABEL);
    let (whole, _) = ui.allocate_exact_size(size, egui::Sense::hover());
    // Apart from the panel's own flow, which goes on below.
    let mut bands = ui.new_child(egui::UiBuilder::new().max_rect(whole));
    for (level, &energy) in spectrum.iter().enumerate() {
        let gain = words.map_or(1.0, |words| words.gains[level]);
        let left = whole.left() + width * level as f32;
        let column = egui::Rect::from_min_size(egui::pos2(left, whole.top()), egui::vec2(width, HEIGHT));
        band(&mut bands, column, (level as u8, gain), share(energy), commands);
    }
    ui.horizontal(|ui| {
        tighten(ui);
        for (over, name, tip) in [
            (Over::All, "everywhere", "The whole surface, but for what is hidden"),
            (Over::Mask, "masked", "What is masked, by how much"),
            (Over::Free, "free", "What is not masked"),
        ] {
            let masked = !document.surface().mask().values().is_empty() || over != Over::Mask;
            let label = egui::Button::selectable(settings.over == over, name);
            if ui.add_enabled(masked, label).on_hover_text(tip).clicked() {
                commands.push(Command::SetOver(over));
            }
        }
    });
    ui.horizontal(|ui| {
        tighten(ui);
        let held = words.is_some();
        let apply = ui.add_enabled(held, egui::Button::new("Apply gains"));
        if apply.on_hover_text("Make the gains one step of the history").clicked() {
            commands.push(Command::EndEqualiser);
        }
        let back = ui.add_enabled(held, egui::Button::new("Reset gains"));
        if back.on_hover_text("Take the gains back").clicked() {
            commands.push(Command::CancelEqualiser);
        }
    });
}

/// One level: its energy as a bar, its gain as a slider over it, its number and gain below.
fn band(
    ui: &mut egui::Ui,
    column: egui::Rect,
    (level, gain): (u8, f64),
    share: f32,
    commands: &mut Vec<Command>,
) {
    let mut wanted = gain;
    let top = column.bottom() - share * column.height();
    let bar =
        egui::Rect::from_min_max(egui::pos2(column.left(), top), column.max).shrink2(egui::vec2(3.0, 0.0));
    ui.painter().rect_filled(bar, 2.0, theme::FAINT.gamma_multiply(0.3));
    ui.spacing_mut().slider_width = column.height();
    ui.spacing_mut().interact_size.y = RAIL;
    let slider = egui::Slider::new(&mut wanted, 0.0..=GREATEST).vertical().show_value(false);
    let rail = egui::Rect::from_center_size(column.center(), egui::vec2(RAIL, column.height()));
    let response = ui.put(rail, slider.trailing_fill(false));
    let below = |dy: f32| egui::pos2(column.center().x, column.bottom() + dy);
    let text = |dy: f32, text: String, color| {
        ui.painter().text(below(dy), egui::Align2::CENTER_TOP, text, egui::FontId::proportional(11.5), color);
    };
    text(3.0, level.to_string(), theme::FAINT);
    if gain != 1.0 {
        text(16.0, format!("{gain:.1}"), theme::ACCENT);
    }
    let name = format!("Gain of level {level}");
    response.widget_info(|| egui::WidgetInfo::slider(true, gain, &name));
    if response.double_clicked() {
        commands.push(Command::SetGain(level, 1.0));
    } else if response.changed() {
        // Hundredths are what a hand can tell apart, and 1 is easily found again.
        let rounded = (wanted * 100.0).round() / 100.0;
        commands.push(Command::SetGain(level, if (rounded - 1.0).abs() < 0.04 { 1.0 } else { rounded }));
    }
    response.on_hover_text(format!("Detail of level {level}: × {gain:.2} (double click: × 1)"));
}
