//! Every version of every operation goes on doing what it did when it landed, to the bit.

use bozzetto_core::disk::Disk;
use bozzetto_core::edit::{Entry, Line};
use bozzetto_core::file::decode;
use bozzetto_core::session::Session;
use std::path::Path;
use std::sync::Arc;

/// Written once, and only added to: on each line the hash of the surface after it, then the line of a script.
const SCRIPT: &str = include_str!("golden_script.txt");

#[test]
fn operations_give_the_same_bits_for_ever() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden_files/v3-ball.boz");
    let model = decode(&std::fs::read(&path).expect("a golden file"), &path).expect("it is sound");
    let mut session = Session::new(Arc::new(Disk), model);
    let mut hash = session.hash().to_string();
    for line in SCRIPT.lines() {
        let (expected, text) = line.split_once(' ').expect("a hash and a line");
        let Entry::Edit(edit) = Line::parse(text).expect("a line of a script").entry else {
            panic!("{text}")
        };
        let masks = text.contains("\"mask\",");
        session.edit(edit).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(session.hash().to_string(), expected, "{text}");
        assert!(masks || expected != hash, "nothing has changed: {text}");
        hash = expected.to_owned();
    }
}
