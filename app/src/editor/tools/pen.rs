//! A pen, behind a seam: where it comes from differs from platform to platform.

use std::collections::VecDeque;
use std::time::Duration;

/// Where a pen's pressure comes from.
pub trait PenInput {
    /// The window heard this force of a touch, from 0 to 1, if its platform tells.
    fn heard(&mut self, force: Option<f32>);

    /// The pressure now, from 0 to 1; none without a pen. Asked when the brush goes down and once for every move of it.
    fn pressure(&mut self) -> Option<f64>;

    /// What the pen did since it was last asked, where the window hears nothing of it. Asked once a frame, before it.
    fn strokes(&mut self) -> Vec<PenEvent> {
        Vec::new()
    }

    /// How soon to ask again even if nothing else happens.
    fn asks_again_in(&self) -> Option<Duration> {
        None
    }
}

/// What a pen does that the window hears nothing of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PenEvent {
    /// It is over a point of the window, in logical pixels.
    Moved([f32; 2]),
    /// It went down there.
    Down([f32; 2]),
    /// It went up there.
    Up([f32; 2]),
    /// It left.
    Gone,
}

/// Pressure as the window system reports it with touches.
#[derive(Debug, Clone, Copy, Default)]
pub struct TouchPen {
    force: Option<f32>,
}

impl PenInput for TouchPen {
    fn heard(&mut self, force: Option<f32>) {
        self.force = force;
    }

    fn pressure(&mut self) -> Option<f64> {
        self.force.map(|force| f64::from(force).clamp(0.0, 1.0))
    }
}

/// Pressures written down beforehand, one for every move; the last one stays.
#[derive(Debug, Clone, Default)]
pub struct RecordedPen {
    pressures: VecDeque<f64>,
}

impl RecordedPen {
    /// A pen that presses so.
    pub fn new(pressures: impl IntoIterator<Item = f64>) -> Self {
        Self { pressures: pressures.into_iter().collect() }
    }
}

impl PenInput for RecordedPen {
    fn heard(&mut self, _: Option<f32>) {}

    fn pressure(&mut self) -> Option<f64> {
        if self.pressures.len() > 1 { self.pressures.pop_front() } else { self.pressures.front().copied() }
    }
}
