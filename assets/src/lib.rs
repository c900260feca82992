//! What the programs that make Bozzetto's sample models share; the programs themselves are in `src/bin`.
//!
//! Two models, two families of modules:
//! - the globe: [`netcdf`] reads the elevations, [`elevation`] reduces them to a small image;
//! - the head: [`faun`] is its shape as a [`distance_field`], [`base_mesh`] its base mesh; [`sculpt`] leads the one onto
//!   the other level by level with [`relax`], [`carving`] cuts the fine detail, and [`decimate`] makes a scan of it.

pub mod base_mesh;
pub mod carving;
pub mod decimate;
pub mod distance_field;
pub mod elevation;
pub mod faun;
pub mod netcdf;
pub mod relax;
pub mod sculpt;
pub mod skin;
pub mod vector;
