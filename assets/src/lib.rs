//! What the programs that make Bozzetto's sample models share; the programs themselves are in `src/bin`.
//!
//! Two models, two families of modules:
//! - the globe: [`netcdf`] reads the elevations, [`elevation`] reduces them to a small image.
pub mod elevation;
pub mod netcdf;
