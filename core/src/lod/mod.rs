//! Less of a surface: the wavelets that matter most, and triangles as large as the detail allows.
//!
//! [`Kept`] drops the smallest coefficients and foretells what that costs; [`adaptive_triangulation`] writes what is left with
//! large triangles where it is flat. Neither changes the surface it is given.

mod adaptive;
mod kept;

pub use adaptive::adaptive_triangulation;
pub use kept::{Kept, domain_distance, keep_largest, regular_norm};
