//! Damaged and forged wavelet files: an error that names the place, or a part that says it is one; never a panic, never
//! another surface, never memory for what is only promised.

mod raw_chunks;
mod samples;
mod small_files;

use proptest::prelude::*;
use raw_chunks::{RawChunk, join, split};
use samples::contents;
use small_files::{assert_message, read, small_files};

#[test]
fn every_damaged_byte_is_noticed() {
    for (name, _, bytes) in small_files() {
        let mut damaged = bytes.clone();
        for at in 0..bytes.len() {
            for flip in [0x01, 0x20, 0x80, 0xff] {
                damaged[at] ^= flip;
                match read(&damaged) {
                    Err(error) => assert_message(&error, name),
                    Ok(read) => {
                        panic!("{name}: byte {at} flipped by {flip:#x} (complete: {})", read.complete)
                    }
                }
                damaged[at] = bytes[at];
            }
        }
    }
}

fn peak_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|line| line.starts_with("VmPeak:")).unwrap_or("0");
    line.split_whitespace().find_map(|word| word.parse().ok()).unwrap_or(0)
}

/// Headers with every checksum in order that promise what the file does not hold.
#[test]
fn promises_are_not_believed() {
    let (_, _, bytes) = &small_files()[1];
    let chunks = split(bytes);
    // Counts stand before the hash at the header's end.
    let (vertices, faces) = (chunks[0].raw.len() - 24, chunks[0].raw.len() - 20);
    let put = |at: usize, value: u32| {
        move |chunks: &mut Vec<RawChunk>| {
            chunks[0].raw[at..at + 4].copy_from_slice(&value.to_le_bytes());
        }
    };
    let state = |at: usize, length: u64| move |chunks: &mut Vec<RawChunk>| chunks[at].stated = Some(length);
    let level = |level: u8| move |chunks: &mut Vec<RawChunk>| chunks[0].raw[2] = level;
    type Forgery<'a> = (&'a str, Box<dyn Fn(&mut Vec<RawChunk>)>);
    fn of<'a>(chunks: &'a mut [RawChunk], kind: &[u8; 4]) -> &'a mut RawChunk {
        chunks.iter_mut().find(|c| &c.kind == kind).expect("every kind is there")
    }
    let place = |kind: &[u8; 4]| chunks.iter().position(|c| &c.kind == kind).expect("every kind is there");
    let (wave, end) = (place(b"WAVE"), place(b"END!"));
    let mut forgeries: Vec<Forgery> = vec![
        ("level 15", Box::new(level(15))),
        ("level 12", Box::new(level(12))),
        ("level 13", Box::new(level(13))),
        ("level 255", Box::new(level(255))),
        ("a level less", Box::new(level(1))),
        ("precision 99", Box::new(|c| c[0].raw[3] = 99)),
        ("255 channels", Box::new(|c| c[0].raw[5] = 255)),
        ("a base mesh of ones", Box::new(|c| c[1].raw.fill(0xff))),
        ("a base mesh of zeros", Box::new(|c| c[1].raw.fill(0))),
        ("half a base mesh", Box::new(|c| c[1].raw.truncate(2))),
        ("no base mesh", Box::new(|c| c[1].raw.clear())),
        ("coefficients of ones", Box::new(|c| of(c, b"WAVE").raw[2..].fill(0xff))),
        ("coefficients of zeros", Box::new(|c| of(c, b"WAVE").raw[2..].fill(0))),
        ("another surface", Box::new(|c| of(c, b"WAVE").raw[99] ^= 1)),
        ("another surface's hash", Box::new(|c| *c[0].raw.last_mut().expect("a hash") ^= 1)),
        ("coefficients without an error", Box::new(|c| of(c, b"WAVE").raw.truncate(1))),
        ("an error that is no number", Box::new(|c| of(c, b"WAVE").raw[..2].copy_from_slice(&[0xc0, 0x7f]))),
        ("an error below nothing", Box::new(|c| of(c, b"WAVE").raw[..2].copy_from_slice(&[0, 0xc0]))),
        ("an end that is not empty", Box::new(|c| of(c, b"END!").raw.push(0))),
        ("too many sources", Box::new(|c| of(c, b"SRCE").raw.extend([0; 4]))),
        ("metadata that is none", Box::new(|c| of(c, b"META").raw = b"{\"source\":[".to_vec())),
        ("no coefficients", Box::new(|c| c.retain(|c| &c.kind != b"WAVE"))),
        (
            "a long base mesh",
            Box::new(move |c| {
                put(faces, 1 << 27)(c);
                c[1].stated = Some(1 << 32);
            }),
        ),
        ("a part twice", Box::new(move |c| c.insert(wave, c[wave].clone()))),
        ("the end twice", Box::new(move |c| c.insert(end, c[end].clone()))),
        ("an end before its time", Box::new(move |c| drop(c.remove(end - 1)))),
        (
            "a step of zero",
            Box::new(|c| {
                let at = c[0].raw.len() - 32;
                c[0].raw[at..at + 8].fill(0);
            }),
        ),
    ];
    for value in [0, 7, 1 << 26, 1 << 31, u32::MAX] {
        forgeries.push(("vertices", Box::new(put(vertices, value))));
        forgeries.push(("faces", Box::new(put(faces, value))));
        forgeries.push((
            "both",
            Box::new(move |c| {
                put(vertices, value)(c);
                put(faces, value)(c);
            }),
        ));
    }
    for at in 0..chunks.len() {
        // Ancillary chunks may be packed, and these say nothing else than they do now.
        for length in [0, 1, 1 << 33, 1 << 40, u64::MAX >> 2, u64::MAX] {
            forgeries.push(("a stated length", Box::new(state(at, length))));
        }
    }
    let before = peak_memory();
    for (name, forge) in &forgeries {
        for pack in [false, true] {
            let mut forged = chunks.clone();
            forge(&mut forged);
            // A length in an unknown ancillary chunk is nobody's business; all of these are known.
            let error = read(&join(&forged, pack)).err().unwrap_or_else(|| panic!("{name}: read"));
            assert_message(&error, name);
        }
    }
    let grown = peak_memory() - before;
    assert!(grown < 1 << 20, "{grown} KiB more were asked for");
}

/// A change to the bytes of a file, by proportions.
#[derive(Debug, Clone)]
enum Damage {
    Replace(f64, u8),
    Insert(f64, Vec<u8>),
    Remove(f64, usize),
    Repeat(f64, usize),
}

fn damage() -> impl Strategy<Value = Damage> {
    let bytes = prop::collection::vec(any::<u8>(), 1..9);
    prop_oneof![
        (0.0..1.0, any::<u8>()).prop_map(|(at, to)| Damage::Replace(at, to)),
        (0.0..1.0, bytes).prop_map(|(at, bytes)| Damage::Insert(at, bytes)),
        (0.0..1.0, 1usize..40).prop_map(|(at, count)| Damage::Remove(at, count)),
        (0.0..1.0, 1usize..40).prop_map(|(at, count)| Damage::Repeat(at, count)),
    ]
}

fn apply(damage: &Damage, bytes: &mut Vec<u8>) {
    if bytes.is_empty() {
        return;
    }
    let length = bytes.len();
    let place = |at: f64| (at * length as f64) as usize;
    match damage {
        Damage::Replace(at, to) => bytes[place(*at)] = *to,
        Damage::Insert(at, more) => drop(bytes.splice(place(*at)..place(*at), more.iter().copied())),
        Damage::Remove(at, count) => {
            let from = place(*at);
            bytes.drain(from..bytes.len().min(from + count));
        }
        Damage::Repeat(at, count) => {
            let from = place(*at);
            let again = bytes[from..bytes.len().min(from + count)].to_vec();
            bytes.splice(from..from, again);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

    /// Whatever happens to the bytes: an error, or the same surface, or a part of it that says so.
    #[test]
    fn damaged_files_never_pass_for_whole(damages in prop::collection::vec(damage(), 1..4), which in 0usize..4) {
        let (_, whole, bytes) = &small_files()[which];
        let mut damaged = bytes.clone();
        damages.iter().for_each(|damage| apply(damage, &mut damaged));
        match read(&damaged) {
            Err(error) => assert_message(&error, "damaged"),
            Ok(found) if found.complete => {
                prop_assert!(contents(&found.surface) == contents(&whole.surface));
            }
            Ok(found) => {
                // A sound part, and nothing of what comes after it.
                let parts = split(bytes).into_iter().filter(|c| &c.kind == b"WAVE").map(|c| c.end);
                let found = contents(&found.surface);
                prop_assert!(parts.into_iter().any(|end| contents(&read(&bytes[..end]).expect("a part").surface) == found));
            }
        }
    }

    /// The same under checksums that are all in order: what is read as whole has the hash it states.
    #[test]
    fn forged_files_never_panic(
        damages in prop::collection::vec((0usize..9, damage()), 1..4), which in 0usize..4, pack: bool,
    ) {
        let (_, _, bytes) = &small_files()[which];
        let mut chunks = split(bytes);
        for (at, damage) in &damages {
            let at = at % chunks.len();
            apply(damage, &mut chunks[at].raw);
        }
        match read(&join(&chunks, pack)) {
            Err(error) => assert_message(&error, "forged"),
            Ok(found) => prop_assert!(!found.complete || found.surface.hash() == found.stated_hash),
        }
    }
}
