//! The coefficient handle: press on the surface, drag the nearest coefficient of the chosen level.

use crate::editor::command::Command;
use crate::editor::document::Target;
use crate::render::Camera;
use glam::{DVec2, DVec3};

/// An axis of the model that a drag keeps to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Axis {
    /// The x axis.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

impl Axis {
    /// The axis in model space.
    pub(crate) fn direction(self) -> DVec3 {
        match self {
            Axis::X => DVec3::X,
            Axis::Y => DVec3::Y,
            Axis::Z => DVec3::Z,
        }
    }
}

/// What a drag takes hold of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Hold {
    /// The coefficient.
    Coefficient,
    /// The place of the surface.
    Place,
}

/// What happened.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum HandleEvent {
    /// The cursor is over a coefficient, or over none.
    Hover(Option<Target>),
    /// The button went down on a coefficient, at a point of the picture.
    Press(Target, DVec2, Hold),
    /// The cursor is at a point of the picture; whether the drag follows the normal.
    Move(DVec2, bool),
    /// The button went up.
    Release,
    /// Esc.
    Escape,
    /// An axis key, and where that axis of the model points in drawing space.
    Constrain(Axis, DVec3),
    /// The key that shows the state before went down or up.
    Before(bool),
}

/// A drag under way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drag {
    /// The coefficient.
    pub target: Target,
    /// From the vertex on the picture to the cursor when the button went down.
    grip: DVec2,
    axis: Option<(Axis, DVec3)>,
    /// How far the vertex has moved, in drawing space.
    pub moved: DVec3,
    before: bool,
}

/// The tool's state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) enum HandleTool {
    /// Nothing is held.
    #[default]
    Idle,
    /// The cursor is over a coefficient.
    Hovering(Target),
    /// A coefficient is being dragged.
    Dragging(Drag),
}

impl HandleTool {
    /// Takes an event; what is to be done about it. `picture` is the picture's size in points.
    pub(crate) fn on(&mut self, event: HandleEvent, camera: &Camera, picture: DVec2) -> Vec<Command> {
        match (&mut *self, event) {
            (HandleTool::Dragging(drag), HandleEvent::Move(cursor, along_normal)) => {
                let moved = drag.moved_to(cursor, along_normal, camera, picture);
                if moved == drag.moved || drag.before {
                    return Vec::new();
                }
                drag.moved = moved;
                vec![drag.command()]
            }
            (HandleTool::Dragging(drag), HandleEvent::Constrain(axis, drawn)) => {
                let held = drag.axis.is_some_and(|(held, _)| held == axis);
                drag.axis = (!held).then_some((axis, drawn));
                Vec::new()
            }
            (HandleTool::Dragging(drag), HandleEvent::Before(before)) if drag.before != before => {
                drag.before = before;
                vec![if before { Command::DragTo(DVec3::ZERO) } else { drag.command() }]
            }
            (HandleTool::Dragging(drag), HandleEvent::Release) => {
                let finish = drag.before.then(|| drag.command());
                *self = HandleTool::Idle;
                finish.into_iter().chain([Command::EndStroke]).collect()
            }
            (HandleTool::Dragging(_), HandleEvent::Escape) => {
                *self = HandleTool::Idle;
                vec![Command::CancelStroke]
            }
            (HandleTool::Dragging(_), _) => Vec::new(),
            (_, HandleEvent::Press(target, cursor, hold)) => {
                let on_picture = camera.project(target.position, picture).unwrap_or(cursor);
                let grip = cursor - on_picture;
                *self = HandleTool::Dragging(Drag {
                    target,
                    grip,
                    axis: None,
                    moved: DVec3::ZERO,
                    before: false,
                });
                let Target { kind, level, vertex, .. } = target;
                match hold {
                    Hold::Place => vec![Command::BeginGrab(target.position)],
                    Hold::Coefficient => {
                        vec![
                            Command::Select(Some(vertex)),
                            Command::BeginStroke { kind, level: level.0, vertex },
                        ]
                    }
                }
            }
            (_, HandleEvent::Hover(target)) => {
                *self = target.map_or(HandleTool::Idle, HandleTool::Hovering);
                Vec::new()
            }
            _ => Vec::new(),
        }
    }

    /// The coefficient under the cursor or in the hand.
    pub(crate) fn target(&self) -> Option<Target> {
        match self {
            HandleTool::Idle => None,
            HandleTool::Hovering(target) => Some(*target),
            HandleTool::Dragging(drag) => Some(drag.target),
        }
    }

    /// The drag under way.
    pub(crate) fn drag(&self) -> Option<&Drag> {
        match self {
            HandleTool::Dragging(drag) => Some(drag),
            _ => None,
        }
    }

    /// What the mouse and keys do now.
    pub(crate) fn hint(&self) -> String {
        match self {
            HandleTool::Idle => {
                "Drag the background: orbit · right drag: pan · wheel: zoom · point at the surface to edit"
                    .into()
            }
            HandleTool::Hovering(target) => format!(
                "Drag: move {} coefficient {} of level {} · Ctrl: along the normal",
                target.kind, target.vertex, target.level
            ),
            HandleTool::Dragging(drag) => {
                let axis = match drag.axis {
                    None => "X Y Z: keep to an axis".to_owned(),
                    Some((axis, _)) => format!("along {axis:?}, again to free it"),
                };
                let rest = match drag.target.kind {
                    bozzetto_core::edit::Kind::Scaling => "finer detail rides along",
                    bozzetto_core::edit::Kind::Wavelet => {
                        "neighbours move back so that the coarse shape stays"
                    }
                };
                format!("{rest} · {axis} · Ctrl: along the normal · B: before · Esc: cancel")
            }
        }
    }
}

impl Drag {
    /// Where the vertex has to be so that the surface stays under the cursor.
    fn moved_to(&self, cursor: DVec2, along_normal: bool, camera: &Camera, picture: DVec2) -> DVec3 {
        let start = self.target.position;
        let aim = cursor - self.grip;
        let line = match (self.axis, along_normal) {
            (Some((_, drawn)), _) => Some(drawn),
            (None, true) => Some(self.target.normal),
            (None, false) => None,
        };
        match line {
            None => camera.unproject(aim, start, picture) - start,
            Some(direction) => {
                // The point of the line nearest to the cursor's ray.
                let ray = camera.ray(aim, picture);
                let between = start - ray.origin;
                let (b, d, e) =
                    (direction.dot(ray.direction), direction.dot(between), ray.direction.dot(between));
                let spread = 1.0 - b * b;
                if spread < 1e-6 { self.moved } else { direction * ((b * e - d) / spread) }
            }
        }
    }

    /// The coefficient's delta: a wavelet moves its own vertex by less than itself.
    fn command(&self) -> Command {
        Command::DragTo(self.moved / self.target.peak)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bozzetto_core::edit::Kind;
    use bozzetto_core::hierarchy::{Level, PublicId, Slot};

    const PICTURE: DVec2 = DVec2::new(800.0, 600.0);

    fn target(peak: f64) -> Target {
        Target {
            kind: Kind::Scaling,
            level: Level(2),
            vertex: PublicId(7),
            slot: Slot(7),
            position: DVec3::new(0.2, 0.1, 0.5),
            normal: DVec3::Z,
            peak,
        }
    }

    fn dragged(tool: &mut HandleTool, camera: &Camera, event: HandleEvent) -> DVec3 {
        match tool.on(event, camera, PICTURE).as_slice() {
            [Command::DragTo(delta)] => *delta,
            other => panic!("expected one move, got {other:?}"),
        }
    }

    #[test]
    fn the_vertex_stays_under_the_cursor() {
        let camera = Camera::default();
        let target = target(0.5);
        let at = camera.project(target.position, PICTURE).expect("in view");
        let mut tool = HandleTool::default();
        let begun = tool.on(
            HandleEvent::Press(target, at + DVec2::new(3.0, -2.0), Hold::Coefficient),
            &camera,
            PICTURE,
        );
        assert!(matches!(begun.as_slice(), [Command::Select(_), Command::BeginStroke { level: 2, .. }]));
        let cursor = at + DVec2::new(43.0, 28.0);
        let delta = dragged(&mut tool, &camera, HandleEvent::Move(cursor, false));
        let now = camera.project(target.position + delta * target.peak, PICTURE).expect("in view");
        assert!((now - (at + DVec2::new(40.0, 30.0))).length() < 1e-6);
    }

    #[test]
    fn an_axis_and_the_normal_hold_the_drag() {
        let camera = Camera::default();
        let target = target(1.0);
        let at = camera.project(target.position, PICTURE).expect("in view");
        let mut tool = HandleTool::default();
        tool.on(HandleEvent::Press(target, at, Hold::Coefficient), &camera, PICTURE);
        tool.on(HandleEvent::Constrain(Axis::Z, DVec3::Y), &camera, PICTURE);
        let delta = dragged(&mut tool, &camera, HandleEvent::Move(at + DVec2::new(10.0, -50.0), false));
        assert!(delta.x == 0.0 && delta.z == 0.0 && delta.y > 0.0);
        tool.on(HandleEvent::Constrain(Axis::Z, DVec3::Y), &camera, PICTURE);
        let delta = dragged(&mut tool, &camera, HandleEvent::Move(at + DVec2::new(-60.0, 5.0), true));
        assert!(delta.x == 0.0 && delta.y == 0.0 && delta.z != 0.0);
    }

    #[test]
    fn before_and_escape_restore() {
        let camera = Camera::default();
        let target = target(1.0);
        let at = camera.project(target.position, PICTURE).expect("in view");
        let mut tool = HandleTool::default();
        tool.on(HandleEvent::Press(target, at, Hold::Coefficient), &camera, PICTURE);
        let delta = dragged(&mut tool, &camera, HandleEvent::Move(at + DVec2::splat(20.0), false));
        assert_eq!(dragged(&mut tool, &camera, HandleEvent::Before(true)), DVec3::ZERO);
        assert_eq!(dragged(&mut tool, &camera, HandleEvent::Before(false)), delta);
        assert!(matches!(tool.on(HandleEvent::Escape, &camera, PICTURE).as_slice(), [Command::CancelStroke]));
        assert_eq!(tool, HandleTool::Idle);
    }
}
