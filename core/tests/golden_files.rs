//! Files of every version and transform that was ever written go on opening, to the same surface.

use bozzetto_core::file::{decode, encode};
use std::path::Path;

/// Written once; each line names a file, its surface's hash and how many vertices that has.
const FILES: &str = include_str!("golden_files/hashes.txt");

#[test]
fn golden_files_open_for_ever() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden_files");
    let mut count = 0;
    for line in FILES.lines() {
        let [name, hash, vertices] = line.split_whitespace().collect::<Vec<_>>()[..] else {
            panic!("{line}")
        };
        let path = folder.join(name);
        let bytes = std::fs::read(&path).expect("a golden file");
        let model = decode(&bytes, &path).unwrap_or_else(|error| panic!("{error}"));
        let finest = model.surface.scaling(model.surface.finest());
        assert!(model.complete, "{name}");
        assert_eq!(
            (model.surface.hash().to_string().as_str(), finest.len().to_string().as_str()),
            (hash, vertices)
        );
        // Written anew it is a file of this version, with the same surface.
        let again = decode(&encode(&model), &path).expect("what was written");
        assert!(again.surface.hash() == model.surface.hash() && again.source == model.source, "{name}");
        count += 1;
    }
    assert!(count >= 7, "{count} files");
}
