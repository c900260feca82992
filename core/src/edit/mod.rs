//! Edits: the vocabulary, planning and applying, undo steps, log lines as text.
//!
//! An edit is planned first (fallible, pure) and applied second. Floating point is used only while planning, with
//! `+ − × ÷ sqrt` alone, and rounded to integers once.

mod apply;
mod line;
mod plan;
mod region;
mod vocabulary;

pub use apply::Step;
pub use line::{Entry, LONGEST_LINE, Line, LineError};
pub use plan::{EditError, Plan, Region, plan};
pub use vocabulary::{Edit, Falloff, Gain, Kind, Move};
