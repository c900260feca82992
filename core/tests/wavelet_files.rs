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

/// The same bytes whatever the threads; and every part is nearer to the whole than the part before it.
#[test]
fn parts_and_threads() {
    let mut large = model(&shapes::octahedron(), Wavelet::Disc(1), 1, 6, 5);
    large.source = None;
    let bytes = on_threads(1, || encode(&large));
    for threads in [2, 7] {
        assert!(on_threads(threads, || encode(&large)) == bytes, "{threads} threads");
    }
    let whole = contents(&large.surface);
    let finest = large.surface.scaling(Level(6));
    let parts: Vec<RawChunk> = split(&bytes).into_iter().filter(|c| &c.kind == b"WAVE").collect();
    assert!(parts.len() > 10, "{} parts", parts.len());
    let mut before = f64::INFINITY;
    for (at, part) in parts.iter().enumerate() {
        let partial = read(&bytes[..part.end]).expect("a partial model");
        assert!(!partial.complete);
        assert_eq!(partial.curve.len(), at + 1);
        assert_eq!(partial.curve[at].bytes, part.end);
        let off =
            |(a, b): (&[i32; 3], &[i32; 3])| (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>();
        let error = partial.surface.scaling(Level(6)).iter().zip(finest).map(off).sum::<f64>().sqrt();
        assert!(error <= 1.05 * before, "part {at}: {error} after {before}");
        before = error;
    }
    assert!(before == 0.0, "{before}");
    assert!(contents(&read(&bytes).expect("whole").surface) == whole);
}

/// Reading for speed changes the order of the stream, not what it holds.
#[test]
fn a_surface_of_many_vertices() {
    let large = model(&shapes::torus(4, 3), Wavelet::Disc(2), 0, 7, 6);
    assert!(large.surface.scaling(Level(7)).len() > 1 << 17);
    assert!(contents(&read(&encode(&large)).expect("sound").surface) == contents(&large.surface));
}

#[test]
fn every_prefix_is_a_model_or_an_error() {
    for (name, whole, bytes) in small_files() {
        let chunks = split(bytes);
        let end_of = |kind: &[u8; 4]| chunks.iter().find(|c| &c.kind == kind).map(|c| c.end);
        let (model_from, whole_from) = (end_of(b"WAVE").expect("WAVE"), end_of(b"END!").expect("END!"));
        let of_whole = contents(&whole.surface);
        let mut of_part = Vec::new();
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
            let found = contents(&read.surface);
            if chunks.iter().any(|c| &c.kind == b"WAVE" && c.end == length) {
                of_part = found;
            } else if length < whole_from {
                assert!(found == of_part, "{what}: what the whole chunks hold");
            } else {
                assert!(found == of_whole, "{what}: the whole");
            }
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
