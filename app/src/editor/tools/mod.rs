//! Tools: state machines from events to commands, with their hints. They see neither panels nor the renderer's device.

mod handle;

pub(super) use handle::{Axis, HandleEvent, HandleTool};
