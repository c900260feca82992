//! Any mesh or picture to a hierarchy with positions.

pub mod clean;
mod collapse;
mod convert;
mod edge_flips;
mod fit;
mod flatten;
mod globe;
mod normal_equations;
mod parameterise;
mod pulls;
mod quadric;
mod relax;
pub mod remesh;
mod resample;
mod simplify;
mod walk;
mod working_mesh;

pub use convert::{ConversionError, ConversionOptions, Converted, Remesh, convert, convert_with_progress};
pub use globe::{EquirectangularGrid, GlobeError, GridMeaning, globe};
