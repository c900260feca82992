//! The tools: what can be taken into the hand.

use super::{Seen, icon_button, scrolled_icons};
use crate::editor::command::Command;
use crate::editor::settings::Hand;
use crate::editor::theme;
use bozzetto_core::edit::Tool;
use lucide_icons::Icon;

/// The tools in order, with their icons and what they do.
const TOOLS: [(Hand, Icon, &str); 13] = [
    (Hand::Handle, Icon::Move3d, "Handle: drag a coefficient of the edited level (H)"),
    (Hand::Grab, Icon::Hand, "Grab: drag the surface round the cursor (G)"),
    (Hand::Brush(Tool::Draw), Icon::Brush, "Draw: raise the surface, with Ctrl dig (V)"),
    (Hand::Brush(Tool::Clay), Icon::Layers, "Clay: fill up to a plane above the surface (C)"),
    (Hand::Brush(Tool::Inflate), Icon::Maximize2, "Inflate: move along every vertex's own normal (I)"),
    (Hand::Brush(Tool::Smooth), Icon::Waves, "Smooth: take back detail finer than the edited level (S)"),
    (Hand::Brush(Tool::Sharpen), Icon::Sparkles, "Sharpen: amplify detail finer than the edited level (A)"),
    (Hand::Brush(Tool::Flatten), Icon::Minus, "Flatten: level the surface (T)"),
    (Hand::Brush(Tool::Pinch), Icon::Shrink, "Pinch: draw the surface together (P)"),
    (Hand::Brush(Tool::Crease), Icon::ChevronsDown, "Crease: cut a groove (R)"),
    (Hand::Brush(Tool::Erase), Icon::Eraser, "Erase detail from the edited level on (E)"),
    (Hand::Brush(Tool::Copy), Icon::Stamp, "Copy detail: Alt + click where it comes from, then paint (K)"),
    (
        Hand::Brush(Tool::Mask),
        Icon::VenetianMask,
        "Mask: keep what is painted from all tools, with Ctrl free it (M)",
    ),
];

/// Draws the tools.
pub(crate) fn toolbar(ui: &mut egui::Ui, seen: &Seen<'_>) -> Vec<Command> {
    let mut commands = Vec::new();
    let open = seen.work.is_none() && seen.preview.is_none() && seen.document.is_some();
    scrolled_icons(ui, |ui| {
        for (hand, icon, tip) in TOOLS {
            let held = open && seen.settings.hand == hand;
            ui.scope(|ui| {
                if held {
                    ui.visuals_mut().override_text_color = Some(theme::ACCENT);
                }
                if icon_button(ui, open, icon, &format!("{} tool", hand.name()), tip) {
                    commands.push(Command::Take(hand));
                }
            });
        }
    });
    commands
}
