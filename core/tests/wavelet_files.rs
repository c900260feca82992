//! Wavelet files: what is saved is what is loaded, to the bit; a cut file is a partial model that says so; chunks of
//! later versions survive or are refused. Damage is the business of damaged_files.rs.

mod raw_chunks;
mod samples;
mod small_files;

use bozzetto_core::file::{Model, encode};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::mesh::shapes;
use bozzetto_core::wavelet::Wavelet;
use raw_chunks::{PREAMBLE, RawChunk, join, split};
use samples::{contents, model, on_threads};
use small_files::{assert_message, read, small_files};

fn assert_same(a: &Model, b: &Model, what: &str) {
    assert!(contents(&a.surface) == contents(&b.surface), "{what}: coefficients");
    assert_eq!(a.surface.hash(), b.surface.hash(), "{what}");
    assert_eq!(a.surface.form(), b.surface.form(), "{what}");
    assert_eq!(a.surface.hierarchy().base(), b.surface.hierarchy().base(), "{what}");
    assert_eq!((&a.source, &a.metadata, &a.unknown), (&b.source, &b.metadata, &b.unknown), "{what}");
    assert_eq!((a.complete, a.stated_hash), (b.complete, b.stated_hash), "{what}");
}

#[test]
fn what_is_saved_is_what_is_loaded() {
    for (name, mesh) in shapes::awkward() {
        for wavelet in Wavelet::ALL {
            for (sharp, finest) in [(0, 3), (2, 2), (1, 0)] {
                let what = format!("{name}, {wavelet}, {sharp} sharp, J = {finest}");
                let saved = model(&mesh, wavelet, sharp, finest, 17);
                let bytes = encode(&saved);
                assert!(bytes == encode(&saved), "{what}: encoded twice");
                let loaded = read(&bytes).unwrap_or_else(|e| panic!("{what}: {e}"));
                assert_same(&saved, &loaded, &what);
                assert!(loaded.complete && !loaded.tail_cut, "{what}");
                assert!(encode(&loaded) == bytes, "{what}: rewritten");
                // The tests' own notion of chunks is the format's.
                assert_eq!(split(&bytes).last().expect("chunks").end, bytes.len(), "{what}");
            }
        }
    }
}

/// A level of more than one block, cut between its blocks, and the same bytes whatever the threads.
#[test]
fn blocks_and_threads() {
    let large = model(&shapes::octahedron(), Wavelet::Disc(1), 1, 7, 5);
    let bytes = on_threads(1, || encode(&large));
    for threads in [2, 7] {
        assert!(on_threads(threads, || encode(&large)) == bytes, "{threads} threads");
    }
    let whole = contents(&large.surface);
    let chunks = split(&bytes);
    let blocks: Vec<&RawChunk> = chunks.iter().filter(|c| &c.kind == b"WAVE").collect();
    assert_eq!(blocks.len(), 8, "level 6 has two blocks");
    for known in [6, 7] {
        let partial = read(&bytes[..blocks[known - 1].end]).expect("a partial model");
        let finest = partial.surface.wavelets(Level(6));
        let there = (known - 6) << 15;
        assert!(!partial.complete);
        assert!(finest[..there] == whole[8 + 6][..there], "{known} blocks: the known part");
        assert!(finest[there..].iter().all(|d| *d == [0; 3]), "{known} blocks: the rest is zero");
        assert!(partial.surface.wavelets(Level(5)) == whole[8 + 5], "{known} blocks: the level before");
    }
    assert!(contents(&read(&bytes).expect("whole").surface) == whole);
}

#[test]
fn every_prefix_is_a_model_or_an_error() {
    for (name, whole, bytes) in small_files() {
        let chunks = split(bytes);
        let end_of = |kind: &[u8; 4]| chunks.iter().find(|c| &c.kind == kind).map(|c| c.end);
        let (model_from, whole_from) = (end_of(b"SCAL").expect("SCAL"), end_of(b"END!").expect("END!"));
        let of_whole = contents(&whole.surface);
        let levels = usize::from(whole.surface.finest().0);
        for length in 0..=bytes.len() {
            let what = format!("{name}, the first {length} of {} bytes", bytes.len());
            let read = match read(&bytes[..length]) {
                Ok(read) => read,
                Err(error) => {
                    assert!(length < model_from, "{what}: {error}");
                    assert_message(&error, &what);
                    let wanted =
                        if length < PREAMBLE { "not a Bozzetto" } else { "ends before its base mesh" };
                    assert!(error.to_string().contains(wanted), "{what}: {error}");
                    continue;
                }
            };
            assert!(length >= model_from, "{what}: a model");
            assert_eq!(read.complete, length >= whole_from, "{what}");
            assert_eq!(read.stated_hash, whole.stated_hash, "{what}");
            let known = chunks.iter().filter(|c| &c.kind == b"WAVE" && c.end <= length).count();
            let found = contents(&read.surface);
            assert!(found[..=known] == of_whole[..=known], "{what}: levels whose detail is known");
            let (details, of_whole) = (&found[levels + 1..], &of_whole[levels + 1..]);
            assert!(details[..known] == of_whole[..known], "{what}: known detail");
            assert!(details[known..].iter().flatten().all(|d| *d == [0; 3]), "{what}: missing detail");
            if read.complete {
                let at_border = chunks.iter().any(|c| c.end == length);
                assert_eq!(read.tail_cut, !at_border, "{what}");
                let has = |kind| end_of(kind).is_some_and(|end| end <= length);
                assert_eq!(read.source.is_some(), has(b"SRCE"), "{what}");
                assert_eq!(read.metadata == whole.metadata, has(b"META"), "{what}");
            }
        }
    }
}

#[test]
fn unknown_chunks_survive_or_are_refused() {
    let (_, whole, bytes) = &small_files()[0];
    let chunks = split(bytes);
    for at in 1..=chunks.len() {
        let mut more = chunks.clone();
        more.insert(at, RawChunk::new(b"NEWS", false, b"from a later version"));
        let file = join(&more, at % 2 == 0);
        let read_once = read(&file).unwrap_or_else(|e| panic!("ancillary at {at}: {e}"));
        assert!(read_once.complete && contents(&read_once.surface) == contents(&whole.surface));
        assert_eq!((&read_once.source, &read_once.metadata), (&whole.source, &whole.metadata));
        let rewritten = split(&encode(&read_once));
        let kept = rewritten.iter().find(|c| &c.kind == b"NEWS").expect("it survives a rewrite");
        assert_eq!((kept.raw.as_slice(), kept.critical), (b"from a later version".as_slice(), false));

        more[at].critical = true;
        let error = read(&join(&more, false)).expect_err("an unknown critical chunk");
        assert_message(&error, "critical");
        assert!(error.to_string().contains("NEWS is not known"), "{error}");
    }
}
