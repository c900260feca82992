//! Brush strokes: whole and exact on every awkward mesh, undone and replayed to the bit.

mod memory_disk;
mod samples;

use bozzetto_core::disk::Vfs;
use bozzetto_core::edit::{Dab, Edit, EditError, Falloff, Mirror, Step, Stroke, Tool, plan};
use bozzetto_core::file::encode;
use bozzetto_core::hierarchy::{Level, Slot};
use bozzetto_core::mesh::shapes;
use bozzetto_core::session::{OpenOptions, Session, SessionError, open_model};
use bozzetto_core::surface::{LIMIT, Moved, Surface};
use bozzetto_core::wavelet::Wavelet;
use memory_disk::{MemoryDisk, session_of};
use samples::{Numbers, assert_consistent, ball, contents, model, on_threads, stroke, surface};
use std::path::Path;
use std::sync::Arc;

/// A stroke of a few dabs near places of the surface.
fn random_stroke(numbers: &mut Numbers, surface: &Surface) -> Stroke {
    let finest = surface.finest();
    let size = surface.form().placement.step * f64::from(1 << 24);
    let tool = Tool::ALL[numbers.below(Tool::ALL.len() as u32) as usize];
    let falloffs = [None, Some(Falloff::Linear), Some(Falloff::Sharp), Some(Falloff::Constant)];
    let planes = |numbers: &mut Numbers| Mirror {
        x: (numbers.below(2) == 0).then(|| surface.form().placement.origin[0]),
        y: None,
        z: (numbers.below(3) == 0).then(|| surface.form().placement.origin[2]),
    };
    let mirror = (numbers.below(3) == 0).then(|| planes(numbers));
    let dabs = (0..=numbers.below(5))
        .map(|_| {
            let slot = Slot(numbers.below(surface.scaling(finest).len() as u32));
            Dab {
                strength: 0.5 + 0.5 * numbers.signed(),
                size: 1.0 + 0.5 * numbers.signed(),
                ..Dab::new(surface.position(finest, slot))
            }
        })
        .collect();
    Stroke {
        strength: 0.7 * numbers.signed(),
        falloff: falloffs[numbers.below(4) as usize],
        mirror,
        to: (tool == Tool::Erase && finest > Level::BASE && numbers.below(2) == 0)
            .then(|| numbers.below(u32::from(finest.0)) as u8),
        from: Some(surface.position(finest, Slot(0))),
        v: 1 + numbers.below(tool.latest_version()),
        dabs,
        ..stroke(
            tool,
            numbers.below(u32::from(finest.0) + 1) as u8,
            size * (0.02 + 0.3 * (numbers.signed() + 1.0)),
        )
    }
}

#[test]
fn strokes_are_whole_and_undone_exactly_on_awkward_meshes() {
    for (name, mesh) in shapes::awkward() {
        for (wavelet, sharp) in [(Wavelet::Disc(2), 1), (Wavelet::Disc(0), 0)] {
            let mut surface = surface(&mesh, wavelet, sharp, 3, 7);
            let mut numbers = Numbers(mesh.faces.len() as u64);
            let mut steps = Vec::new();
            for _ in 0..8 {
                let edit = Edit::Stroke(random_stroke(&mut numbers, &surface));
                let before = (contents(&surface), surface.mask().clone());
                let planned = plan(&surface, &edit).unwrap_or_else(|e| panic!("{name}: {edit:?}: {e}"));
                match Step::apply(&mut surface, edit.clone(), planned) {
                    Ok((step, _)) => steps.push((step, before, edit)),
                    Err(EditError::BeyondLimit) => {
                        assert!(contents(&surface) == before.0, "{name}: {edit:?}")
                    }
                    Err(error) => panic!("{name}: {edit:?}: {error}"),
                }
            }
            assert_consistent(&surface);
            let last = (contents(&surface), surface.mask().values().to_vec());
            for (step, before, edit) in steps.iter_mut().rev() {
                undo::Edit::undo(step, &mut surface);
                assert!(contents(&surface) == before.0, "{name}: undo of {edit:?}");
                let mask = before.1.values();
                let now = surface.mask().values();
                assert!(
                    mask == now || mask.is_empty() && now.iter().all(|&m| m == 0),
                    "{name}: mask, {edit:?}"
                );
            }
            for (step, ..) in &mut steps {
                // The first call only tells that the edit is already there.
                let _ = undo::Edit::edit(step, &mut surface);
                undo::Edit::edit(step, &mut surface);
            }
            assert_eq!(contents(&surface), last.0, "{name}: redo");
            assert_eq!(surface.mask().values(), last.1, "{name}: redo of the mask");
            assert_consistent(&surface);
        }
    }
}

/// What is reported as moved is what moved, and the boxes for finding places follow it.
#[test]
fn dabs_report_what_moved_and_places_are_found_as_on_a_fresh_surface() {
    for (name, mesh) in shapes::awkward().into_iter().take(8) {
        let disk = MemoryDisk::default();
        let mut session = Session::new(Arc::new(disk), model(&mesh, Wavelet::Disc(2), 1, 4, 3));
        let mut numbers = Numbers(11);
        for round in 0..6 {
            let stroke = random_stroke(&mut numbers, session.surface());
            session.begin_brush(Stroke { dabs: Vec::new(), ..stroke.clone() }).expect("a sensible stroke");
            for dab in &stroke.dabs {
                let before = session.surface().clone();
                let Ok(changes) = session.dab(*dab) else { continue };
                let now = session.surface();
                let moved = match changes.at(now.finest()) {
                    Moved::Some(runs) => runs.slots().collect::<Vec<_>>(),
                    _ => Vec::new(),
                };
                let finest = now.finest();
                for (slot, (old, new)) in before.scaling(finest).iter().zip(now.scaling(finest)).enumerate() {
                    let told = moved.binary_search(&Slot(slot as u32)).is_ok();
                    assert!(old == new || told, "{name}, {round}: slot {slot} moved unreported");
                }
            }
            session.end_stroke();
            let now = session.surface();
            let fresh = Surface::from_finest(
                now.hierarchy().as_ref().clone(),
                now.form().clone(),
                now.scaling(now.finest()).to_vec(),
            )
            .expect("as before");
            for _ in 0..20 {
                let p = std::array::from_fn(|_| numbers.signed() * f64::from(1 << 25));
                assert_eq!(now.nearest(p), fresh.nearest(p), "{name}, {round}: {p:?}");
            }
        }
    }
}

/// The closest point is the closest of all triangles' points.
#[test]
fn the_nearest_place_is_the_nearest() {
    let (_, mesh) = shapes::awkward().into_iter().find(|(n, _)| *n == "genus 2").expect("a known mesh");
    let surface = surface(&mesh, Wavelet::Disc(1), 0, 3, 5);
    let finest = surface.finest();
    let positions = surface.scaling(finest);
    let mut numbers = Numbers(2);
    for _ in 0..40 {
        let p: [f64; 3] = std::array::from_fn(|_| numbers.signed() * f64::from(1 << 25));
        let found = surface.nearest(p);
        let distance = |q: [f64; 3]| (0..3).map(|c| (p[c] - q[c]) * (p[c] - q[c])).sum::<f64>();
        assert!(
            (distance(found.point) - found.squared_distance).abs() <= 1e-9 * found.squared_distance + 1.0
        );
        // No corner and no point sampled in a triangle is closer.
        for face in surface.hierarchy().triangles(finest) {
            for (a, b) in [(1.0, 0.0), (0.0, 1.0), (0.0, 0.0), (0.4, 0.3), (0.2, 0.7), (0.5, 0.5)] {
                let weights = [a, b, 1.0 - a - b];
                let q = std::array::from_fn(|c| {
                    (0..3).map(|k| weights[k] * f64::from(positions[face[k] as usize][c])).sum::<f64>()
                });
                assert!(distance(q) >= found.squared_distance * (1.0 - 1e-9), "{p:?}");
            }
        }
        let (triangle, weights) = found.address.triangle(finest);
        let layout = surface.hierarchy().layout(finest);
        let again: [f64; 3] = std::array::from_fn(|c| {
            let corner = |k: usize| {
                let [i, r] = triangle.corners()[k];
                let site = layout.site_at(triangle.face, [layout.segments() - i - r, i, r]);
                f64::from(positions[layout.slot(site).index()][c])
            };
            (0..3).map(|k| weights[k] * corner(k)).sum()
        });
        assert!(distance(again).sqrt() <= found.squared_distance.sqrt() * (1.0 + 1e-6) + 1e3, "{found:?}");
    }
}

fn session_on(disk: &MemoryDisk, mesh: &bozzetto_core::mesh::TriangleMesh) -> Session {
    disk.put("a.boz", &encode(&model(mesh, Wavelet::Disc(2), 1, 3, 23)));
    reopened(disk).expect("a sound pair")
}

fn reopened(disk: &MemoryDisk) -> Result<Session, SessionError> {
    let vfs: Arc<dyn Vfs> = Arc::new(disk.clone());
    Ok(Session::open(vfs, Path::new("a.boz"), OpenOptions::default(), &|_| true)?.session)
}

#[test]
fn live_strokes_replay_to_the_same_bits_on_any_number_of_threads() {
    for (name, mesh) in shapes::awkward().into_iter().take(9) {
        let disk = MemoryDisk::default();
        let mut session = session_on(&disk, &mesh);
        let mut numbers = Numbers(77);
        for round in 0..12 {
            let stroke = random_stroke(&mut numbers, session.surface());
            let before = (contents(session.surface()), session.history_len());
            session.begin_brush(Stroke { dabs: Vec::new(), ..stroke.clone() }).expect("a sensible stroke");
            for dab in &stroke.dabs {
                let _ = session.dab(*dab);
            }
            if round % 4 == 3 {
                session.cancel_stroke();
                assert!((contents(session.surface()), session.history_len()) == before, "{name}: cancelled");
            } else {
                session.end_stroke();
                if round % 5 == 2 {
                    session.undo();
                }
            }
        }
        assert_consistent(session.surface());
        session.save().expect("a sound disk");
        let (hash, mask) = (session.hash(), session.surface().mask().clone());
        session.close().expect("a sound disk");
        for threads in [1, 5] {
            let again = on_threads(threads, || reopened(&disk).expect("a sound pair"));
            assert_eq!(again.hash(), hash, "{name}, {threads} threads");
            let (a, b) = (again.surface().mask().values(), mask.values());
            assert!(a == b || a.iter().chain(b).all(|&m| m == 0), "{name}: the mask comes back with the log");
            again.close().expect("a sound disk");
        }
        let (read, _) = open_model(&disk, Path::new("a.boz"), OpenOptions::default()).expect("a sound pair");
        assert_eq!(read.surface.hash(), hash, "{name}");
    }
}

/// Level, radius and strength that a hand chose are in its line, and each decides what that does.
#[test]
fn level_radius_and_strength_decide_what_a_line_does() {
    let line =
        r#"{"edit":"stroke","tool":"draw","level":2,"radius":0.4,"strength":0.5,"dabs":[[0.0,0.9,0.3]]}"#;
    let hash_of = |text: &str| {
        let mut session = session_of(ball(4));
        session.edit(serde_json::from_str(text).expect("a line")).expect("in range");
        session.hash()
    };
    let mut hashes = vec![session_of(ball(4)).hash(), hash_of(line)];
    for (chosen, other) in [
        ("\"level\":2", "\"level\":3"),
        ("\"radius\":0.4", "\"radius\":0.3"),
        ("\"strength\":0.5", "\"strength\":0.4"),
    ] {
        assert!(line.contains(chosen));
        hashes.push(hash_of(&line.replace(chosen, other)));
    }
    hashes.sort_by_key(|hash| hash.0);
    hashes.dedup();
    assert_eq!(hashes.len(), 5, "all differ");
}

#[test]
fn strokes_without_sense_are_refused_and_change_nothing() {
    let mut session = session_of(ball(3));
    let hash = session.hash();
    let good = Stroke { dabs: vec![Dab::new([0.0, 1.0, 0.0])], ..stroke(Tool::Draw, 3, 0.2) };
    let bad = [
        Stroke { radius: 0.0, ..good.clone() },
        Stroke { radius: f64::NAN, ..good.clone() },
        Stroke { strength: f64::INFINITY, ..good.clone() },
        Stroke { level: 4, ..good.clone() },
        Stroke { v: 2, ..good.clone() },
        Stroke { tool: Tool::Erase, to: Some(3), ..good.clone() },
        Stroke { dabs: vec![Dab { size: -1.0, ..Dab::new([0.0; 3]) }], ..good.clone() },
        Stroke { dabs: vec![Dab::new([f64::NAN, 0.0, 0.0])], ..good.clone() },
        Stroke { dabs: vec![Dab::new([0.0; 3]); 5000], ..good.clone() },
        Stroke { mirror: Some(Mirror { x: Some(f64::NAN), y: None, z: None }), ..good.clone() },
        Stroke { strength: f64::from(LIMIT), ..good.clone() },
        Stroke { strength: 1e300, radius: 1e300, ..good.clone() },
    ];
    for stroke in bad {
        let text = format!("{stroke:?}");
        assert!(session.edit(Edit::Stroke(stroke)).is_err(), "{text}");
        assert_eq!(session.hash(), hash, "{text}");
        assert_eq!(session.history_len(), 0, "{text}");
    }
    session.edit(Edit::Stroke(good)).expect("the one that is fine");
}

#[test]
fn a_long_stroke_goes_on_as_a_new_one() {
    let mut session = session_of(ball(3));
    session.begin_brush(stroke(Tool::Draw, 3, 0.2)).expect("a sensible stroke");
    for at in 0..4100 {
        let turn = f64::from(at) * 0.01;
        session.dab(Dab { strength: 0.01, ..Dab::new([turn.cos(), 0.2, turn.sin()]) }).expect("in range");
    }
    session.end_stroke();
    let counts: Vec<usize> = session
        .history()
        .map(|edit| match edit {
            Edit::Stroke(stroke) => stroke.dabs.len(),
            other => panic!("{other}"),
        })
        .collect();
    assert_eq!(counts, [4096, 4]);
}
