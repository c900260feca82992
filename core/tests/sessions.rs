//! Sessions: whatever is done in one is found again by opening, replaying and undoing, to the bit; what is
//! cancelled leaves no trace.

mod memory_disk;
mod samples;

use bozzetto_core::edit::{Edit, Gain, Kind, Move};
use bozzetto_core::file::{Model, decode, encode, read_log};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::mesh::{TriangleMesh, shapes};
use bozzetto_core::session::{OpenOptions, Session, SessionError, open_model};
use bozzetto_core::surface::{LIMIT, Placement, SurfaceHash};
use bozzetto_core::wavelet::Wavelet;
use memory_disk::MemoryDisk;
use proptest::prelude::*;
use samples::{Numbers, assert_consistent, contents, draw_edit, draw_move, model, on_threads};
use std::path::Path;
use std::sync::Arc;

const FILE: &str = "work/bust.boz";

fn open(disk: &MemoryDisk, file: &str) -> Session {
    Session::open(Arc::new(disk.clone()), Path::new(file), OpenOptions::default(), &|_| true)
        .expect("a sound file and log")
        .session
}

fn read(disk: &MemoryDisk, file: &str) -> Model {
    open_model(disk, Path::new(file), OpenOptions::default()).expect("a sound file and log").0
}

/// A session on a saved file.
fn session(mesh: &TriangleMesh, wavelet: Wavelet, sharp: usize, finest: u8) -> (MemoryDisk, Session) {
    let disk = MemoryDisk::default();
    disk.put(FILE, &encode(&model(mesh, wavelet, sharp, finest, 23)));
    let session = open(&disk, FILE);
    (disk, session)
}

fn octahedron() -> (MemoryDisk, Session) {
    session(&shapes::octahedron(), Wavelet::Disc(2), 1, 3)
}

/// Some steps of a stroke, at last to `last`.
fn wander(session: &mut Session, numbers: &mut Numbers, last: Option<[f64; 3]>) {
    for _ in 0..=numbers.below(4) {
        session.drag_to(std::array::from_fn(|_| 0.6 * numbers.signed())).expect("in range");
    }
    if let Some(last) = last {
        session.drag_to(last).expect("in range");
    }
}

/// Two hundred edits, strokes, undos and redos; the hash of the surface after every step of the final history.
fn long_session(session: &mut Session, seed: u64) -> Vec<SurfaceHash> {
    let mut numbers = Numbers(seed);
    let mut states = vec![session.hash()];
    for _ in 0..200 {
        let before = (contents(session.surface()), session.steps(), session.history_len());
        let mut new_step = false;
        match numbers.below(20) {
            0..=8 => {
                session.edit(draw_edit(&mut numbers, session.surface())).expect("a modest edit");
                new_step = true;
            }
            9..=11 => drop(session.undo()),
            12..=13 => drop(session.redo()),
            14 => drop(session.go_to(numbers.below(session.history_len() as u32 + 1) as usize)),
            15 => session.save().expect("a sound disk"),
            16 => {
                session.begin_stroke(draw_move(&mut numbers, session.surface())).expect("a modest stroke");
                wander(session, &mut numbers, None);
                session.cancel_stroke();
                let after = (contents(session.surface()), session.steps(), session.history_len());
                assert!(before == after, "a cancelled stroke leaves no trace");
            }
            _ => {
                let stroke = draw_move(&mut numbers, session.surface());
                session.begin_stroke(stroke).expect("a modest stroke");
                wander(session, &mut numbers, Some(stroke.delta));
                match numbers.below(2) {
                    0 => drop(session.end_stroke()),
                    _ => session.save().expect("a sound disk"),
                }
                new_step = true;
            }
        }
        if new_step {
            // A new step forgets what was undone; going back and forth forgets nothing.
            states.truncate(before.1 + 1);
            states.push(session.hash());
        }
        assert_eq!(session.history_len(), states.len() - 1);
        assert_eq!(session.hash(), states[session.steps()], "the state is the one of its step");
    }
    states
}

#[test]
fn a_long_session_is_found_again() {
    let cases = [
        (shapes::octahedron(), Wavelet::Disc(2), 1, 3),
        (shapes::together(&[shapes::tetrahedron(), shapes::disc(7)]), Wavelet::Disc(1), 2, 3),
        (shapes::torus(4, 3), Wavelet::Lazy, 0, 2),
        (shapes::triangle(), Wavelet::Disc(0), 0, 5),
        (shapes::bipyramid(12), Wavelet::Disc(2), 0, 0),
    ];
    for (case, (mesh, wavelet, sharp, finest)) in cases.into_iter().enumerate() {
        let (disk, mut live) = session(&mesh, wavelet, sharp, finest);
        let states = long_session(&mut live, case as u64);
        let (end, steps, history) = (contents(live.surface()), live.steps(), live.history_len());
        assert_consistent(live.surface());
        live.close().expect("a sound disk");

        assert!(contents(&read(&disk, FILE).surface) == end, "case {case}: opened to read");
        let mut again = open(&disk, FILE);
        assert!(contents(again.surface()) == end, "case {case}: opened to edit");
        assert_eq!((again.steps(), again.history_len()), (steps, history), "case {case}");
        again.go_to(0);
        assert!(
            contents(again.surface())
                == contents(&decode(&disk.bytes(FILE), Path::new(FILE)).expect("sound").surface),
            "case {case}: undone to the very first state"
        );
        for (at, state) in states.iter().enumerate() {
            again.go_to(at);
            assert_eq!((again.steps(), again.hash()), (at, *state), "case {case}: step {at}");
        }
        again.go_to(steps);
        assert!(contents(again.surface()) == end, "case {case}: back where it was");
        drop(again);

        let log = read_log(&disk.bytes("work/bust.edits"), true);
        for threads in [1, 2, 7] {
            let replayed = on_threads(threads, || {
                let file = decode(&disk.bytes(FILE), Path::new(FILE)).expect("sound");
                let mut fresh = Session::new(Arc::new(MemoryDisk::default()), file);
                fresh.play(&log.lines, &|_| true).expect("a recorded log");
                contents(fresh.surface())
            });
            assert!(replayed == end, "case {case}: replayed on {threads} threads");
        }
    }
}

#[test]
fn a_stroke_is_the_edit_with_its_last_delta() {
    let mut numbers = Numbers(4);
    for (name, mesh) in shapes::awkward() {
        for wavelet in Wavelet::ALL {
            let (_, mut dragged) = session(&mesh, wavelet, 1, 2);
            let (_, mut edited) = session(&mesh, wavelet, 1, 2);
            let start = contents(dragged.surface());
            for _ in 0..4 {
                let stroke = draw_move(&mut numbers, dragged.surface());
                dragged.begin_stroke(stroke).expect("a modest stroke");
                wander(&mut dragged, &mut numbers, Some(stroke.delta));
                dragged.end_stroke();
                edited.edit(Edit::Move(stroke)).expect("a modest edit");
                assert!(contents(dragged.surface()) == contents(edited.surface()), "{name}, {stroke:?}");
                assert_eq!(dragged.hash(), edited.hash(), "{name}, {stroke:?}");
                // What the log says of the stroke makes the same edit.
                let Some(Edit::Move(logged)) = dragged.history().last() else { panic!("{name}") };
                assert_eq!(Move { delta: stroke.delta, ..logged }, stroke, "{name}");
                edited.undo().expect("an edit");
                edited.edit(Edit::Move(logged)).expect("a modest edit");
                assert!(contents(dragged.surface()) == contents(edited.surface()), "{name}, {logged:?}");
            }
            dragged.go_to(0);
            assert!(contents(dragged.surface()) == start, "{name}: strokes undone");
        }
    }
}

/// A stroke may show a coarse level only while the hand moves: what it reports is what changed there, finer levels wait,
/// and its end is that of any stroke.
#[test]
fn a_previewed_stroke_ends_whole_and_cancels_clean() {
    let mut numbers = Numbers(12);
    for (name, mesh) in shapes::awkward() {
        let (_, mut dragged) = session(&mesh, Wavelet::Disc(2), 0, 3);
        let (_, mut edited) = session(&mesh, Wavelet::Disc(2), 0, 3);
        for turn in 0..6u8 {
            let start = contents(dragged.surface());
            let stroke = draw_move(&mut numbers, dragged.surface());
            dragged.begin_stroke(stroke).expect("a modest stroke");
            wander(&mut dragged, &mut numbers, None);
            let reach = Level(turn % 3);
            dragged.preview_stroke(reach);
            wander(&mut dragged, &mut numbers, Some(stroke.delta));
            let finest = dragged.surface().scaling(Level(3));
            let home = stroke.level + u8::from(stroke.kind == Kind::Wavelet);
            if home < 3 && reach < Level(3) {
                assert!(*finest == start[3], "{name}: the finest level waits, {stroke:?}");
            }
            if turn % 2 == 0 {
                dragged.cancel_stroke();
                assert!(contents(dragged.surface()) == start, "{name}: cancelled, {stroke:?}");
                assert_consistent(dragged.surface());
                continue;
            }
            dragged.end_stroke();
            edited.edit(Edit::Move(stroke)).expect("a modest edit");
            assert!(contents(dragged.surface()) == contents(edited.surface()), "{name}, {stroke:?}");
            assert_eq!(dragged.hash(), edited.hash(), "{name}, {stroke:?}");
        }
    }
}

#[test]
fn a_stroke_that_goes_nowhere_leaves_no_line() {
    let (disk, mut session) = octahedron();
    let log = disk.bytes("work/bust.edits");
    let before = contents(session.surface());
    let stroke = draw_move(&mut Numbers(1), session.surface());
    session.begin_stroke(stroke).expect("a modest stroke");
    assert!(session.in_stroke() && session.stroke_delta() == Some([0.0; 3]));
    session.drag_to([0.3, 0.1, 0.0]).expect("in range");
    assert!(contents(session.surface()) != before);
    session.drag_to([0.0; 3]).expect("in range");
    session.end_stroke();
    assert!(contents(session.surface()) == before);
    assert_eq!((session.history_len(), session.is_unsaved(), session.in_stroke()), (0, false, false));
    session.close().expect("a sound disk");
    assert!(disk.bytes("work/bust.edits") == log);
}

#[test]
fn saving_under_other_names() {
    let vfs = MemoryDisk::default();
    let mut session =
        Session::new(Arc::new(vfs.clone()), model(&shapes::octahedron(), Wavelet::Disc(1), 1, 2, 1));
    let original = session.hash();
    assert!(session.is_unsaved() && session.path().is_none());
    assert!(matches!(session.save(), Err(SessionError::NoFile)));
    let mut numbers = Numbers(2);
    for _ in 0..40 {
        session.edit(draw_edit(&mut numbers, session.surface())).expect("a modest edit");
    }
    session.undo();
    let (end, hash) = (contents(session.surface()), session.hash());
    // Without a file: the first name, its extension added.
    session.save_as(Path::new("work/one")).expect("a sound disk");
    assert_eq!((session.path(), session.is_unsaved()), (Some(Path::new("work/one.boz")), false));
    // A baked copy: the same surface, no history, and the session stays where it is.
    session.save_copy(Path::new("work/copy.boz")).expect("a sound disk");
    assert_eq!(session.path(), Some(Path::new("work/one.boz")));
    assert!(!vfs.names().contains(&"work/copy.edits".to_owned()), "{:?}", vfs.names());
    let copy = decode(&vfs.bytes("work/copy.boz"), Path::new("copy")).expect("sound");
    assert!(contents(&copy.surface) == end && copy.surface.hash() == hash && copy.stated_hash == hash);
    assert_eq!((&copy.source, &copy.metadata), (&session.model().source, &session.model().metadata));
    // With a file: another name, the first stays as it was and can be opened again.
    session.save_as(Path::new("work/two.boz")).expect("a sound disk");
    let mut one = open(&vfs, "work/one.boz");
    assert!(!one.is_unsaved() && contents(one.surface()) == end);
    session.edit(draw_edit(&mut numbers, session.surface())).expect("a modest edit");
    let later = session.hash();
    assert!(session.is_unsaved());
    assert_eq!((one.history_len(), one.steps()), (40, 39));
    one.go_to(0);
    assert_eq!(one.hash(), original);
    drop(one);
    // Onto a document that is open, or a baked copy onto one with a log, its own included: refused.
    let held = open(&vfs, "work/one.boz");
    let one_before = vfs.bytes("work/one.edits");
    assert!(session.save_as(Path::new("work/one.boz")).expect_err("open").to_string().contains("is open"));
    for name in ["work/one.boz", "work/two.boz"] {
        let error = session.save_copy(Path::new(name)).expect_err("a log is there").to_string();
        assert!(error.contains("this log belongs to the file that would be replaced"), "{error}");
    }
    assert!(vfs.bytes("work/one.edits") == one_before && session.hash() == later);
    drop(held);
    // A baked copy that ends the session, one without a file too, with a stroke that is under way.
    let mut last = open(&vfs, "work/one.boz");
    last.begin_stroke(draw_move(&mut numbers, last.surface())).expect("a modest edit");
    last.drag_to([0.01, 0.0, 0.0]).expect("a modest edit");
    let finest = last.surface().finest();
    let dragged = last.surface().scaling(finest).to_vec();
    last.into_copy(Path::new("work/last.boz")).expect("a sound disk");
    let copy = decode(&vfs.bytes("work/last.boz"), Path::new("last")).expect("sound");
    assert!(copy.surface.scaling(finest) == dragged && copy.stated_hash == copy.surface.hash());
    // Onto one that is closed: replaced with its log.
    session.save_as(Path::new("work/one.boz")).expect("closed");
    session.close().expect("a sound disk");
    for name in ["work/one.boz", "work/two.boz"] {
        assert_eq!(read(&vfs, name).surface.hash(), later, "{name}");
        assert_eq!(open(&vfs, name).history_len(), 40, "{name}: one step undone, one made anew");
    }
}

#[test]
fn what_counts_as_unsaved() {
    let (disk, mut session) = octahedron();
    let edit = Edit::Gain(Gain { level: 0, factor: 0.5, v: 1 });
    assert!(!session.is_unsaved(), "just opened");
    session.edit(edit.clone()).expect("a modest edit");
    assert!(session.is_unsaved(), "edited");
    session.save().expect("a sound disk");
    assert!(!session.is_unsaved(), "saved");
    session.undo();
    assert!(session.is_unsaved(), "undone past the mark");
    session.redo();
    session.save().expect("a sound disk");
    assert!(session.redo().is_none() && !session.is_unsaved(), "nothing to redo");
    session.begin_stroke(draw_move(&mut Numbers(1), session.surface())).expect("a modest stroke");
    assert!(session.is_unsaved(), "a stroke under way");
    session.cancel_stroke();
    assert!(!session.is_unsaved(), "and cancelled");
    session.edit(Edit::Gain(Gain { v: 2, level: 0, factor: 0.0 })).expect_err("a newer version");
    assert!(!session.is_unsaved(), "refused");
    let saved = session.hash();
    session.edit(edit).expect("a modest edit");
    let kept = session.hash();
    session.close().expect("a sound disk");
    let session = open(&disk, FILE);
    assert!(session.is_unsaved() && session.hash() == kept, "kept without a mark");
    session.discard().expect("a sound disk");
    let session = open(&disk, FILE);
    assert!(!session.is_unsaved() && session.hash() == saved, "discarded");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, ..ProptestConfig::default() })]

    /// Logged decimals read back to the steps for any placement, and none with fewer digits do.
    #[test]
    fn logged_decimals_read_back(
        mantissa in 1.0..10.0f64, exponent in -280..280i32, steps in prop::array::uniform3(-LIMIT..=LIMIT),
        shift in 0..27u32,
    ) {
        let steps = steps.map(|x| x >> shift);
        let step: f64 = format!("{mantissa}e{exponent}").parse().expect("a number");
        let placement = Placement { origin: [0.0; 3], step, up: Default::default(), unit: String::new() };
        let decimals = placement.shortest_decimals(steps);
        prop_assert_eq!(placement.vector_to_steps(decimals), Some(steps), "{:?}", decimals);
        let text = serde_json::to_string(&decimals).expect("finite");
        let read: [f64; 3] = serde_json::from_str(&text).expect("numbers");
        prop_assert_eq!(read.map(f64::to_bits), decimals.map(f64::to_bits), "{}", text);
        for (steps, x) in steps.into_iter().zip(decimals) {
            let scientific = format!("{x:e}");
            let digits = scientific.split('e').next().expect("a mantissa").trim_start_matches('-').len();
            if let Some(fewer) = digits.checked_sub(if digits > 2 { 3 } else { 2 }) {
                let exact = f64::from(steps) * step;
                let shorter: f64 = format!("{exact:.fewer$e}").parse().expect("a number");
                prop_assert!((shorter / step).round() != f64::from(steps) || shorter == x, "{} for {}", shorter, x);
            }
        }
    }
}
