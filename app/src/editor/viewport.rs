//! The picture of the surface in the window: what the mouse does over it, and what is written beside the cursor.

use super::command::Command;
use super::document::{Document, Target};
use super::settings::Settings;
use super::tools::{Axis, HandleEvent, HandleTool};
use crate::render::{Camera, Style, Viewport};
use egui::{Event, Key, PointerButton, Rect, Ui};
use glam::DVec2;

/// What the picture needs of the editor.
pub(super) struct Picture<'a> {
    /// The open surface; away while work holds it.
    pub document: Option<&'a Document>,
    /// The choices.
    pub settings: &'a Settings,
    /// Where it is looked at from.
    pub camera: &'a Camera,
    /// The tool in the hand.
    pub tool: &'a mut HandleTool,
    /// The drag of the camera under way.
    pub turning: &'a mut Option<Turning>,
    /// The renderer.
    pub viewport: &'a Viewport,
    /// The look.
    pub style: Style,
    /// Whether keys and mouse are for the picture (no dialog, no text field).
    pub listening: bool,
}

/// How a drag moves the camera.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Turning {
    /// About the target.
    Orbit,
    /// Across the picture.
    Pan,
}

/// Points of dragging for a half turn.
const POINTS_PER_HALF_TURN: f64 = 500.0;

/// Radians for points dragged.
pub(super) fn orbit_angles(points: DVec2) -> DVec2 {
    DVec2::new(-points.x, points.y) * (std::f64::consts::PI / POINTS_PER_HALF_TURN)
}

/// Draws the picture and listens to it; where it lies and what is asked for.
pub(super) fn picture(ui: &mut Ui, mut picture: Picture<'_>) -> (Rect, Vec<Command>) {
    let rect = ui.available_rect_before_wrap();
    let response = ui.allocate_rect(rect, egui::Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, "Surface"));
    ui.painter().add(picture.viewport.shape(rect, picture.camera, &picture.style));
    let mut commands = Vec::new();
    if picture.listening {
        let over = response.contains_pointer();
        commands.extend(picture.camera_drag(ui, rect, over));
        commands.extend(picture.hand(ui, rect, over));
    }
    picture.caption(ui, rect);
    (rect, commands)
}

impl Picture<'_> {
    /// Middle and right buttons, Alt + left, left beside the surface, and the wheel.
    fn camera_drag(&mut self, ui: &Ui, rect: Rect, over: bool) -> Vec<Command> {
        let size = points(rect.size());
        let mut commands = Vec::new();
        ui.input(|input| {
            let pointer = &input.pointer;
            let (shift, alt) = (input.modifiers.shift, input.modifiers.alt);
            let held = |button| pointer.button_down(button);
            if over && self.turning.is_none() && self.tool.drag().is_none() && pointer.any_pressed() {
                *self.turning = if pointer.button_pressed(PointerButton::Secondary) {
                    Some(Turning::Pan)
                } else if pointer.button_pressed(PointerButton::Middle) {
                    Some(if shift { Turning::Pan } else { Turning::Orbit })
                } else if pointer.primary_pressed()
                    && (alt || self.target(pointer.interact_pos(), rect).is_none())
                {
                    Some(Turning::Orbit)
                } else {
                    None
                };
            }
            if !held(PointerButton::Primary)
                && !held(PointerButton::Middle)
                && !held(PointerButton::Secondary)
            {
                *self.turning = None;
            }
            let moved = points(pointer.delta());
            match *self.turning {
                Some(Turning::Orbit) if moved != DVec2::ZERO => commands.push(Command::Orbit(moved)),
                Some(Turning::Pan) if moved != DVec2::ZERO => commands.push(Command::Pan(moved)),
                _ => {}
            }
            let scroll = f64::from(input.smooth_scroll_delta().y);
            let pinch = f64::from(input.zoom_delta());
            if over && (scroll != 0.0 || pinch != 1.0) {
                let at = pointer.hover_pos().map_or(size * 0.5, |p| points(p - rect.min));
                commands.push(Command::Zoom((-scroll * 0.004).exp() / pinch, at));
            }
        });
        commands
    }

    /// The tool's events, in the order in which they happened: press, moves and release can share a frame, and what
    /// comes after a release is none of the drag's business.
    fn hand(&mut self, ui: &Ui, rect: Rect, over: bool) -> Vec<Command> {
        let size = points(rect.size());
        let mut events = Vec::new();
        ui.input(|input| {
            let at = |pos: egui::Pos2| points(pos - rect.min);
            let free = over && self.turning.is_none() && !input.modifiers.alt;
            let along_normal = input.modifiers.ctrl;
            if self.tool.drag().is_none() {
                let hovered = if free { self.target(input.pointer.latest_pos(), rect) } else { None };
                events.push(HandleEvent::Hover(hovered));
            }
            for event in &input.events {
                match *event {
                    Event::PointerMoved(pos) => {
                        // Of moves in a row only the last counts.
                        if let Some(HandleEvent::Move(..)) = events.last() {
                            events.pop();
                        }
                        events.push(HandleEvent::Move(at(pos), along_normal));
                    }
                    Event::PointerButton { pos, button: PointerButton::Primary, pressed: true, .. }
                        if free =>
                    {
                        if let Some(target) = self.target(pos, rect) {
                            events.push(HandleEvent::Press(target, at(pos)));
                        }
                    }
                    Event::PointerButton { pos, button: PointerButton::Primary, pressed: false, .. } => {
                        events.push(HandleEvent::Move(at(pos), along_normal));
                        events.push(HandleEvent::Release);
                    }
                    _ => {}
                }
            }
            for (key, axis) in [(Key::X, Axis::X), (Key::Y, Axis::Y), (Key::Z, Axis::Z)] {
                if input.key_pressed(key) && input.modifiers.is_none() {
                    // The model's axes, however it stands.
                    let turned = |d: &Document| d.vertices().frame().turn(axis.direction());
                    events.extend(self.document.map(|d| HandleEvent::Constrain(axis, turned(d))));
                }
            }
            // Keys pressed or let go move the drag even while the hand rests.
            if let (Some(pos), true) = (input.pointer.latest_pos(), input.pointer.primary_down()) {
                events.push(HandleEvent::Move(at(pos), along_normal));
            }
            events.push(HandleEvent::Before(input.key_down(Key::B)));
            if input.key_pressed(Key::Escape) {
                events.push(HandleEvent::Escape);
            }
            if !input.pointer.primary_down() {
                events.push(HandleEvent::Release);
            }
        });
        events.into_iter().flat_map(|event| self.tool.on(event, self.camera, size)).collect()
    }

    /// The coefficient under a point of the window.
    fn target(&self, at: impl Into<Option<egui::Pos2>>, rect: Rect) -> Option<Target> {
        let (document, at) = (self.document?, at.into()?);
        let ray = self.camera.ray(points(at - rect.min), points(rect.size()));
        let hit = document.pick(&ray)?;
        let target = document.target_at(&hit, self.settings.kind, self.settings.level);
        let exists = self.settings.shown >= self.settings.level;
        exists.then_some(target)
    }

    /// Distance by the cursor while dragging.
    fn caption(&self, ui: &Ui, rect: Rect) {
        let (Some(drag), Some(document), Some(at)) =
            (self.tool.drag(), self.document, ui.ctx().pointer_latest_pos())
        else {
            return;
        };
        let length = drag.moved.length();
        let share = length / (2.0 * document.sphere().radius) * 100.0;
        let unit = &document.surface().form().placement.unit;
        let space = if unit.is_empty() { "" } else { "\u{202f}" };
        let mut text = format!("{length:.4}{space}{unit}  ({share:.1} % of the size)");
        if let Some(level) = document.preview() {
            text += &format!("  ·  level {level} shown until you let go");
        }
        let place = (at + egui::vec2(16.0, 14.0)).clamp(rect.min, rect.max - egui::vec2(400.0, 24.0));
        let galley =
            ui.painter().layout_no_wrap(text, egui::FontId::proportional(13.0), egui::Color32::WHITE);
        let back = Rect::from_min_size(place, galley.size()).expand(5.0);
        ui.painter().rect_filled(back, 4.0, egui::Color32::from_black_alpha(170));
        ui.painter().galley(place, galley, egui::Color32::WHITE);
    }
}

fn points(v: egui::Vec2) -> DVec2 {
    DVec2::new(f64::from(v.x), f64::from(v.y))
}
