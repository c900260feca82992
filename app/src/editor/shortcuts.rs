//! Keys that mean the same everywhere in the window.

use super::command::Command;
use super::dialog::{Dialog, PathTask};
use super::settings::Settings;
use crate::render::View;
use bozzetto_core::edit::Kind;
use egui::{Key, Modifiers};

/// The commands of the keys pressed. Off while text is typed.
pub(super) fn shortcuts(ctx: &egui::Context, settings: &Settings) -> Vec<Command> {
    if ctx.egui_wants_keyboard_input() {
        return Vec::new();
    }
    let (ctrl, shift) = (Modifiers::COMMAND, Modifiers::SHIFT);
    let level = settings.level.0;
    let finer = Command::SetLevel(level + 1);
    let coarser = Command::SetLevel(level.saturating_sub(1));
    let other = match settings.kind {
        Kind::Scaling => Kind::Wavelet,
        Kind::Wavelet => Kind::Scaling,
    };
    // Longer combinations first: consuming Ctrl+Z would swallow Ctrl+Shift+Z.
    let keys = [
        (ctrl | shift, Key::Z, Command::Redo),
        (ctrl, Key::Z, Command::Undo),
        (ctrl, Key::Y, Command::Redo),
        (ctrl | shift, Key::S, Command::Ask(PathTask::SaveAs.dialog())),
        (ctrl, Key::S, Command::Save),
        (ctrl, Key::O, Command::Ask(PathTask::Open.dialog())),
        (shift, Key::D, coarser.clone()),
        (Modifiers::NONE, Key::D, finer.clone()),
        (Modifiers::NONE, Key::PageUp, finer),
        (Modifiers::NONE, Key::PageDown, coarser),
        (Modifiers::NONE, Key::W, Command::SetKind(other)),
        (Modifiers::NONE, Key::Num1, Command::Look(View::FRONT)),
        (Modifiers::NONE, Key::Num3, Command::Look(View::RIGHT)),
        (Modifiers::NONE, Key::Num7, Command::Look(View::TOP)),
        (Modifiers::NONE, Key::Period, Command::Fit),
        (Modifiers::NONE, Key::F1, Command::Ask(Dialog::Keys)),
    ];
    let pressed = |(modifiers, key, command): (Modifiers, Key, Command)| {
        ctx.input_mut(|input| input.consume_key(modifiers, key)).then_some(command)
    };
    keys.into_iter().filter_map(pressed).collect()
}
