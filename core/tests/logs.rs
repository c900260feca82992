//! Logs: whatever happens to one, its good lines count and a bad one is named; what is left out is kept beside it.

mod memory_disk;
mod samples;

use bozzetto_core::disk::{Disk, Vfs};
use bozzetto_core::edit::{Edit, Entry, Gain, Line};
use bozzetto_core::file::{FileError, NumberedLine, encode, read_log};
use bozzetto_core::mesh::shapes;
use bozzetto_core::session::{
    LogUse, OpenOptions, Opened, ReplayReason, Session, SessionError, effective, open_model,
};
use bozzetto_core::surface::SurfaceHash;
use bozzetto_core::wavelet::Wavelet;
use memory_disk::MemoryDisk;
use samples::{Numbers, draw_edit, model};
use std::path::Path;
use std::sync::Arc;

const FILE: &str = "work/bust.boz";
const LOG: &str = "work/bust.edits";

const WHOLE: OpenOptions = OpenOptions { log: LogUse::Whole, rebind: false };

fn open(disk: &MemoryDisk, options: OpenOptions) -> Result<Opened, SessionError> {
    Session::open(Arc::new(disk.clone()), Path::new(FILE), options, &|_| true)
}

fn hash_of(disk: &MemoryDisk, options: OpenOptions) -> SurfaceHash {
    let (model, _) = open_model(disk, Path::new(FILE), options).expect("a sound file and log");
    model.surface.hash()
}

/// A file with a log of `edits` edits and the hash after each number of log lines; a save mark follows edit 3.
fn recorded(edits: usize) -> (MemoryDisk, Vec<SurfaceHash>) {
    let disk = MemoryDisk::default();
    disk.put(FILE, &encode(&model(&shapes::octahedron(), Wavelet::Disc(1), 1, 2, 8)));
    let mut session = open(&disk, WHOLE).expect("a sound file").session;
    let mut numbers = Numbers(8);
    let mut hashes = vec![session.hash()];
    for at in 0..edits {
        let edit = draw_edit(&mut numbers, session.surface());
        session.edit(edit).expect("a modest edit");
        hashes.push(session.hash());
        if at == 2 {
            session.save().expect("the disk is sound");
            hashes.push(session.hash());
        }
    }
    session.close().expect("the disk is sound");
    (disk, hashes)
}

/// Whatever stands in a log is replayed or named with its line; nothing is passed over.
#[test]
fn lines_that_cannot_be_replayed_are_named() {
    let (disk, _) = recorded(4);
    let good = disk.bytes(LOG);
    let newer = Edit::Gain(Gain { level: 0, factor: 1.0, v: 2 });
    for (entry, hash, wanted) in [
        (Entry::Edit(newer), None, "version 2 of this operation is not known"),
        (Entry::Undo(5), None, "undoes 5 steps, but there are only 4"),
        (Entry::Redo(1), None, "redoes a step, but there are only 0"),
        (Entry::Undo(1), Some(SurfaceHash([7; 16])), "not 07070707070707070707070707070707 as recorded"),
    ] {
        let line = Line::to_text(&entry, hash) + "\n";
        disk.put(LOG, &[good.as_slice(), line.as_bytes()].concat());
        for error in [open_model(&disk, Path::new(FILE), WHOLE).err(), open(&disk, WHOLE).err()] {
            let text = error.expect(wanted).to_string();
            assert!(text.starts_with("work/bust.edits, line 7: ") && text.contains(wanted), "{text}");
        }
        assert_eq!(disk.bytes(LOG).len(), good.len() + line.len(), "the log is as it was");
    }
    // A script: the line's number counts blank lines and comments, and what came before stands.
    let script = "# a comment\n\n{\"edit\":\"gain\",\"level\":0,\"factor\":0.5}\n{\"undo\":9}\n";
    let log = read_log(script.as_bytes(), false);
    disk.put(LOG, &good);
    let mut session = open(&disk, WHOLE).expect("a sound log").session;
    let error = session.play(&log.lines, &|_| true).expect_err("nine steps");
    assert_eq!((error.line, error.reason), (4, ReplayReason::NothingToUndo { wanted: 9, there: 5 }));
    assert_eq!(session.steps(), 5);
}

#[test]
fn a_log_cut_anywhere_keeps_its_whole_lines() {
    let (disk, hashes) = recorded(5);
    let log = disk.bytes(LOG);
    for length in 0..=log.len() {
        let cut = disk.after_power_cut(1.0);
        cut.put(LOG, &log[..length]);
        let whole_lines = log[..length].iter().filter(|b| **b == b'\n').count();
        let torn = length > 0 && log[length - 1] != b'\n';
        let expected = hashes[whole_lines.saturating_sub(1)];
        let (model, notes) = open_model(&cut, Path::new(FILE), WHOLE).expect("a torn line is no error");
        assert_eq!(model.surface.hash(), expected, "{length} bytes");
        let Opened { session, notes: of_session } = open(&cut, WHOLE).expect("a torn line is no error");
        assert_eq!(session.hash(), expected, "{length} bytes");
        for notes in [notes, of_session] {
            assert_eq!(notes.len(), usize::from(torn), "{length} bytes: {notes:?}");
            assert!(notes.iter().all(|note| note.starts_with("work/bust.edits: ")), "{notes:?}");
        }
        // The session goes on after the good part, and what it adds is found again.
        let mut session = session;
        session.edit(Edit::Gain(Gain { level: 1, factor: 0.25, v: 1 })).expect("a modest edit");
        let after = session.hash();
        session.close().expect("a sound disk");
        assert_eq!(hash_of(&cut, WHOLE), after, "{length} bytes");
        assert_eq!(cut.names().len(), 3, "no copy: {:?}", cut.names());
    }
}

#[test]
fn a_bad_line_before_good_ones_is_damage() {
    let (disk, hashes) = recorded(5);
    let log = disk.bytes(LOG);
    let lines = log.iter().filter(|b| **b == b'\n').count();
    let starts: Vec<usize> =
        std::iter::once(0).chain((0..log.len()).filter(|&at| log[at] == b'\n').map(|at| at + 1)).collect();
    for bad in 0..lines - 1 {
        let damaged = disk.after_power_cut(1.0);
        let mut bytes = log.clone();
        bytes[starts[bad] + 5] ^= 0x11;
        damaged.put(LOG, &bytes);
        let text = open_model(&damaged, Path::new(FILE), WHOLE).expect_err("damage").to_string();
        assert!(text.starts_with(&format!("work/bust.edits, line {}: ", bad + 1)), "{text}");
        assert!(text.contains("--base"), "{text}");
        let base = OpenOptions { log: LogUse::Ignored, rebind: false };
        assert_eq!(hash_of(&damaged, base), hashes[0]);

        for again in 0..2 {
            let Opened { session, notes } = open(&damaged, WHOLE).expect("it goes on from the good part");
            assert_eq!(session.hash(), hashes[bad.saturating_sub(1)], "line {} is bad", bad + 1);
            if again == 0 {
                assert_eq!(notes.len(), 1, "{notes:?}");
                assert!(notes[0].starts_with(&format!("work/bust.edits, line {}: ", bad + 1)), "{notes:?}");
                assert!(notes[0].ends_with("all of it is in work/bust.edits.kept"), "{notes:?}");
                assert!(damaged.bytes("work/bust.edits.kept") == bytes, "the copy is the damaged log");
            } else {
                assert_eq!(notes, Vec::<String>::new(), "mended the second time");
            }
        }
        // A second damage takes a name of its own.
        damaged.put(LOG, &bytes);
        open(&damaged, WHOLE).expect("it goes on from the good part");
        assert!(damaged.bytes("work/bust.edits.kept-2") == bytes);
    }
}

#[test]
fn a_journal_needs_its_binding_and_checksums() {
    let (disk, _) = recorded(3);
    let log = String::from_utf8(disk.bytes(LOG)).expect("text");
    let (binding, rest) = log.split_once('\n').expect("two lines");
    let of = |text: &str| read_log(text.as_bytes(), true).damage.expect("damage");
    assert_eq!(of(rest), (1, "the log does not begin with the file it belongs to".into()));
    assert_eq!(of(&format!("{binding}\n{binding}\n{rest}")), (2, "a log begins only once".into()));
    assert_eq!(of(&format!("{binding}\n{{\"undo\":1}}\n{rest}")), (2, "it has no checksum".into()));
    // A script needs neither, but what it has must be right.
    let script = read_log(b"# mine\n{\"log\":1,\"of\":\"x\"}\n{\"undo\":1}", false);
    assert_eq!((script.of.as_deref(), script.lines.len(), &script.damage), (Some("x"), 1, &None));
    assert_eq!(read_log(b"{\"undo\":1,\"crc\":\"00000000\"}", false).damage.expect("damage").0, 1);
    assert_eq!(read_log(&[0xff, 0xfe, b'\n'], false).damage.expect("damage"), (1, "it is not text".into()));
}

#[test]
fn discards_and_save_marks() {
    let numbered = |entries: &[Entry]| -> Vec<NumberedLine> {
        let line = |entry: &Entry| Line { entry: entry.clone(), hash: None, checked: true };
        entries.iter().zip(2..).map(|(entry, number)| NumberedLine { number, line: line(entry) }).collect()
    };
    let edit = |factor| Entry::Edit(Edit::Gain(Gain { level: 0, factor, v: 1 }));
    let log = numbered(&[
        edit(1.0),
        Entry::Discard,
        edit(2.0),
        Entry::Save,
        edit(3.0),
        Entry::Undo(2),
        Entry::Discard,
        edit(4.0),
        Entry::Discard,
        Entry::Discard,
        edit(5.0),
    ]);
    let entries = |saved| effective(&log, saved).into_iter().map(|l| l.line.entry).collect::<Vec<_>>();
    assert_eq!(entries(false), [edit(2.0), Entry::Save, edit(5.0)]);
    assert_eq!(entries(true), [edit(2.0), Entry::Save]);
    assert_eq!(effective(&log, false)[2].number, 12, "lines keep their numbers");
    assert_eq!(effective(&log[..1], true), []);

    // The same through a file: edits 1 to 3, a mark, edits 4 to 6.
    let (disk, hashes) = recorded(6);
    let with = |log| OpenOptions { log, rebind: false };
    assert_eq!(hash_of(&disk, with(LogUse::Whole)), hashes[7]);
    assert_eq!(hash_of(&disk, with(LogUse::Saved)), hashes[4]);
    assert_eq!(hash_of(&disk, with(LogUse::Ignored)), hashes[0]);
    let log = disk.bytes(LOG);
    open(&disk, WHOLE).expect("sound").session.discard().expect("sound");
    assert!(disk.bytes(LOG).starts_with(&log), "nothing is erased");
    assert_eq!(hash_of(&disk, WHOLE), hashes[4]);
    let session = open(&disk, WHOLE).expect("sound").session;
    assert_eq!((session.is_unsaved(), session.history_len()), (false, 3));
    drop(session);
    // Opened for editing without its latest part, the log goes on from there and the rest is kept beside it.
    disk.put(LOG, &log);
    let Opened { session, notes } = open(&disk, with(LogUse::Saved)).expect("sound");
    assert_eq!((session.hash(), session.is_unsaved(), notes.len()), (hashes[4], false, 1));
    session.close().expect("sound");
    assert!(disk.bytes("work/bust.edits.kept") == log);
    assert_eq!(hash_of(&disk, WHOLE), hashes[4]);
}

#[test]
fn a_log_of_another_file_is_refused() {
    let (disk, hashes) = recorded(2);
    let log = disk.bytes(LOG);
    let other = model(&shapes::octahedron(), Wavelet::Disc(1), 1, 2, 9);
    disk.put(FILE, &encode(&other));
    for error in [open_model(&disk, Path::new(FILE), WHOLE).err(), open(&disk, WHOLE).err()] {
        let error = error.expect("another file's log");
        let names = [hashes[0], other.surface.hash()].map(|hash| hash.to_string());
        assert!(matches!(&error, SessionError::File(FileError::ForeignLog { .. })), "{error}");
        assert!(names.iter().all(|name| error.to_string().contains(name)), "{error}");
    }
    assert!(disk.bytes(LOG) == log, "untouched");
    // Taken on purpose, it is this file's log from then on, and the old one is kept.
    let rebind = OpenOptions { log: LogUse::Whole, rebind: true };
    let (read, notes) = open_model(&disk, Path::new(FILE), rebind).expect("rebound");
    let Opened { session, notes: of_session } = open(&disk, rebind).expect("rebound");
    assert_eq!((session.hash(), session.history_len()), (read.surface.hash(), 2));
    assert_eq!((notes.len(), of_session.len()), (1, 2), "{notes:?} {of_session:?}");
    session.close().expect("sound");
    assert_eq!(hash_of(&disk, WHOLE), read.surface.hash());
    assert!(disk.bytes("work/bust.edits.kept") == log);
}

/// A log recorded elsewhere carries that surface's hashes; rebound, they no longer count.
#[test]
fn rebinding_passes_over_recorded_hashes() {
    let (disk, _) = recorded(40);
    disk.put(FILE, &encode(&model(&shapes::octahedron(), Wavelet::Disc(1), 1, 2, 9)));
    let rebind = OpenOptions { log: LogUse::Whole, rebind: true };
    let rebound = open(&disk, rebind).expect("rebound").session.hash();
    assert_eq!(hash_of(&disk, WHOLE), rebound);
}

#[test]
fn one_session_a_file() {
    let folder = std::env::temp_dir().join(format!("bozzetto-one-session-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for the test");
    let file = folder.join("bust.boz");
    Disk.replace(&file, &encode(&model(&shapes::octahedron(), Wavelet::Lazy, 0, 1, 8))).expect("a disk");
    let open = || Session::open(Arc::new(Disk), &file, WHOLE, &|_| true);
    let first = open().expect("nobody else").session;
    for _ in 0..2 {
        let error = open().expect_err("the first session has it");
        assert!(matches!(&error, SessionError::File(FileError::Locked { path }) if *path == file), "{error}");
    }
    assert!(open_model(&Disk, &file, WHOLE).is_ok(), "reading needs no lock");
    drop(first);
    open().expect("the first session is gone").session.close().expect("a disk");
    open().expect("so is the second").session.discard().expect("a disk");
    std::fs::remove_dir_all(&folder).expect("the test's own folder");
}
