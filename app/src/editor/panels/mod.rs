//! Panels: they see egui and a read-only view of the editor, and return commands.

mod banner;
mod dialogs;
mod equaliser;
mod hand;
mod import;
mod inspector;
mod preview;
mod status;
mod strip;
mod toolbar;

pub(super) use banner::{Banner, banner};
pub(super) use dialogs::dialogs;
pub(super) use inspector::inspector;
pub(super) use preview::preview;
pub(super) use status::status;
pub(super) use strip::strip;
pub(super) use toolbar::toolbar;

use super::dialog::Dialog;
use super::document::Document;
use super::preview::Preview;
use super::settings::Settings;
use super::worker::Work;

/// What panels may look at.
pub(super) struct Seen<'a> {
    /// The open surface; away while work holds it.
    pub document: Option<&'a Document>,
    /// The choices.
    pub settings: &'a Settings,
    /// The hint for the hand.
    pub hint: String,
    /// Work under way.
    pub work: Option<&'a Work>,
    /// The open dialog.
    pub dialog: Option<&'a Dialog>,
    /// What was converted and not opened yet.
    pub preview: Option<&'a Preview>,
}

/// A column of icons, which scrolls without a bar where the window is low.
fn scrolled_icons(ui: &mut egui::Ui, icons: impl FnOnce(&mut egui::Ui)) {
    egui::ScrollArea::vertical()
        .scroll_bar_visibility(egui::scroll_area::ScrollBarVisibility::AlwaysHidden)
        .show(ui, |ui| {
            ui.vertical_centered(|ui| {
                ui.spacing_mut().item_spacing.y = 2.0;
                ui.add_space(6.0);
                icons(ui);
            });
        });
}

/// A button that is an icon, with a name for people who cannot see it and a tip for those who can.
fn icon_button(ui: &mut egui::Ui, enabled: bool, icon: lucide_icons::Icon, name: &str, tip: &str) -> bool {
    let button =
        egui::Button::new(super::theme::icon(icon, 17.0)).min_size(egui::vec2(34.0, 32.0)).frame(false);
    let response = ui.add_enabled(enabled, button).on_hover_text(tip).on_disabled_hover_text(tip);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, name));
    response.clicked()
}
