//! Steps undone and redone on coarse levels before they are everywhere: what is seen is what comes, and no bit stays of it.

mod memory_disk;
mod samples;

use bozzetto_core::edit::{Edit, Gain, Kind, Mirror, Move, Pull, Spread};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::mesh::shapes;
use bozzetto_core::surface::Moved;
use bozzetto_core::wavelet::Wavelet;
use memory_disk::session_of;
use samples::{assert_consistent, ball, contents, surface};

const PULL: Pull = Pull::of(Kind::Scaling, 0, 2, [0.3, 0.1, -0.2]);

fn edits() -> Vec<Edit> {
    let raw = Move {
        kind: Kind::Scaling,
        level: 0,
        vertex: 2,
        delta: [0.1, -0.2, 0.3],
        radius: None,
        falloff: None,
        mirror: None,
        v: 1,
    };
    let mirror = Some(Mirror { x: Some(0.1), y: None, z: None });
    vec![
        Edit::Move(raw),
        Edit::Pull(PULL),
        Edit::Pull(Pull { follow: true, ..PULL }),
        Edit::Pull(Pull { follow: true, spread: Spread::Hat, mirror, ..PULL }),
        Edit::Move(Move { kind: Kind::Wavelet, vertex: 30, radius: Some(1.0), ..raw }),
        Edit::Gain(Gain { level: 1, factor: -0.5, v: 1 }),
    ]
}

/// Undo and redo after a glimpse on any level leave the bits that they leave without; the level looked at is where it will be.
#[test]
fn what_is_seen_before_a_step_comes_and_leaves_no_bit_behind() {
    for (name, mesh) in shapes::awkward() {
        let start = surface(&mesh, Wavelet::Disc(2), 1, 3, 11);
        for edit in edits() {
            if matches!(edit, Edit::Move(Move { kind: Kind::Wavelet, .. }))
                && !(start.hierarchy().layout(Level(0)).len()..start.hierarchy().layout(Level(1)).len())
                    .contains(&30)
            {
                continue;
            }
            let mut session = session_of(start.clone());
            if mesh.positions.len() < 3 || session.edit(edit.clone()).is_err() {
                continue;
            }
            let states = [contents(&start), contents(session.surface())];
            let hashes = [start.hash(), session.hash()];
            // The coarsest level whose vertices it moves by themselves.
            let home = match edit {
                Edit::Pull(Pull { spread: Spread::Smooth, .. }) => Level(3),
                Edit::Gain(_) => Level(2),
                Edit::Move(Move { kind: Kind::Wavelet, .. }) => Level(1),
                _ => Level(0),
            };
            for reach in (0..=3).map(Level) {
                let what = format!("{name}, {edit}, level {reach}");
                session.preview_undo(reach);
                let seen = session.surface().scaling(reach);
                assert!(reach < home || seen == start.scaling(reach), "{what}: seen before undo");
                session.undo().expect("a step");
                assert!(contents(session.surface()) == states[0], "{what}: undone");
                assert_eq!(session.hash(), hashes[0], "{what}: undone");
                session.preview_redo(reach);
                let seen = session.surface().scaling(reach);
                assert!(reach < home || seen == states[1][reach.index()], "{what}: seen before redo");
                session.redo().expect("a step");
                assert!(contents(session.surface()) == states[1], "{what}: redone");
                assert_eq!(session.hash(), hashes[1], "{what}: redone");
                // Something else may come instead.
                session.preview_undo(reach);
                session.cancel_stroke();
                assert!(contents(session.surface()) == states[1], "{what}: given up");
                session.preview_undo(reach);
                session.edit(Edit::Gain(Gain { level: 0, factor: 2.0, v: 1 })).expect("a sensible gain");
                session.undo().expect("a step");
                assert!(contents(session.surface()) == states[1], "{what}: another edit instead");
            }
            assert_consistent(session.surface());
        }
    }
}

/// A pull that moves a large surface is seen on a coarser level, without a vertex of finer ones; small steps need no such thing.
#[test]
fn a_large_step_is_seen_on_a_coarser_level() {
    let mut session = session_of(ball(7));
    let start = session.surface().clone();
    assert_eq!(session.undo_shown_at_once(), None, "there is nothing to undo");
    for follow in [false, true] {
        session.edit(Edit::Pull(Pull { follow, ..PULL })).expect("a sensible pull");
        let finest = session.surface().finest();
        let level = session.undo_shown_at_once().expect("a level fits");
        assert!(Level(4) <= level && level < finest, "level {level}");
        let before = session.surface().scaling(finest).to_vec();
        let changes = session.preview_undo(level);
        assert_ne!(*changes.at(level), Moved::Nothing);
        assert_eq!(*changes.at(finest), Moved::Nothing);
        assert!(session.surface().scaling(finest) == before);
        assert!(session.surface().scaling(level) == start.scaling(level), "it is seen as it will be");
        session.undo().expect("a step");
        assert!(session.redo_shown_at_once() == Some(level), "as for the way back");
        assert_eq!(session.undo_shown_at_once(), None);
    }
    assert_eq!(session.hash(), session.original_hash());
    // Detail of the last level is on no coarser one.
    session.edit(Edit::Gain(Gain { level: 6, factor: 0.0, v: 1 })).expect("a sensible gain");
    assert_eq!(session.undo_shown_at_once(), None);
}
