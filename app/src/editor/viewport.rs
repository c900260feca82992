//! The picture of the surface in the window: what the mouse does over it, and what is written beside the cursor.

use super::command::Command;
use super::cursor::{self, Look};
use super::document::{Document, Target};
use super::settings::{Hand, Navigation, Settings};
use super::tools::{
    Axis, BrushEvent, BrushTool, Choice, HandleEvent, HandleTool, Held, Hold, PenInput, Touch, trailed,
};
use crate::render::{Camera, Style, Viewport};
use bozzetto_core::edit::Tool;
use egui::{Event, Key, PointerButton, Rect, Ui};
use glam::{DVec2, DVec3};

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
    /// The brush in the hand.
    pub brush: &'a mut BrushTool,
    /// Where the brush is that trails behind the cursor.
    pub trailing: &'a mut Option<DVec2>,
    /// Where copied detail comes from.
    pub copy_from: &'a mut Option<[f64; 3]>,
    /// The pen.
    pub pen: &'a mut dyn PenInput,
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
    /// Nearer and farther.
    Zoom,
}

/// What a button other than the left does to the camera; the left turns it with Alt and on the background.
fn turning(navigation: Navigation, button: PointerButton, held: egui::Modifiers) -> Option<Turning> {
    Some(match (navigation, button) {
        (Navigation::Blender, PointerButton::Middle) if held.ctrl => Turning::Zoom,
        (Navigation::Blender, PointerButton::Middle) if held.shift => Turning::Pan,
        (Navigation::Blender, PointerButton::Middle) => Turning::Orbit,
        (Navigation::Blender, _) => Turning::Pan,
        (Navigation::Maya, PointerButton::Middle) => Turning::Pan,
        (Navigation::Maya, _) if held.alt => Turning::Zoom,
        (Navigation::Maya, _) => Turning::Pan,
        (Navigation::ZBrush, PointerButton::Middle) => Turning::Pan,
        (Navigation::ZBrush, _) if held.alt => Turning::Pan,
        (Navigation::ZBrush, _) if held.ctrl => Turning::Zoom,
        (Navigation::ZBrush, _) => Turning::Orbit,
    })
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
        let choosing = picture.brush.is_choosing();
        commands.extend(match picture.settings.hand {
            Hand::Handle | Hand::Grab if !choosing => picture.hand(ui, rect, over),
            _ => picture.paint(ui, rect, over),
        });
        commands.extend(picture.choose(ui, rect, over));
    }
    picture.ring(ui, rect);
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
            let alt = input.modifiers.alt;
            let held = |button| pointer.button_down(button);
            let busy = self.tool.drag().is_some() || self.brush.is_stroking() || self.brush.is_choosing();
            if over && self.turning.is_none() && !busy && pointer.any_pressed() {
                let pressed = |button| pointer.button_pressed(button);
                let beside = || self.target(pointer.interact_pos(), rect).is_none();
                let modifiers = input.modifiers;
                *self.turning = if pressed(PointerButton::Secondary) {
                    turning(self.settings.navigation, PointerButton::Secondary, modifiers)
                } else if pressed(PointerButton::Middle) {
                    turning(self.settings.navigation, PointerButton::Middle, modifiers)
                } else if pressed(PointerButton::Primary) {
                    let copying = self.settings.hand == Hand::Brush(Tool::Copy) && alt && !beside();
                    match (alt, copying) {
                        (_, true) => None,
                        (true, _) if self.settings.navigation == Navigation::ZBrush => Some(Turning::Pan),
                        (true, _) => Some(Turning::Orbit),
                        (false, _) => beside().then_some(Turning::Orbit),
                    }
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
                Some(Turning::Zoom) if moved != DVec2::ZERO => {
                    commands.push(Command::Zoom((moved.y * 0.008).exp(), size * 0.5));
                }
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
                            let hold = match self.settings.hand {
                                Hand::Grab => Hold::Place,
                                _ => Hold::Coefficient,
                            };
                            events.push(HandleEvent::Press(target, at(pos), hold));
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
        if self.settings.hand != Hand::Handle {
            return Some(document.place_at(&hit));
        }
        let mut target = document.target_at(&hit, self.settings.kind, self.settings.level);
        if !self.settings.drags_raw() {
            // A pull goes as far as its vertex.
            target.peak = 1.0;
        }
        let exists = self.settings.shown >= self.settings.level;
        exists.then_some(target)
    }

    /// The place under a point of the picture.
    fn touch(&self, at: DVec2, rect: Rect) -> Option<Touch> {
        let document = self.document?;
        let hit = document.pick(&self.camera.ray(at, points(rect.size())))?;
        Some(Touch { point: hit.point, normal: document.normal_at(&hit) })
    }

    /// The brush's radius in drawing space.
    fn radius(&self) -> f64 {
        self.document.map_or(1.0, |d| self.settings.brush_radius * d.sphere().radius)
    }

    fn brushed(&mut self, event: BrushEvent) -> Vec<Command> {
        let radius = self.radius();
        self.brush.on(event, self.settings, radius)
    }

    /// The brush's events. Between two places of the cursor the brush goes straight over the picture.
    fn paint(&mut self, ui: &Ui, rect: Rect, over: bool) -> Vec<Command> {
        let at = |pos: egui::Pos2| points(pos - rect.min);
        let (events, modifiers, latest, down, escape) = ui.input(|i| {
            let escape = i.key_pressed(Key::Escape);
            (i.events.clone(), i.modifiers, i.pointer.latest_pos(), i.pointer.primary_down(), escape)
        });
        let free = over && self.turning.is_none();
        let mut commands = Vec::new();
        if !self.brush.is_stroking() && !self.brush.is_choosing() {
            let hovered = latest.filter(|_| free).and_then(|pos| self.touch(at(pos), rect));
            commands.extend(self.brushed(BrushEvent::Hover(hovered)));
        }
        for event in events {
            match event {
                Event::Touch { force, .. } => self.pen.heard(force),
                Event::PointerMoved(pos) if self.brush.is_stroking() => {
                    commands.extend(self.go_on(at(pos), rect));
                }
                Event::PointerButton { pos, button: PointerButton::Primary, pressed: true, .. }
                    if free && !self.brush.is_choosing() =>
                {
                    let Some(touch) = self.touch(at(pos), rect) else { continue };
                    if self.settings.hand == Hand::Brush(Tool::Copy) && modifiers.alt {
                        *self.copy_from = self.document.map(|d| d.model_place(touch.point));
                        continue;
                    }
                    if modifiers.alt {
                        continue;
                    }
                    *self.trailing = Some(at(pos));
                    let held = Held { shift: modifiers.shift, ctrl: modifiers.ctrl };
                    let pressure = self.pen.pressure();
                    commands.extend(self.brushed(BrushEvent::Press(touch, held, pressure)));
                }
                Event::PointerButton { button: PointerButton::Primary, pressed: false, .. } => {
                    commands.extend(self.brushed(BrushEvent::Release));
                }
                _ => {}
            }
        }
        if self.brush.is_stroking() && escape {
            commands.extend(self.brushed(BrushEvent::Escape));
        }
        if self.brush.is_stroking() && !down {
            commands.extend(self.brushed(BrushEvent::Release));
        }
        commands
    }

    /// Takes the brush on to where the cursor is, in steps shorter than a dab's distance.
    fn go_on(&mut self, cursor: DVec2, rect: Rect) -> Vec<Command> {
        let from = self.trailing.unwrap_or(cursor);
        let to = trailed(from, cursor, self.settings.steady);
        *self.trailing = Some(to);
        let pressure = self.pen.pressure();
        let size = points(rect.size());
        let place = self.brush.touch().map_or(self.camera.target, |touch| touch.point);
        let pixel = self.camera.world_per_pixel_at(place, size).max(1e-12);
        let step = (0.1 * self.radius() / pixel).max(1.0);
        let count = ((to - from).length() / step).ceil().clamp(1.0, 400.0);
        let mut commands = Vec::new();
        for k in 1..=count as u32 {
            if let Some(touch) = self.touch(from + (to - from) * (f64::from(k) / count), rect) {
                commands.extend(self.brushed(BrushEvent::Move(touch, pressure)));
            }
        }
        commands
    }

    /// Radius and strength by moving.
    fn choose(&mut self, ui: &Ui, rect: Rect, over: bool) -> Vec<Command> {
        let (cursor, f, shift, clicked, away) = ui.input(|i| {
            let pointer = &i.pointer;
            let away = i.key_pressed(Key::Escape) || pointer.button_pressed(PointerButton::Secondary);
            (pointer.latest_pos(), i.key_pressed(Key::F), i.modifiers.shift, pointer.primary_pressed(), away)
        });
        let Some(cursor) = cursor.map(|pos| points(pos - rect.min)) else { return Vec::new() };
        if self.brush.is_choosing() {
            if away {
                return self.brushed(BrushEvent::Escape);
            }
            let mut commands = self.brushed(BrushEvent::Slide(cursor));
            if clicked {
                commands.extend(self.brushed(BrushEvent::Confirm));
            }
            return commands;
        }
        let dragging = self.brush.is_stroking() || self.tool.drag().is_some();
        if f && over && !dragging && !ui.ctx().egui_wants_keyboard_input() {
            if self.brush.touch().is_none() {
                let hovered = self.touch(cursor, rect);
                self.brushed(BrushEvent::Hover(hovered));
            }
            let choice = if shift { Choice::Strength } else { Choice::Radius };
            return self.brushed(BrushEvent::Choose(choice, cursor));
        }
        Vec::new()
    }

    /// The brush's ring, or the grab's.
    fn ring(&self, ui: &Ui, rect: Rect) {
        let Some(document) = self.document else { return };
        let touch = match self.settings.hand {
            Hand::Handle if !self.brush.is_choosing() => None,
            Hand::Grab if !self.brush.is_choosing() => self.tool.target().map(|target| {
                let moved = self.tool.drag().map_or(DVec3::ZERO, |drag| drag.moved);
                Touch { point: target.position + moved, normal: target.normal }
            }),
            _ => self.brush.touch(),
        };
        self.source(ui, rect);
        let Some(touch) = touch else { return };
        let (shift, ctrl) = ui.input(|i| (i.modifiers.shift, i.modifiers.ctrl));
        let brush = matches!(self.settings.hand, Hand::Brush(_)) && !self.brush.is_choosing();
        let look = match (brush && shift, brush && ctrl) {
            (true, _) => Look::Smoothing,
            (_, true) => Look::Inverted,
            _ => Look::Plain,
        };
        let painter = ui.painter().with_clip_rect(rect);
        cursor::ring(&painter, rect, self.camera, (document, self.settings), touch, look);
    }

    /// Where copied detail comes from: a cross that goes along with the brush.
    fn source(&self, ui: &Ui, rect: Rect) {
        let (Some(document), Some(from)) = (self.document, *self.copy_from) else { return };
        if self.settings.hand != Hand::Brush(Tool::Copy) {
            return;
        }
        let frame = document.vertices().frame();
        let mut place = frame.place_model(from);
        let first = document.session.brush_words().and_then(|words| words.dabs.first());
        if let (Some(first), Some(now)) = (first, self.brush.touch()) {
            place += now.point - frame.place_model(first.at);
        }
        if let Some(at) = self.camera.project(place, points(rect.size())) {
            cursor::cross(
                &ui.painter().with_clip_rect(rect),
                rect.min + egui::vec2(at.x as f32, at.y as f32),
            );
        }
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
