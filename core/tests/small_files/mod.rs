//! A few wavelet files small enough to try everything at every byte.

use super::samples::model;
use bozzetto_core::file::{FileError, Model, decode, encode};
use bozzetto_core::mesh::shapes;
use bozzetto_core::wavelet::Wavelet;
use std::path::Path;
use std::sync::OnceLock;

/// Reads a file by a name that messages must repeat.
pub(crate) fn read(bytes: &[u8]) -> Result<Model, FileError> {
    decode(bytes, Path::new("work/some.boz"))
}

/// One sentence that names the file and the place.
pub(crate) fn assert_message(error: &FileError, what: &str) {
    let text = error.to_string();
    assert!(text.starts_with("work/some.boz, byte "), "{what}: {text}");
    assert!(text.contains(": ") && text.contains("; ") && !text.contains('\n'), "{what}: {text}");
}

/// Their names, what they hold and their bytes.
pub(crate) fn small_files() -> &'static [(&'static str, Model, Vec<u8>)] {
    static FILES: OnceLock<Vec<(&str, Model, Vec<u8>)>> = OnceLock::new();
    FILES.get_or_init(|| {
        let two = shapes::together(&[shapes::triangle(), shapes::tetrahedron()]);
        let mut base_only = model(&shapes::tetrahedron(), Wavelet::Disc(2), 1, 0, 4);
        base_only.source = None;
        [
            ("triangle", model(&shapes::triangle(), Wavelet::Disc(1), 1, 2, 1)),
            ("octahedron", model(&shapes::octahedron(), Wavelet::Lazy, 2, 2, 2)),
            ("two components", model(&two, Wavelet::Disc(0), 0, 2, 3)),
            ("one level", base_only),
        ]
        .map(|(name, model)| {
            let bytes = encode(&model);
            (name, model, bytes)
        })
        .into()
    })
}
