//! Keys that mean the same everywhere in the window.

use super::command::Command;
use super::dialog::{Dialog, PathTask};
use super::settings::{Hand, Settings};
use crate::render::View;
use bozzetto_core::edit::{Kind, Tool};
use egui::{Key, Modifiers};

/// What the brackets multiply the brush's radius by.
const SIZE_STEP: f64 = 1.15;

/// Keys of the tools.
const TOOLS: [(Key, Hand); 13] = [
    (Key::H, Hand::Handle),
    (Key::G, Hand::Grab),
    (Key::V, Hand::Brush(Tool::Draw)),
    (Key::C, Hand::Brush(Tool::Clay)),
    (Key::I, Hand::Brush(Tool::Inflate)),
    (Key::S, Hand::Brush(Tool::Smooth)),
    (Key::A, Hand::Brush(Tool::Sharpen)),
    (Key::T, Hand::Brush(Tool::Flatten)),
    (Key::P, Hand::Brush(Tool::Pinch)),
    (Key::R, Hand::Brush(Tool::Crease)),
    (Key::E, Hand::Brush(Tool::Erase)),
    (Key::K, Hand::Brush(Tool::Copy)),
    (Key::M, Hand::Brush(Tool::Mask)),
];

/// The commands of the keys pressed. Off while text is typed.
pub(super) fn shortcuts(ctx: &egui::Context, settings: &Settings, dragging: bool) -> Vec<Command> {
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
        (Modifiers::NONE, Key::Period, Command::FrameStroke),
        (Modifiers::NONE, Key::Home, Command::Fit),
        (Modifiers::NONE, Key::N, Command::ToggleInspector),
        (Modifiers::NONE, Key::OpenBracket, Command::SetBrushRadius(settings.brush_radius / SIZE_STEP)),
        (Modifiers::NONE, Key::CloseBracket, Command::SetBrushRadius(settings.brush_radius * SIZE_STEP)),
        (Modifiers::NONE, Key::F1, Command::Ask(Dialog::Keys)),
    ];
    let pressed = |(modifiers, key, command): (Modifiers, Key, Command)| {
        ctx.input_mut(|input| input.consume_key(modifiers, key)).then_some(command)
    };
    let mut commands: Vec<Command> = keys.into_iter().filter_map(pressed).collect();
    if !dragging {
        // While something is dragged these keep it to an axis.
        let axes = [(Key::X, 0), (Key::Y, 1), (Key::Z, 2)];
        let axes = axes.map(|(key, axis)| (Modifiers::NONE, key, Command::ToggleSymmetry(axis)));
        let tools = TOOLS.map(|(key, hand)| (Modifiers::NONE, key, Command::Take(hand)));
        commands.extend(axes.into_iter().chain(tools).filter_map(pressed));
    }
    commands
}
