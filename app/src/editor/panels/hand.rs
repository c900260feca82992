//! What the tool in the hand can be told: radius, strength, symmetry, how handles bend, pen and mouse.

use super::inspector::tighten;
use crate::editor::command::Command;
use crate::editor::settings::{Hand, Navigation, Settings};
use bozzetto_core::edit::{Edit, Hide, Part, Spread, Tool};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::surface::Surface;

/// Draws the choices of the tool in the hand.
pub(super) fn hand(ui: &mut egui::Ui, settings: &Settings, surface: &Surface, commands: &mut Vec<Command>) {
    let (mask, finest) = (surface.mask(), surface.finest());
    let masked = mask.values().iter().any(|&value| value != 0);
    // Room for the longest of the names behind the sliders.
    ui.spacing_mut().slider_width = 118.0;
    if settings.hand != Hand::Handle {
        let mut radius = settings.brush_radius;
        let slider = egui::Slider::new(&mut radius, 0.005..=1.0)
            .logarithmic(true)
            .text("radius")
            .custom_formatter(|x, _| format!("{:.1} %", x * 100.0));
        if ui.add(slider).on_hover_text("Share of the model's radius (F, [ and ])").changed() {
            commands.push(Command::SetBrushRadius(radius));
        }
    }
    if matches!(settings.hand, Hand::Brush(_)) {
        let mut strength = settings.strength;
        let slider = egui::Slider::new(&mut strength, 0.0..=1.0).text("strength");
        if ui.add(slider).on_hover_text("How strongly a touch acts (Shift+F)").changed() {
            commands.push(Command::SetStrength(strength));
        }
    }
    ui.horizontal(|ui| {
        tighten(ui);
        ui.label("symmetry");
        ui.add_space(6.0);
        for (axis, name) in ["X", "Y", "Z"].into_iter().enumerate() {
            let label = ui.selectable_label(settings.symmetry[axis], name);
            let named = format!("Symmetry {name}");
            label.widget_info(|| {
                egui::WidgetInfo::selected(egui::Role::Button, true, settings.symmetry[axis], &named)
            });
            if label.on_hover_text(format!("Mirror strokes across the model's middle ({name})")).clicked() {
                commands.push(Command::ToggleSymmetry(axis));
            }
        }
    });
    let toggle = |ui: &mut egui::Ui,
                  on: bool,
                  name: &str,
                  tip: &str,
                  command: Command,
                  commands: &mut Vec<Command>| {
        let mut on = on;
        if ui.checkbox(&mut on, name).on_hover_text(tip).changed() {
            commands.push(command);
        }
    };
    if matches!(settings.hand, Hand::Handle | Hand::Grab) {
        ui.horizontal(|ui| {
            tighten(ui);
            for (spread, name, tip) in [
                (Spread::Smooth, "Smooth bend", "Finer levels bend smoothly; detail is a smooth bump"),
                (Spread::Hat, "Raw", "The coefficient as it is: a tent, or the paper's wavelet"),
            ] {
                if ui.selectable_label(settings.spread == spread, name).on_hover_text(tip).clicked() {
                    commands.push(Command::SetSpread(spread));
                }
            }
        });
        let tip = "Finer detail turns with the surface when a form bends";
        toggle(ui, settings.follow, "detail follows", tip, Command::ToggleFollow, commands);
    }
    if settings.hand == Hand::Brush(Tool::Erase) {
        erased_levels(ui, settings, finest, commands);
    }
    if settings.hand != Hand::Handle {
        let tip = "The radius chooses the edited level";
        toggle(ui, settings.auto_level, "auto level", tip, Command::ToggleAutoLevel, commands);
    }
    if matches!(settings.hand, Hand::Brush(_)) {
        let mut steady = settings.steady;
        let slider = egui::Slider::new(&mut steady, 0.0..=80.0).text("steady").fixed_decimals(0);
        if ui.add(slider).on_hover_text("The brush trails this many points behind the cursor").changed() {
            commands.push(Command::SetSteady(steady));
        }
        let tip = "A pen's pressure acts on the strength";
        toggle(
            ui,
            settings.pressure_strength,
            "pressure: strength",
            tip,
            Command::TogglePressure(true),
            commands,
        );
        let tip = "A pen's pressure acts on the radius";
        toggle(
            ui,
            settings.pressure_radius,
            "pressure: radius",
            tip,
            Command::TogglePressure(false),
            commands,
        );
    }
    if masked || settings.hand == Hand::Brush(Tool::Mask) {
        let clear = ui.add_enabled(masked, egui::Button::new("Clear mask"));
        if clear.on_hover_text("Free everything that is masked").clicked() {
            commands.push(Command::ClearMask);
        }
        ui.horizontal(|ui| {
            tighten(ui);
            for (part, name, tip) in [
                (Part::Mask, "Hide masked", "What is masked is not drawn, not hit and not changed"),
                (Part::Free, "Isolate masked", "Only what is masked is shown"),
            ] {
                if ui.add_enabled(masked, egui::Button::new(name)).on_hover_text(tip).clicked() {
                    commands.push(hide(part));
                }
            }
        });
    }
    if mask.hides_something() {
        ui.horizontal(|ui| {
            tighten(ui);
            for (part, name, tip) in [
                (Part::Nothing, "Show all", "Nothing is hidden any more"),
                (Part::Shown, "Swap hidden", "Hide what is shown, and show what is hidden"),
            ] {
                if ui.button(name).on_hover_text(tip).clicked() {
                    commands.push(hide(part));
                }
            }
        });
    }
    ui.horizontal(|ui| {
        tighten(ui);
        ui.label("mouse");
        ui.add_space(6.0);
        for (navigation, name) in Navigation::ALL {
            let tip = match navigation {
                Navigation::Blender => "Middle: orbit, Shift pan, Ctrl zoom · right: pan",
                Navigation::Maya => "Alt + left: orbit, middle: pan, right: zoom",
                Navigation::ZBrush => "Right: orbit, Alt pan, Ctrl zoom · Alt + left on the background: pan",
            };
            if ui.selectable_label(settings.navigation == navigation, name).on_hover_text(tip).clicked() {
                commands.push(Command::SetNavigation(navigation));
            }
        }
    });
}

/// Which levels' detail is erased: from the edited one to another.
fn erased_levels(ui: &mut egui::Ui, settings: &Settings, finest: Level, commands: &mut Vec<Command>) {
    let Some(last) = finest.0.checked_sub(1) else { return };
    let from = settings.level.0.min(last);
    let mut to = settings.erase_to.map_or(last, |to| to.clamp(from, last));
    ui.add_enabled_ui(from < last, |ui| {
        ui.spacing_mut().slider_width = 80.0;
        let tip = format!("Detail of levels {from} to {to} is erased, finer detail stays");
        let slider = egui::Slider::new(&mut to, from..=last.max(from + 1)).text("erase to level");
        if ui.add(slider).on_hover_text(tip).changed() {
            commands.push(Command::SetEraseTo((to < last).then_some(to)));
        }
    });
}

fn hide(part: Part) -> Command {
    Command::Edit(Edit::Hide(Hide { part, faces: Vec::new(), v: 1 }))
}
