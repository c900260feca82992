//! Any mesh or picture to a hierarchy with positions.

mod along;
mod approach;
mod aside;
mod attempts;
mod base_flips;
pub mod clean;
mod collapse;
mod convert;
mod costs;
mod creases;
mod curves;
mod density;
mod domain;
mod edge_flips;
mod even;
mod fans;
mod fit;
mod fitted;
mod flatten;
mod globe;
mod halve;
mod held;
mod lattice;
mod lay_out;
mod marks;
mod mend;
mod mirror;
mod normal_equations;
mod parameterise;
mod patch;
mod prepared;
mod pulls;
mod quadric;
pub mod remesh;
mod simplify;
mod size;
mod symmetry;
mod target;
mod thin;
mod unfold;
mod walk;
mod warp;
mod watch;
mod working_mesh;

pub use along::{Goal, move_along};
pub use convert::{
    ConversionError, ConversionOptions, Converted, Remesh, convert, convert_owned, convert_with_progress,
};
pub use globe::{EquirectangularGrid, GlobeError, GridMeaning, globe};
pub use symmetry::Axis;
