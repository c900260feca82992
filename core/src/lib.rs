//! Bozzetto core: wavelet surfaces of any topology.
pub mod hierarchy;
pub mod mesh;
pub mod surface;
pub mod wavelet;
