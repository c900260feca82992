//! What the programs that make Bozzetto's sample models share; the programs themselves are in `src/bin`.
//!
//! Two models, two families of modules:
//! - the globe: [`netcdf`] reads the elevations, [`elevation`] reduces them to a small image;
//! - the head: a subdivided icosahedron is [`wrap`]ped onto the [`faun`]'s [`distance_field`].

pub mod distance_field;
pub mod elevation;
pub mod faun;
pub mod netcdf;
pub mod vector;
pub mod wrap;
