//! Tools: state machines from events to commands, with their hints. They see neither panels nor the renderer's device.

mod brush;
mod handle;
mod pen;

pub(super) use brush::{BrushEvent, BrushTool, Choice, Held, Touch, trailed};
pub(super) use handle::{Axis, HandleEvent, HandleTool, Hold};
pub use pen::{PenEvent, PenInput, RecordedPen, TouchPen};
