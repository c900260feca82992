//! Files: the `.boz` wavelet file and the `.edits` log beside it. docs/FORMAT.md is the specification.

mod chunk;
mod error;
mod header;
mod held;
mod journal;
mod normal_mesh;
mod progressive;
mod smaller;
mod source_indices;
mod wavelet_file;

pub use chunk::Chunk;
pub use error::{FileError, mend_of};
pub use journal::{Journal, Log, NumberedLine, lock, log_path, read_log, write_log};
pub use normal_mesh::{NotNormal, normal_mesh};
pub use smaller::{NoSuchFile, Size, encode_smaller};
pub use source_indices::SourceIndices;
pub use wavelet_file::{CurvePoint, Metadata, Model, decode, encode, is_wavelet_file};
