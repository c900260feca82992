//! Bozzetto core: wavelet surfaces of any topology.
pub mod conversion;
pub mod disk;
pub mod edit;
pub mod file;
pub mod hierarchy;
pub mod io;
pub mod lod;
pub mod memory;
pub mod mesh;
pub mod session;
pub mod surface;
pub mod wavelet;
