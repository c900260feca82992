//! Pulls of wavelet coefficients: detail moves as asked and without creases, the coarser form keeps every bit.

mod memory_disk;
mod samples;

use bozzetto_core::edit::{Edit, EditError, Entry, Kind, Line, Mirror, Move, Pull, Spread, plan};
use bozzetto_core::hierarchy::{Level, PublicId};
use bozzetto_core::mesh::shapes;
use bozzetto_core::surface::Surface;
use bozzetto_core::wavelet::Wavelet;
use memory_disk::session_of;
use samples::{assert_consistent, ball, contents, surface};

fn pull(level: u8, vertex: u32, delta: [f64; 3]) -> Pull {
    Pull::of(Kind::Wavelet, level, vertex, delta)
}

/// The first wavelet of a level.
fn first(surface: &Surface, level: u8) -> u32 {
    surface.hierarchy().layout(Level(level)).len()
}

/// The sharpest angle between neighbouring faces of the finest level, in degrees.
fn sharpest(surface: &Surface) -> f64 {
    let mesh = surface.to_mesh(surface.finest());
    let normal = |f: &[u32; 3]| {
        let [a, b, c] = f.map(|v| glam::DVec3::from_array(mesh.positions[v as usize]));
        (b - a).cross(c - a).normalize()
    };
    let mut across = std::collections::HashMap::new();
    let mut worst: f64 = 0.0;
    for face in &mesh.faces {
        for k in 0..3 {
            let (a, b) = (face[k], face[(k + 1) % 3]);
            if let Some(other) = across.insert((a.min(b), a.max(b)), normal(face)) {
                worst = worst.max(normal(face).dot(other).clamp(-1.0, 1.0).acos().to_degrees());
            }
        }
    }
    worst
}

#[test]
fn the_vertex_goes_as_asked_without_creases_and_the_coarser_form_stays() {
    let start = Surface::ball(6, |_| 1.0);
    for level in [0, 1, 2] {
        let delta = [0.01, 0.05, -0.02].map(|x| x / f64::from(1 << level));
        for radius in [None, Some(0.5)] {
            let made = |spread| {
                let mut session = session_of(start.clone());
                let vertex = first(&start, level) + 2;
                let edit = Edit::Pull(Pull { spread, radius, ..pull(level, vertex, delta) });
                session.edit(edit).expect("a sensible pull");
                let what = format!("level {level}, {spread:?}, {radius:?}");
                let now = session.surface();
                for coarser in (0..=level).map(Level) {
                    assert!(now.scaling(coarser) == start.scaling(coarser), "{what}: c of level {coarser}");
                }
                for coarser in (0..level).map(Level) {
                    assert!(now.wavelets(coarser) == start.wavelets(coarser), "{what}: d of level {coarser}");
                }
                let layout = start.hierarchy().layout(Level(6));
                let slot = layout.slot(layout.site_of(PublicId(vertex)));
                for (c, asked) in delta.into_iter().enumerate() {
                    let moved = now.position(Level(6), slot)[c] - start.position(Level(6), slot)[c];
                    assert!((moved - asked).abs() < 1e-6, "{what}: {moved}, asked for {asked}");
                }
                assert_consistent(now);
                let angle = sharpest(now);
                session.undo();
                assert!(contents(session.surface()) == contents(&start), "{what}: undo");
                angle
            };
            let [smooth, tent] = [Spread::Smooth, Spread::Hat].map(made);
            assert!(smooth < 0.6 * tent, "level {level}, {radius:?}: {smooth}° smooth, {tent}° raw");
        }
    }
}

/// Hats without anything else are the raw wavelet, given another length.
#[test]
fn a_pull_with_hats_is_a_wavelet_move() {
    for (name, mesh) in shapes::awkward() {
        let start = surface(&mesh, Wavelet::Disc(2), 0, 3, 9);
        let vertex = first(&start, 1);
        let peak = start.wavelet_peak(Level(1), bozzetto_core::hierarchy::Odd(0));
        let delta = [0.1, -0.2, 0.05];
        let raw = Move {
            kind: Kind::Wavelet,
            level: 1,
            vertex,
            delta: delta.map(|x| x / peak),
            radius: None,
            falloff: None,
            mirror: None,
            v: 1,
        };
        let edits = [Edit::Pull(Pull { spread: Spread::Hat, ..pull(1, vertex, delta) }), Edit::Move(raw)];
        let [a, b] = edits.map(|edit| {
            let mut session = session_of(start.clone());
            session.edit(edit).expect("in range");
            session.surface().scaling(Level(3)).to_vec()
        });
        let apart = a.iter().zip(&b).flat_map(|(a, b)| (0..3).map(|c| (a[c] - b[c]).abs())).max();
        assert!(apart <= Some(8), "{name}: {apart:?} steps apart");
    }
}

/// What follows turns finer detail, and nothing of the pulled level or coarser ones.
#[test]
fn finer_detail_follows() {
    let start = ball(6);
    let hashes = [false, true].map(|follow| {
        let mut session = session_of(start.clone());
        let edit = Pull { follow, ..pull(1, first(&start, 1) + 2, [0.1, 0.2, 0.0]) };
        session.edit(Edit::Pull(edit)).expect("a sensible pull");
        assert!(session.surface().scaling(Level(1)) == start.scaling(Level(1)));
        assert_consistent(session.surface());
        let hash = session.hash();
        session.undo();
        assert!(contents(session.surface()) == contents(&start));
        session.redo();
        assert_eq!(session.hash(), hash);
        hash
    });
    assert_ne!(hashes[0], hashes[1]);
}

#[test]
fn a_mirrored_pull_moves_both_sides() {
    let start = Surface::ball(5, |_| 1.0);
    let mirror = Some(Mirror { x: Some(0.0), y: None, z: None });
    let mut session = session_of(start.clone());
    let edit = Pull { mirror, ..pull(2, first(&start, 2) + 9, [0.05, 0.1, 0.02]) };
    assert_eq!(session.begin_pull(edit).expect("sensible"), 0, "it has a partner");
    session.cancel_stroke();
    session.edit(Edit::Pull(edit)).expect("a sensible pull");
    let surface = session.surface();
    let positions = surface.to_mesh(Level(5)).positions;
    for p in &positions {
        let placement = &surface.form().placement;
        let q = [-p[0], p[1], p[2]];
        let near = surface.nearest(std::array::from_fn(|c| (q[c] - placement.origin[c]) / placement.step));
        assert!(near.squared_distance.sqrt() * placement.step < 1e-3, "{p:?} has no image");
    }
    assert_ne!(session.hash(), session.original_hash());
}

#[test]
fn what_makes_no_sense_is_refused_and_lines_say_what_is_needed() {
    let start = ball(3);
    let good = pull(1, first(&start, 1), [0.1, 0.0, 0.0]);
    let text = serde_json::to_string(&Edit::Pull(good)).expect("plain data");
    assert_eq!(text, r#"{"edit":"pull","kind":"wavelet","level":1,"vertex":18,"delta":[0.1,0.0,0.0],"v":3}"#);
    assert_eq!(Line::parse(&text).expect("its own text").entry, Entry::Edit(Edit::Pull(good)));
    let old = r#"{"edit":"pull","level":0,"vertex":1,"delta":[0.0,0.1,0.0],"follow":true,"v":2}"#;
    let Ok(Line { entry: Entry::Edit(edit), .. }) = Line::parse(old) else { panic!("{old}") };
    assert!(matches!(edit, Edit::Pull(Pull { kind: Kind::Scaling, .. })));
    assert_eq!(serde_json::to_string(&edit).expect("plain data"), old, "old lines stay as they were");
    let refusal = |edit: Pull| plan(&start, &Edit::Pull(edit)).expect_err("it makes no sense");
    assert_eq!(refusal(Pull { v: 2, ..good }), EditError::WaveletVersion);
    assert_eq!(refusal(Pull { v: 4, ..good }), EditError::UnknownVersion { version: 4 });
    assert_eq!(refusal(Pull { vertex: None, at: Some([0.0, 1.0, 0.0]), ..good }), EditError::WaveletHold);
    assert_eq!(refusal(Pull { vertex: None, ..good }), EditError::WaveletHold);
    assert!(matches!(refusal(Pull { vertex: Some(17), ..good }), EditError::UnknownVertex { first: 18, .. }));
    assert!(matches!(refusal(Pull { level: 3, ..good }), EditError::UnknownLevel { last: 2, .. }));
    assert_eq!(refusal(Pull { radius: Some(-1.0), ..good }), EditError::Radius { radius: -1.0 });
}
