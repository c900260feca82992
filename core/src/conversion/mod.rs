//! Any mesh or picture to a hierarchy with positions.

mod convert;
mod globe;

pub use convert::{ConversionError, ConversionOptions, Converted, Remesh, convert};
pub use globe::{EquirectangularGrid, GlobeError, GridMeaning, globe};
