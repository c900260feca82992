//! A calm dark theme with one accent, and the icon font.

use egui::{Color32, CornerRadius, FontData, FontDefinitions, FontFamily, Stroke, TextStyle};
use lucide_icons::{Icon, LUCIDE_FONT_BYTES};
use std::sync::Arc;

/// The one accent colour.
pub(super) const ACCENT: Color32 = Color32::from_rgb(224, 122, 62);
/// Text of lesser weight.
pub(super) const FAINT: Color32 = Color32::from_rgb(150, 152, 158);
const PANEL: Color32 = Color32::from_rgb(37, 38, 42);
const WIDGET: Color32 = Color32::from_rgb(52, 54, 59);
const HOVERED: Color32 = Color32::from_rgb(66, 68, 74);
const TEXT: Color32 = Color32::from_rgb(222, 223, 226);

/// Sets fonts and colours.
pub(super) fn apply(ctx: &egui::Context) {
    let mut fonts = FontDefinitions::default();
    fonts.font_data.insert("lucide".into(), Arc::new(FontData::from_static(LUCIDE_FONT_BYTES)));
    fonts.families.entry(FontFamily::Name("icons".into())).or_default().push("lucide".into());
    fonts.families.entry(FontFamily::Proportional).or_default().push("lucide".into());
    ctx.set_fonts(fonts);
    ctx.set_theme(egui::Theme::Dark);
    ctx.all_styles_mut(|style| {
        let visuals = &mut style.visuals;
        visuals.panel_fill = PANEL;
        visuals.window_fill = PANEL;
        visuals.extreme_bg_color = Color32::from_rgb(26, 27, 30);
        visuals.override_text_color = Some(TEXT);
        visuals.selection.bg_fill = ACCENT.gamma_multiply(0.75);
        visuals.selection.stroke = Stroke::new(1.0, Color32::WHITE);
        visuals.hyperlink_color = ACCENT;
        visuals.slider_trailing_fill = true;
        let radius = CornerRadius::same(5);
        for widget in [
            &mut visuals.widgets.inactive,
            &mut visuals.widgets.hovered,
            &mut visuals.widgets.active,
            &mut visuals.widgets.open,
            &mut visuals.widgets.noninteractive,
        ] {
            widget.corner_radius = radius;
        }
        visuals.widgets.inactive.weak_bg_fill = WIDGET;
        visuals.widgets.inactive.bg_fill = WIDGET;
        visuals.widgets.hovered.weak_bg_fill = HOVERED;
        visuals.widgets.hovered.bg_fill = HOVERED;
        visuals.widgets.hovered.bg_stroke = Stroke::NONE;
        visuals.widgets.active.bg_stroke = Stroke::NONE;
        visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_rgb(54, 56, 61));
        style.spacing.item_spacing = egui::vec2(8.0, 6.0);
        style.spacing.button_padding = egui::vec2(8.0, 4.0);
        style.spacing.slider_width = 130.0;
        style.text_styles.insert(TextStyle::Body, egui::FontId::proportional(13.5));
        style.text_styles.insert(TextStyle::Button, egui::FontId::proportional(13.5));
        style.text_styles.insert(TextStyle::Small, egui::FontId::proportional(11.5));
        style.text_styles.insert(TextStyle::Heading, egui::FontId::proportional(14.5));
    });
}

/// An icon as text.
pub(super) fn icon(icon: Icon, size: f32) -> egui::RichText {
    egui::RichText::new(char::from(icon)).family(FontFamily::Name("icons".into())).size(size)
}
