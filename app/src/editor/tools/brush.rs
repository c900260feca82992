//! The brush: touches the surface along the path of the cursor, at even distances.
//!
//! Also its two modal choices, radius and strength: moving sideways changes them, a click keeps what is seen, Esc and the
//! right button take it back.

use crate::editor::command::Command;
use crate::editor::settings::{Hand, Settings};
use bozzetto_core::edit::Tool;
use glam::{DVec2, DVec3};

/// Dabs follow each other at this share of the radius.
const SPACING: f64 = 0.25;
/// Points of movement that double the radius.
const POINTS_PER_OCTAVE: f64 = 120.0;
/// Points of movement for the whole range of strengths.
const POINTS_PER_STRENGTH: f64 = 240.0;

/// A place under the cursor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Touch {
    /// Where it is drawn.
    pub point: DVec3,
    /// The surface's normal there.
    pub normal: DVec3,
}

/// What is chosen by moving.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Choice {
    /// The radius.
    Radius,
    /// The strength.
    Strength,
}

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum BrushEvent {
    /// The cursor is over a place, or over none.
    Hover(Option<Touch>),
    /// The button went down on a place; with which modifiers, and a pen's pressure if there is one.
    Press(Touch, Held, Option<f64>),
    /// The brush went on to a place, with a pen's pressure if there is one.
    Move(Touch, Option<f64>),
    /// The button went up.
    Release,
    /// Esc or the right button.
    Escape,
    /// The key of a choice was pressed with the cursor at a point.
    Choose(Choice, DVec2),
    /// The cursor is at a point while something is chosen.
    Slide(DVec2),
    /// A click while something is chosen.
    Confirm,
}

/// The modifiers held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Held {
    /// Shift: smooth, whatever is in the hand.
    pub shift: bool,
    /// Ctrl: the other way round.
    pub ctrl: bool,
}

/// The tool's state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) enum BrushTool {
    /// The cursor is beside the surface.
    #[default]
    Idle,
    /// The cursor is over a place.
    Hovering(Touch),
    /// A stroke is under way.
    Stroking {
        /// The last dab.
        last: Touch,
        /// What it does.
        tool: Tool,
    },
    /// Something is chosen by moving sideways.
    Choosing {
        /// What.
        choice: Choice,
        /// Where the cursor was.
        from: DVec2,
        /// What it was.
        before: f64,
        /// Where the ring stays meanwhile.
        at: Option<Touch>,
    },
}

impl BrushTool {
    /// Takes an event; what is to be done about it. `radius` is the brush's in drawing space.
    pub(crate) fn on(&mut self, event: BrushEvent, settings: &Settings, radius: f64) -> Vec<Command> {
        match (*self, event) {
            (BrushTool::Stroking { last, tool }, BrushEvent::Move(touch, pressure)) => {
                let size = pressure.filter(|_| settings.pressure_radius).unwrap_or(1.0);
                if (touch.point - last.point).length() < SPACING * radius * size.max(0.1) {
                    return Vec::new();
                }
                *self = BrushTool::Stroking { last: touch, tool };
                vec![Command::Dab(touch.point, pressure)]
            }
            (BrushTool::Stroking { last, .. }, BrushEvent::Release) => {
                *self = BrushTool::Hovering(last);
                vec![Command::EndStroke]
            }
            (BrushTool::Stroking { .. }, BrushEvent::Escape) => {
                *self = BrushTool::Idle;
                vec![Command::CancelStroke]
            }
            (BrushTool::Stroking { .. }, _) => Vec::new(),
            (BrushTool::Choosing { choice, from, before, .. }, BrushEvent::Slide(to)) => {
                let moved = to.x - from.x;
                vec![match choice {
                    Choice::Radius => Command::SetBrushRadius(before * (moved / POINTS_PER_OCTAVE).exp2()),
                    Choice::Strength => Command::SetStrength(before + moved / POINTS_PER_STRENGTH),
                }]
            }
            (BrushTool::Choosing { .. }, BrushEvent::Confirm) => {
                *self = BrushTool::Idle;
                Vec::new()
            }
            (BrushTool::Choosing { choice, before, .. }, BrushEvent::Escape) => {
                *self = BrushTool::Idle;
                vec![match choice {
                    Choice::Radius => Command::SetBrushRadius(before),
                    Choice::Strength => Command::SetStrength(before),
                }]
            }
            (BrushTool::Choosing { .. }, _) => Vec::new(),
            (_, BrushEvent::Choose(choice, from)) => {
                let before = match choice {
                    Choice::Radius => settings.brush_radius,
                    Choice::Strength => settings.strength,
                };
                *self = BrushTool::Choosing { choice, from, before, at: self.touch() };
                Vec::new()
            }
            (_, BrushEvent::Press(touch, held, pressure)) => {
                let Hand::Brush(tool) = settings.hand else { return Vec::new() };
                let tool = if held.shift { Tool::Smooth } else { tool };
                *self = BrushTool::Stroking { last: touch, tool };
                vec![Command::BeginBrush(tool, held.ctrl), Command::Dab(touch.point, pressure)]
            }
            (_, BrushEvent::Hover(touch)) => {
                *self = touch.map_or(BrushTool::Idle, BrushTool::Hovering);
                Vec::new()
            }
            _ => Vec::new(),
        }
    }

    /// The place under the brush.
    pub(crate) fn touch(&self) -> Option<Touch> {
        match *self {
            BrushTool::Idle => None,
            BrushTool::Hovering(touch) | BrushTool::Stroking { last: touch, .. } => Some(touch),
            BrushTool::Choosing { at, .. } => at,
        }
    }

    /// Whether a stroke is under way.
    pub(crate) fn is_stroking(&self) -> bool {
        matches!(self, BrushTool::Stroking { .. })
    }

    /// Whether something is chosen by moving.
    pub(crate) fn is_choosing(&self) -> bool {
        matches!(self, BrushTool::Choosing { .. })
    }

    /// What the mouse and keys do now.
    pub(crate) fn hint(&self, settings: &Settings) -> String {
        let name = settings.hand.name();
        match self {
            BrushTool::Idle | BrushTool::Hovering(_) if settings.hand == Hand::Brush(Tool::Copy) => {
                "Alt + click: where the detail comes from · drag: copy it · F: radius · Shift+F: strength"
                    .into()
            }
            BrushTool::Idle => format!("{name} · point at the surface · F: radius · Shift+F: strength"),
            BrushTool::Hovering(_) => {
                format!(
                    "Drag: {name} · Shift: smooth · Ctrl: the other way round · F: radius · Shift+F: strength"
                )
            }
            BrushTool::Stroking { tool, .. } => format!("{} · Esc: take the stroke back", tool.name()),
            BrushTool::Choosing { choice, .. } => {
                let what = match choice {
                    Choice::Radius => format!("Radius {:.1} %", settings.brush_radius * 100.0),
                    Choice::Strength => format!("Strength {:.2}", settings.strength),
                };
                format!("{what} · move sideways · click: keep · Esc, right click: as it was")
            }
        }
    }
}

/// A point that trails behind the cursor on a line of a length: the hand's tremble stays within the slack.
pub(crate) fn trailed(behind: DVec2, cursor: DVec2, line: f64) -> DVec2 {
    let away = cursor - behind;
    let length = away.length();
    if length <= line { behind } else { cursor - away * (line / length) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn touch(x: f64) -> Touch {
        Touch { point: DVec3::new(x, 0.0, 0.0), normal: DVec3::Z }
    }

    fn with(tool: Tool) -> Settings {
        Settings { hand: Hand::Brush(tool), ..Settings::default() }
    }

    #[test]
    fn dabs_follow_each_other_at_even_distances_and_escape_takes_them_back() {
        let settings = with(Tool::Draw);
        let mut brush = BrushTool::default();
        let begun = brush.on(BrushEvent::Press(touch(0.0), Held::default(), None), &settings, 0.4);
        assert!(matches!(begun.as_slice(), [Command::BeginBrush(Tool::Draw, false), Command::Dab(..)]));
        let mut dabs = 0;
        for step in 1..=100 {
            dabs += brush.on(BrushEvent::Move(touch(f64::from(step) * 0.01), None), &settings, 0.4).len();
        }
        assert!((9..=10).contains(&dabs), "{dabs} dabs over two and a half radii");
        assert!(matches!(brush.on(BrushEvent::Escape, &settings, 0.4).as_slice(), [Command::CancelStroke]));
        assert_eq!(brush, BrushTool::Idle);
    }

    #[test]
    fn shift_smooths_and_ctrl_turns_round() {
        let settings = with(Tool::Clay);
        for (held, tool, inverted) in [
            (Held { shift: true, ctrl: false }, Tool::Smooth, false),
            (Held { shift: false, ctrl: true }, Tool::Clay, true),
        ] {
            let begun = BrushTool::default().on(BrushEvent::Press(touch(0.0), held, None), &settings, 1.0);
            assert!(matches!(begun[0], Command::BeginBrush(t, i) if t == tool && i == inverted), "{begun:?}");
        }
    }

    #[test]
    fn a_choice_is_kept_by_a_click_and_taken_back_by_escape() {
        let mut settings = with(Tool::Draw);
        settings.brush_radius = 0.1;
        let mut brush = BrushTool::Hovering(touch(0.0));
        brush.on(BrushEvent::Choose(Choice::Radius, DVec2::ZERO), &settings, 1.0);
        let slid = brush.on(BrushEvent::Slide(DVec2::new(POINTS_PER_OCTAVE, 5.0)), &settings, 1.0);
        assert!(matches!(slid.as_slice(), [Command::SetBrushRadius(r)] if (r - 0.2).abs() < 1e-12));
        assert!(brush.on(BrushEvent::Confirm, &settings, 1.0).is_empty() && !brush.is_choosing());
        brush.on(BrushEvent::Choose(Choice::Strength, DVec2::ZERO), &settings, 1.0);
        let back = brush.on(BrushEvent::Escape, &settings, 1.0);
        assert!(matches!(back.as_slice(), [Command::SetStrength(s)] if *s == settings.strength));
    }

    #[test]
    fn a_steadied_brush_trails_within_its_line() {
        let mut behind = DVec2::ZERO;
        for step in 0..50 {
            let tremble = if step % 2 == 0 { 3.0 } else { -3.0 };
            behind = trailed(behind, DVec2::new(f64::from(step) * 4.0, tremble), 20.0);
            assert!(behind.y.abs() < 3.0);
        }
        assert!((DVec2::new(196.0, -3.0) - behind).length() <= 20.0 + 1e-9);
    }
}
