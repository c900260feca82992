//! Edits: the vocabulary, planning and applying, undo steps, log lines as text.
//!
//! An edit is planned first (fallible, pure) and applied second. Floating point is used only while planning, with
//! `+ − × ÷ sqrt` alone, and rounded to integers once.

mod apply;
mod brush_stroke;
mod brushes;
mod copying;
mod deltas;
mod detail_pull;
mod details;
mod equalise;
pub(crate) mod extent;
mod follow;
mod glimpse;
mod hide;
mod levels;
mod line;
mod moved_region;
mod plan;
mod pull;
mod reach;
mod region;
mod spread;
mod stroke;
mod vocabulary;
mod weighted;

pub(crate) use apply::Direction;
pub use apply::Step;
pub use brush_stroke::BrushStroke;
pub use deltas::{Deltas, Kept, MaskChange, Packed};
pub use equalise::{Equalise, Equaliser, Over};
pub use follow::{Follow, Turned};
pub(crate) use glimpse::Glimpse;
pub use hide::{Hide, Part};
pub use levels::{LevelChange, Levels};
pub use line::{Entry, LONGEST_LINE, Line, LineError};
pub use moved_region::Region;
pub(crate) use moved_region::added;
pub use plan::{EditError, Plan, plan};
pub use pull::{Pull, Pulled, Spread};
pub use reach::true_reach;
pub use stroke::{Dab, MOST_DABS, Mirror, Stroke, Tool};
pub use vocabulary::{Edit, Falloff, Gain, Kind, Move};
pub(crate) use weighted::weighted_steps;
