//! Bozzetto core: wavelet surfaces of any topology.
