//! Any mesh or picture to a surface.

mod globe;
mod import;

pub use globe::{EquirectangularGrid, GlobeError, GridMeaning, globe};
pub use import::{ImportError, ImportOptions, Imported, Remesh, import, surface_from_positions};
