//! Where large arrays lie.

mod buffer;

pub use buffer::Buffer;
