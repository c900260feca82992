//! Pens of graphics tablets: on Wayland and Windows from the window system's own protocol, by the crate octotablet.
//!
//! On Wayland whoever asks for a tablet gets all of its pen, so what it points at comes from here too. On Windows the window
//! hears the pen as touches anyway, and only the pressure is taken. A window without tablets costs nothing; with one it looks for the
//! pen ten times a second, for the system does not wake a window that no event is for.

use crate::editor::tools::{PenEvent, PenInput, TouchPen};
use octotablet::builder::{BuildError, Builder};
use octotablet::events::{Event, ToolEvent};
use octotablet::{Backend, Manager};
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Duration;

/// How often to look for a pen that is elsewhere, and for one that is here.
const LOOKING: Duration = Duration::from_millis(100);
const FOLLOWING: Duration = Duration::from_millis(8);

/// The pens of a window.
pub(in crate::editor) struct TabletPen {
    /// None once it has failed.
    manager: Option<Manager>,
    /// Whether the window hears the pen as well.
    heard_elsewhere: bool,
    hand: PenHand,
    touches: TouchPen,
}

/// A pen as this window sees it.
#[derive(Debug, Default)]
struct PenHand {
    at: [f32; 2],
    here: bool,
    down: bool,
    force: Option<f64>,
    /// One for each event since the pen went down.
    forces: VecDeque<f64>,
    events: Vec<PenEvent>,
}

impl TabletPen {
    /// The pens of a window, where its system has a way to them that is known here; why not, where one that should be there
    /// is not.
    pub(in crate::editor) fn of<Window>(window: &Arc<Window>) -> Result<Option<Self>, String>
    where
        Window: raw_window_handle::HasDisplayHandle + raw_window_handle::HasWindowHandle + 'static,
    {
        // Windows without its pen service panics in there.
        let built = catch_unwind(AssertUnwindSafe(|| {
            Builder::new().emulate_tool_from_mouse(false).build_shared(window)
        }));
        match built {
            Ok(Ok(manager)) => {
                let heard_elsewhere = matches!(manager.backed(), Backend::WindowsInkRealTimeStylus);
                let (hand, touches) = Default::default();
                Ok(Some(Self { manager: Some(manager), heard_elsewhere, hand, touches }))
            }
            Ok(Err(BuildError::Unsupported)) => Ok(None),
            Ok(Err(error)) => Err(error.to_string()),
            Err(_) => Err("the system's pen service did not answer".to_owned()),
        }
    }
}

impl PenInput for TabletPen {
    fn heard(&mut self, force: Option<f32>) {
        self.touches.heard(force);
    }

    fn pressure(&mut self) -> Option<f64> {
        self.hand.pressure().or_else(|| self.touches.pressure())
    }

    fn strokes(&mut self) -> Vec<PenEvent> {
        self.hand.begin();
        let Some(manager) = &mut self.manager else { return Vec::new() };
        let pumped = catch_unwind(AssertUnwindSafe(|| {
            let Ok(events) = manager.pump() else { return false };
            for event in events {
                if let Event::Tool { event, .. } = event {
                    self.hand.on(&event);
                }
            }
            true
        }));
        if !pumped.unwrap_or(false) {
            tracing::warn!("the tablet's pen is lost");
            self.manager = None;
            self.hand.gone();
        }
        let events = std::mem::take(&mut self.hand.events);
        if self.heard_elsewhere { Vec::new() } else { events }
    }

    fn asks_again_in(&self) -> Option<Duration> {
        let manager = self.manager.as_ref()?;
        match self.hand.here {
            true => Some(FOLLOWING),
            false => (!manager.tablets().is_empty()).then_some(LOOKING),
        }
    }
}

impl PenHand {
    /// Another frame: of the forces of the last one, that of now is kept.
    fn begin(&mut self) {
        self.forces.clear();
    }

    fn pressure(&mut self) -> Option<f64> {
        self.forces.pop_front().or(self.force)
    }

    fn on(&mut self, event: &ToolEvent<'_>) {
        match event {
            ToolEvent::In { .. } => self.here = true,
            ToolEvent::Pose(pose) => self.moved(pose.position, pose.pressure.get().map(f64::from)),
            ToolEvent::Down => self.went_down(),
            ToolEvent::Up => self.went_up(),
            ToolEvent::Out | ToolEvent::Removed => self.gone(),
            _ => {}
        }
    }

    fn moved(&mut self, at: [f32; 2], force: Option<f64>) {
        self.here = true;
        self.at = at;
        self.force = force.map(|force| force.clamp(0.0, 1.0));
        if self.down {
            self.forces.extend(self.force);
        } else if let Some(PenEvent::Moved(_)) = self.events.last() {
            // In the air only the last place counts.
            self.events.pop();
        }
        self.events.push(PenEvent::Moved(at));
    }

    fn went_down(&mut self) {
        self.down = true;
        self.forces.clear();
        self.forces.extend(self.force);
        self.events.push(PenEvent::Down(self.at));
    }

    fn went_up(&mut self) {
        if std::mem::take(&mut self.down) {
            self.events.push(PenEvent::Up(self.at));
        }
    }

    fn gone(&mut self) {
        self.went_up();
        if std::mem::take(&mut self.here) {
            self.events.push(PenEvent::Gone);
        }
        self.force = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The forces that the brush asks for are those of the events it hears, in their order.
    #[test]
    fn each_touch_has_its_own_force() {
        let mut hand = PenHand::default();
        hand.begin();
        for x in [1.0, 2.0, 3.0] {
            hand.moved([x, 0.0], Some(0.0));
        }
        hand.moved([4.0, 0.0], Some(0.1));
        hand.went_down();
        hand.moved([5.0, 0.0], Some(0.5));
        hand.moved([6.0, 0.0], Some(0.9));
        assert_eq!(
            std::mem::take(&mut hand.events),
            [
                PenEvent::Moved([4.0, 0.0]),
                PenEvent::Down([4.0, 0.0]),
                PenEvent::Moved([5.0, 0.0]),
                PenEvent::Moved([6.0, 0.0])
            ]
        );
        let asked: Vec<Option<f64>> = (0..4).map(|_| hand.pressure()).collect();
        assert_eq!(asked, [Some(0.1), Some(0.5), Some(0.9), Some(0.9)]);
        hand.begin();
        assert_eq!(hand.pressure(), Some(0.9), "a pen that rests presses on");
        hand.gone();
        assert_eq!(hand.events, [PenEvent::Up([6.0, 0.0]), PenEvent::Gone], "a pen that leaves is up");
        assert_eq!(hand.pressure(), None);
    }
}
