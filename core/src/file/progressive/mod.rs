//! The embedded stream of a wavelet file: base connectivity, positions and wavelet coefficients in the order of their
//! significance, each bit under a model learnt from what came before. docs/FORMAT.md specifies every bit of it.

mod butterfly;
mod connectivity;
mod finish;
mod frames;
mod lanes;
mod planes;
mod range_coder;
mod straightened;
mod stream;
mod transform;
mod visit;

pub(super) use connectivity::{decode_base, encode_base};
pub(super) use straightened::Straightened;
pub(super) use stream::{Border, Decoded, Encoded, Granularity, Held, Telling, decode_stream, encode_stream};
pub(super) use transform::Coding;
