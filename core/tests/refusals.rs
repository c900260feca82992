//! What is refused changes nothing: neither surface nor hash nor history nor log; and nothing leaves the range.

mod memory_disk;
mod samples;

use bozzetto_core::edit::{Edit, EditError, Falloff, Gain, Kind, Move};
use bozzetto_core::file::encode;
use bozzetto_core::hierarchy::Level;
use bozzetto_core::mesh::{TriangleMesh, shapes};
use bozzetto_core::session::{OpenOptions, Session, SessionError, open_model};
use bozzetto_core::surface::{LIMIT, Vector};
use bozzetto_core::wavelet::Wavelet;
use memory_disk::MemoryDisk;
use samples::{Numbers, assert_consistent, contents, draw_edit, draw_move, model};
use std::path::Path;
use std::sync::Arc;

const FILE: &str = "work/bust.boz";

/// A session on a saved file.
fn session(mesh: &TriangleMesh, wavelet: Wavelet) -> (MemoryDisk, Session) {
    let disk = MemoryDisk::default();
    disk.put(FILE, &encode(&model(mesh, wavelet, 1, 3, 23)));
    let opened = Session::open(Arc::new(disk.clone()), Path::new(FILE), OpenOptions::default(), &|_| true);
    (disk, opened.expect("a sound file").session)
}

/// Every way to be refused.
#[test]
fn what_is_refused_changes_nothing() {
    let (disk, mut session) = session(&shapes::octahedron(), Wavelet::Disc(2));
    session.edit(draw_edit(&mut Numbers(3), session.surface())).expect("a modest edit");
    session.undo();
    let plain = Move {
        kind: Kind::Scaling,
        level: 1,
        vertex: 3,
        delta: [0.1, 0.0, 0.0],
        radius: None,
        falloff: None,
        mirror: None,
        v: 1,
    };
    let count = |level| session.surface().scaling(Level(level)).len() as u32;
    let wavelet = Move { kind: Kind::Wavelet, vertex: count(1), ..plain };
    let (first, past) = (count(1), count(2));
    let edits = [
        Edit::Move(Move { level: 4, ..plain }),
        Edit::Move(Move { level: 3, ..wavelet }),
        Edit::Move(Move { level: 255, ..plain }),
        Edit::Move(Move { vertex: first, ..plain }),
        Edit::Move(Move { vertex: u32::MAX, ..plain }),
        Edit::Move(Move { vertex: first - 1, ..wavelet }),
        Edit::Move(Move { vertex: past, ..wavelet }),
        Edit::Move(Move { delta: [f64::NAN, 0.0, 0.0], ..plain }),
        Edit::Move(Move { delta: [0.0, f64::INFINITY, 0.0], ..wavelet }),
        Edit::Move(Move { delta: [0.0, 0.0, 1e9], ..plain }),
        Edit::Move(Move { radius: Some(0.0), ..plain }),
        Edit::Move(Move { radius: Some(-1.0), ..wavelet }),
        Edit::Move(Move { radius: Some(f64::NAN), ..plain }),
        Edit::Move(Move { falloff: Some(Falloff::Sharp), ..plain }),
        Edit::Move(Move { v: 3, ..plain }),
        Edit::Move(Move { v: 0, ..plain }),
        Edit::Gain(Gain { level: 3, factor: 1.0, v: 1 }),
        Edit::Gain(Gain { level: 0, factor: f64::NAN, v: 1 }),
        Edit::Gain(Gain { level: 0, factor: 1e6, v: 1 }),
        Edit::Gain(Gain { level: 0, factor: 1.0, v: 7 }),
    ];
    let state = |session: &Session| {
        (contents(session.surface()), session.hash(), session.steps(), session.history_len())
    };
    let before = state(&session);
    for edit in edits {
        let error = session.edit(edit.clone()).expect_err("to be refused");
        assert!(matches!(error, SessionError::Edit(_)) && error.to_string().len() > 20, "{edit:?}: {error}");
        assert!(state(&session) == before, "{edit:?}");
        // A stroke is refused for the same reasons at its beginning, but for its delta.
        if let Edit::Move(stroke) = &edit
            && stroke.delta == plain.delta
        {
            let error = session.begin_stroke(*stroke).expect_err("to be refused");
            assert!(matches!(error, SessionError::Edit(_)) && !session.in_stroke(), "{edit:?}: {error}");
            assert!(state(&session) == before, "{edit:?}");
        }
    }
    session.begin_stroke(plain).expect("a modest stroke");
    session.drag_to([0.2, 0.2, 0.2]).expect("in range");
    let dragged = contents(session.surface());
    for delta in [[f64::NAN; 3], [0.0, f64::NEG_INFINITY, 0.0], [1e9, 0.0, 0.0], [8.7, 8.7, -8.7]] {
        session.drag_to(delta).expect_err("to be refused");
        assert!(contents(session.surface()) == dragged, "the stroke stays where it was: {delta:?}");
    }
    session.cancel_stroke();
    assert!(state(&session) == before);
    session.close().expect("a sound disk");
    let (read, _) = open_model(&disk, Path::new(FILE), OpenOptions::default()).expect("a sound log");
    assert!(contents(&read.surface) == before.0);
}

/// Large moves again and again: each is made whole or not at all, and no coefficient ever leaves the range.
#[test]
fn the_limit_holds_against_repetition() {
    for (mesh, wavelet) in [(shapes::octahedron(), Wavelet::Disc(2)), (shapes::disc(5), Wavelet::Disc(1))] {
        let (_, mut session) = session(&mesh, wavelet);
        let start = contents(session.surface());
        let mut numbers = Numbers(6);
        let (mut made, mut refused) = (0, 0);
        for at in 0..150 {
            let before = contents(session.surface());
            let steps = session.steps();
            let edit = if at % 10 == 9 {
                Edit::Gain(Gain { level: numbers.below(3) as u8, factor: 3.0 * numbers.signed(), v: 1 })
            } else {
                let delta = std::array::from_fn(|_| 6.0 * numbers.signed());
                Edit::Move(Move { delta, ..draw_move(&mut numbers, session.surface()) })
            };
            match session.edit(edit.clone()) {
                Ok(_) => {
                    made += 1;
                    let within = |v: &Vector| v.iter().all(|x| (-LIMIT..=LIMIT).contains(x));
                    assert!(contents(session.surface()).iter().flatten().all(within), "{edit:?}");
                }
                Err(SessionError::Edit(EditError::BeyondLimit)) => {
                    refused += 1;
                    assert!(contents(session.surface()) == before, "{edit:?}");
                    assert_eq!(session.steps(), steps);
                }
                Err(error) => panic!("{edit:?}: {error}"),
            }
            assert_consistent(session.surface());
        }
        assert!(made > 20 && refused > 20, "{made} made, {refused} refused");
        session.go_to(0);
        assert!(contents(session.surface()) == start);
    }
}
