//! `M^0 … M^J` without positions: base mesh, grids, nested ids, neighbourhoods, detection.
//!
//! Fine connectivity is never stored. Each base face owns a triangular grid; neighbours are index arithmetic, and
//! vertices on base edges and base vertices exist once.

mod address;
mod base_mesh;
pub mod detection;
mod ids;
mod layout;
mod neighbourhood;
mod subtriangle;
mod tables;

pub use address::Address;
pub use base_mesh::{BaseMesh, EdgeSide, Fan, NotABaseMesh};
pub use ids::{Level, Odd, PublicId, Slot};
pub use layout::{FINEST_LEVEL, Layout, MOST_VERTICES, Site};
pub use neighbourhood::{DIRECTIONS, Ring};
pub use subtriangle::Subtriangle;
pub(crate) use tables::for_each_triangle_of_face;
pub use tables::{Hierarchy, row_slots};
