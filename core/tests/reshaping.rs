//! Equalising, levels and hiding: exact on every awkward mesh, undone and replayed to the bit; and a history that stays
//! within its share of memory whatever is done.

mod memory_disk;
mod samples;

use bozzetto_core::edit::{
    Dab, Edit, EditError, Equalise, Falloff, Gain, Hide, Kind, LevelChange, Levels, Mirror, Move, Over, Part,
    Pull, Spread, Stroke, Tool,
};
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::hierarchy::{Level, Odd, Slot};
use bozzetto_core::mesh::shapes;
use bozzetto_core::session::{OpenOptions, Session, SessionError, open_model};
use bozzetto_core::surface::{Surface, SurfaceHash};
use bozzetto_core::wavelet::Wavelet;
use memory_disk::MemoryDisk;
use samples::{Numbers, assert_consistent, ball, contents, model};
use std::path::Path;
use std::sync::Arc;

fn session(levels: u8) -> Session {
    let model = Model::new(ball(levels), None, Metadata::default());
    Session::new(Arc::new(MemoryDisk::default()), model)
}

fn masked_half(session: &mut Session) {
    let surface = session.surface();
    let size = surface.form().placement.step * f64::from(1 << 24);
    let at = surface.position(surface.finest(), Slot(0));
    let words = stroke(Tool::Mask, 0, size, 1.0);
    let words = Stroke { falloff: Some(Falloff::Linear), dabs: vec![Dab::new(at)], ..words };
    session.edit(Edit::Stroke(words)).expect("a stroke");
}

fn stroke(tool: Tool, level: u8, radius: f64, strength: f64) -> Stroke {
    Stroke {
        tool,
        level,
        radius,
        strength,
        falloff: None,
        mirror: None,
        to: None,
        from: None,
        dabs: Vec::new(),
        v: 1,
    }
}

fn equalise(gains: &[f64], over: Over) -> Edit {
    Edit::Equalise(Equalise { gains: gains.to_vec(), over, v: 1 })
}

fn levels(change: LevelChange, level: Option<u8>) -> Edit {
    Edit::Levels(Levels { change, level, v: 1 })
}

fn hide(part: Part, faces: &[u32]) -> Edit {
    Edit::Hide(Hide { part, faces: faces.to_vec(), v: 1 })
}

#[test]
fn an_equaliser_multiplies_each_level_by_its_gain() {
    let mut session = session(4);
    let before = session.surface().clone();
    session.edit(equalise(&[1.0, 0.5, 3.0], Over::All)).expect("in range");
    assert_consistent(session.surface());
    for (j, gain) in [1.0, 0.5, 3.0, 1.0].into_iter().enumerate() {
        let level = Level(j as u8);
        for (old, new) in before.wavelets(level).iter().zip(session.surface().wavelets(level)) {
            assert_eq!(*new, old.map(|x| (f64::from(x) * gain).round() as i32));
        }
    }
    let spectra = [before.spectrum(), session.surface().spectrum()];
    assert!((spectra[1][1] / spectra[0][1] - 0.25).abs() < 1e-3, "{spectra:?}");
    assert_eq!(spectra[1][3], spectra[0][3]);
    // Gain by gain it is the edit that there always was.
    let mut alone = self::session(4);
    alone.edit(Edit::Gain(Gain { level: 1, factor: 0.5, v: 1 })).expect("in range");
    alone.edit(Edit::Gain(Gain { level: 2, factor: 3.0, v: 1 })).expect("in range");
    assert_eq!(alone.hash(), session.hash());
    session.undo();
    assert_eq!(contents(session.surface()), contents(&before));
}

#[test]
fn an_equaliser_acts_where_the_mask_says() {
    let mut session = session(4);
    masked_half(&mut session);
    let before = session.surface().clone();
    let changed = |session: &Session, of_mask: &dyn Fn(u8) -> bool| {
        let hierarchy = before.hierarchy();
        let layout = hierarchy.layout(Level(3));
        (0..layout.odd_len()).map(Odd).any(|odd| {
            let slot = hierarchy.layout(Level(4)).slot(layout.odd_site(odd));
            of_mask(before.mask().value(slot))
                && session.surface().wavelets(Level(3))[odd.index()] != before.wavelets(Level(3))[odd.index()]
        })
    };
    session.edit(equalise(&[1.0, 1.0, 1.0, 0.0], Over::Mask)).expect("in range");
    assert!(changed(&session, &|m| m > 200) && !changed(&session, &|m| m == 0));
    session.undo();
    session.edit(equalise(&[1.0, 1.0, 1.0, 0.0], Over::Free)).expect("in range");
    assert!(!changed(&session, &|m| m == 255) && changed(&session, &|m| m == 0));
    session.undo();
    session.edit(hide(Part::Mask, &[])).expect("a part");
    session.edit(equalise(&[1.0, 1.0, 1.0, 0.0], Over::All)).expect("in range");
    assert!(!changed(&session, &|m| m >= 128) && changed(&session, &|m| m == 0));
}

/// Dragged to and fro, previewed on coarse levels or not: the end is that of the one logged edit.
#[test]
fn dragging_gains_gives_the_bits_of_one_line() {
    let mut live = session(4);
    masked_half(&mut live);
    for over in [Over::All, Over::Mask] {
        let start = contents(live.surface());
        live.begin_equaliser(over).expect("it has wavelets");
        for (gain, reach) in [(0.2, 4), (1.7, 2), (1.4, 1), (1.0, 3), (0.3, 2)] {
            live.set_gains(&[1.0, gain, 2.0 - gain, gain], Level(reach)).expect("in range");
        }
        assert!(live.in_stroke());
        let refused = live.set_gains(&[1e12; 4], Level(4)).expect_err("far too much");
        assert!(matches!(refused, SessionError::Edit(EditError::BeyondLimit)));
        live.set_gains(&[1.0, 1.0, 1.0, 1.0], Level(2)).expect("in range");
        live.cancel_stroke();
        assert_eq!(contents(live.surface()), start);
        live.begin_equaliser(over).expect("it has wavelets");
        live.set_gains(&[1.0, 0.3, 1.7, 0.3], Level(2)).expect("in range");
        live.end_stroke();
        assert_consistent(live.surface());
        let after = live.hash();
        let logged = live.history().last().expect("a step");
        live.undo();
        assert_eq!(contents(live.surface()), start);
        live.edit(logged).expect("it was accepted before");
        assert_eq!(live.hash(), after);
    }
    // Gains of 1 are no edit.
    let steps = live.history_len();
    live.begin_equaliser(Over::All).expect("it has wavelets");
    live.set_gains(&[2.0], Level(4)).expect("in range");
    live.set_gains(&[1.0], Level(4)).expect("in range");
    live.end_stroke();
    assert_eq!(live.history_len(), steps);
}

/// The finest positions in model units, in any order.
fn points(surface: &Surface) -> Vec<[i32; 3]> {
    let mut points = surface.scaling(surface.finest()).to_vec();
    points.sort_unstable();
    points
}

#[test]
fn levels_come_and_go_exactly_on_awkward_meshes() {
    for (name, mesh) in shapes::awkward() {
        for (wavelet, sharp) in [(Wavelet::Disc(2), 1), (Wavelet::Lazy, 0)] {
            let disk = MemoryDisk::default();
            let mut session = Session::new(Arc::new(disk), model(&mesh, wavelet, sharp, 3, 4));
            masked_half(&mut session);
            let start = (contents(session.surface()), session.surface().mask().values().to_vec());
            let hash = session.hash();
            let before = session.surface().clone();

            session.edit(levels(LevelChange::Add, None)).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_consistent(session.surface());
            assert_eq!(session.surface().finest(), Level(4));
            assert_eq!(session.surface().scaling(Level(3)), before.scaling(Level(3)), "{name}: it stays");
            let detailed = session.hash();
            session.edit(levels(LevelChange::Base, Some(2))).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_consistent(session.surface());
            let now = session.surface();
            assert_eq!(now.finest(), Level(2), "{name}");
            assert_eq!(now.hierarchy().layout(Level(0)).len(), before.hierarchy().layout(Level(2)).len());
            // Sharp edges are part of the wavelets, but the finest positions stay.
            let sharp_edges = |s: &Surface| {
                let base = s.hierarchy().base();
                (0..base.edges().len() as u32).filter(|&e| base.is_sharp(e)).count()
            };
            assert_eq!(sharp_edges(now), 4 * sharp_edges(&before), "{name}");
            session.edit(levels(LevelChange::Finest, Some(0))).unwrap_or_else(|e| panic!("{name}: {e}"));
            assert_consistent(session.surface());
            assert_eq!(session.surface().finest(), Level(0), "{name}");
            assert!(session.edit(levels(LevelChange::Finest, Some(7))).is_err());
            let last = (contents(session.surface()), session.hash());

            session.undo();
            session.undo();
            assert_eq!(session.hash(), detailed, "{name}");
            assert_consistent(session.surface());
            session.undo();
            assert_eq!(session.hash(), hash, "{name}");
            assert!(contents(session.surface()) == start.0, "{name}");
            assert_eq!(session.surface().mask().values(), start.1, "{name}");
            (0..3).for_each(|_| drop(session.redo()));
            assert!((contents(session.surface()), session.hash()) == last, "{name}: redone");
        }
    }
}

#[test]
fn making_a_level_the_base_keeps_every_position() {
    let mut session = session(3);
    let before = points(session.surface());
    session.edit(levels(LevelChange::Base, Some(1))).expect("it has the level");
    assert_eq!(points(session.surface()), before);
    let next = session.surface().vertices_of_next_level();
    session.edit(levels(LevelChange::Add, None)).expect("small");
    let surface = session.surface();
    assert_eq!(next, Some(surface.scaling(surface.finest()).len() as u32));
}

#[test]
fn hidden_parts_stay_as_they_are() {
    let mut session = session(4);
    let start = session.hash();
    session.edit(hide(Part::Faces, &[0, 3])).expect("they exist");
    assert_eq!(session.hash(), start, "hiding is no part of the surface");
    let before = session.surface().clone();
    let hidden: Vec<Slot> = (0..before.scaling(Level(4)).len() as u32)
        .map(Slot)
        .filter(|&slot| before.mask().is_hidden(slot))
        .collect();
    assert!(hidden.len() > 100);
    let size = before.form().placement.step * f64::from(1 << 24);
    let dabs: Vec<Dab> =
        hidden.iter().step_by(29).map(|&slot| Dab::new(before.position(Level(4), slot))).collect();
    for tool in [Tool::Draw, Tool::Inflate, Tool::Flatten] {
        let words = Stroke { dabs: dabs.clone(), ..stroke(tool, 4, 0.4 * size, 1.0) };
        session.edit(Edit::Stroke(words)).expect("in range");
    }
    assert_ne!(session.hash(), start);
    for &slot in &hidden {
        assert_eq!(session.surface().scaling(Level(4))[slot.index()], before.scaling(Level(4))[slot.index()]);
    }
    session.edit(hide(Part::Nothing, &[])).expect("always");
    assert!(!session.surface().mask().hides_something());
    session.undo();
    assert!(session.surface().mask().hides_something());
    assert!(session.edit(hide(Part::Others, &[8])).is_err(), "an octahedron has eight faces");
}

/// One thing that a hand may do.
fn something(numbers: &mut Numbers, surface: &Surface) -> Edit {
    let finest = surface.finest();
    let size = surface.form().placement.step * f64::from(1 << 24);
    let level = numbers.below(u32::from(finest.0) + 1) as u8;
    let place = |numbers: &mut Numbers| {
        let slot = Slot(numbers.below(surface.scaling(finest).len() as u32));
        surface.position(finest, slot)
    };
    let delta = |numbers: &mut Numbers| std::array::from_fn(|_| 0.05 * size * numbers.signed());
    let mirror = (numbers.below(4) == 0).then(|| Mirror { x: Some(0.0), ..Mirror::default() });
    match numbers.below(40) {
        0 => levels(LevelChange::Add, None),
        1 => levels(LevelChange::Finest, Some(level)),
        2 => levels(LevelChange::Base, Some(level.min(1))),
        3..6 => {
            let gains: Vec<f64> = (0..finest.0).map(|_| 1.0 + 0.5 * numbers.signed()).collect();
            equalise(&gains, [Over::All, Over::Mask, Over::Free][numbers.below(3) as usize])
        }
        6 => hide([Part::Mask, Part::Free, Part::Shown][numbers.below(3) as usize], &[]),
        7 => hide(Part::Nothing, &[]),
        8 => hide(Part::Faces, &[numbers.below(surface.hierarchy().base().faces().len() as u32)]),
        9..17 => Edit::Move(Move {
            kind: Kind::Scaling,
            level,
            vertex: numbers.below(surface.hierarchy().layout(Level(level)).len()),
            delta: delta(numbers),
            radius: (numbers.below(2) == 0).then_some(0.3 * size),
            falloff: None,
            mirror: None,
            v: 1,
        }),
        17..22 => Edit::Pull(Pull {
            kind: Kind::Scaling,
            level,
            vertex: None,
            at: Some(place(numbers)),
            delta: delta(numbers),
            radius: Some(0.4 * size),
            falloff: None,
            spread: [Spread::Smooth, Spread::Hat][numbers.below(2) as usize],
            follow: numbers.below(2) == 0,
            mirror,
            v: 1 + numbers.below(Pull::LATEST_VERSION),
        }),
        _ => {
            let tool = Tool::ALL[numbers.below(Tool::ALL.len() as u32) as usize];
            let dabs = (0..=numbers.below(3)).map(|_| Dab::new(place(numbers))).collect();
            let words = stroke(tool, level, size * (0.1 + 0.2 * (numbers.signed() + 1.0)), 0.4);
            let from = (tool == Tool::Copy).then(|| place(numbers));
            Edit::Stroke(Stroke { mirror, from, dabs, v: tool.latest_version(), ..words })
        }
    }
}

/// Ten thousand random uses of tools, undos and redos: hashes return exactly, and the history stays within its budget.
#[test]
fn ten_thousand_random_uses_return_exactly_within_the_budget() {
    const BUDGET: usize = 64 << 10;
    let disk = MemoryDisk::default();
    let mut session =
        Session::new(Arc::new(disk.clone()), model(&shapes::octahedron(), Wavelet::Disc(2), 1, 2, 5));
    session.set_history_budget(BUDGET);
    let path = Path::new("random.boz");
    session.save_as(path).expect("it can be saved");
    let mut numbers = Numbers(20261123);
    // The hash after so many steps, as far as the history goes.
    let mut hashes: Vec<SurfaceHash> = vec![session.hash()];
    let (mut made, mut most) = (0, 0);
    for round in 0..10_000 {
        let steps = session.steps();
        match numbers.below(20) {
            0..6 => {
                for _ in 0..=numbers.below(4) {
                    session.undo();
                }
            }
            6..11 => {
                for _ in 0..=numbers.below(4) {
                    session.redo();
                }
            }
            _ => {
                // Levels are added and taken away, but the surface stays small.
                let finest = session.surface().finest();
                let vertices = session.surface().scaling(finest).len();
                let mut edit = something(&mut numbers, session.surface());
                if let Edit::Levels(change) = &edit {
                    match change.change {
                        LevelChange::Add if vertices > 300 => continue,
                        _ if change.change != LevelChange::Add && vertices < 60 => continue,
                        LevelChange::Base if finest < Level(2) => edit = levels(LevelChange::Add, None),
                        _ => {}
                    }
                }
                let before = session.hash();
                match session.edit(edit.clone()) {
                    Ok(_) => {
                        made += 1;
                        hashes.truncate(steps + 1);
                        hashes.push(session.hash());
                    }
                    Err(SessionError::Edit(EditError::BeyondLimit | EditError::NoWavelets)) => {
                        assert_eq!(session.hash(), before, "round {round}: {edit:?}");
                    }
                    Err(error) => panic!("round {round}: {edit:?}: {error}"),
                }
            }
        }
        assert_eq!(session.hash(), hashes[session.steps()], "round {round}");
        // What is over the budget is put away at once; the log keeps at most one piece.
        most = most.max(session.history_in_memory());
        assert!(session.history_in_memory() <= BUDGET + (1 << 17), "round {round}");
    }
    assert!(made > 3000, "{made}");
    assert!(most > BUDGET / 2, "{most}: the budget was never reached");
    assert_eq!(session.history_failure(), None);
    assert_consistent(session.surface());
    let last = session.hash();
    let steps = session.steps();
    session.go_to(0);
    assert_eq!(session.hash(), hashes[0]);
    session.go_to(steps);
    assert_eq!(session.hash(), last);
    session.save().expect("it has a file");
    session.close().expect("the log is on disk");
    let (reopened, _) = open_model(&disk, path, OpenOptions::default()).expect("the log replays");
    assert_eq!(reopened.surface.hash(), last);
}
