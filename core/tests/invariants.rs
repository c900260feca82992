//! The four invariants, on the awkward meshes, for every wavelet, with and without sharp edges:
//! exact round trips; local = full and nothing outside the support moves; undo and redo exact; the same for any
//! number of threads.

use bozzetto_core::edit::{Edit, Falloff, Gain, Kind, Move, Step, plan};
use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Level};
use bozzetto_core::mesh::{TriangleMesh, shapes};
use bozzetto_core::surface::{Form, Moved, Placement, Surface, SurfaceHash};
use bozzetto_core::wavelet::{Scheme, Wavelet};
use proptest::prelude::*;
use std::sync::Arc;

const FINEST: u8 = 3;

/// A surface with random vertices over a base mesh.
fn surface(mesh: &TriangleMesh, wavelet: Wavelet, sharp: usize, finest: u8, seed: u64) -> Surface {
    let marks: Vec<[u32; 2]> = mesh.faces.iter().take(sharp).map(|f| [f[0], f[1]]).collect();
    let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &marks).expect("a base mesh");
    let hierarchy = Hierarchy::new(Arc::new(base), Level(finest)).expect("small");
    let count = hierarchy.layout(Level(finest)).len();
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 39) as i32 - (1 << 24)
    };
    let finest: Vec<[i32; 3]> = (0..count).map(|_| std::array::from_fn(|_| next())).collect();
    let placement = Placement {
        origin: [0.0; 3],
        step: 1.0 / f64::from(1 << 24),
        up: Default::default(),
        unit: String::new(),
    };
    let form = Form { scheme: Scheme::Linear, wavelet, precision: 24, placement };
    Surface::from_finest(hierarchy, form, finest).expect("small valences")
}

/// Everything a surface holds, for comparison bit for bit.
fn contents(surface: &Surface) -> Vec<Vec<[i32; 3]>> {
    let levels = (0..=surface.finest().0).map(Level);
    let details = (0..surface.finest().0).map(Level);
    levels.map(|j| surface.scaling(j).to_vec()).chain(details.map(|j| surface.wavelets(j).to_vec())).collect()
}

/// The whole transform agrees with what the surface holds, in both directions, and so does the sum behind its hash.
fn assert_consistent(surface: &Surface, what: &str) {
    let finest = surface.scaling(surface.finest()).to_vec();
    let hierarchy = surface.hierarchy().as_ref().clone();
    let analysed =
        Surface::from_finest(hierarchy.clone(), surface.form().clone(), finest).expect("as before");
    assert!(contents(&analysed) == contents(surface), "{what}: full analysis differs");
    let coarsest = surface.scaling(Level::BASE).to_vec();
    let details = (0..surface.finest().0).map(|j| surface.wavelets(Level(j)).to_vec()).collect();
    let synthesised =
        Surface::from_coefficients(hierarchy, surface.form().clone(), coarsest, details).expect("as before");
    assert!(contents(&synthesised) == contents(surface), "{what}: full synthesis differs");
    assert_eq!(synthesised.hash(), surface.hash(), "{what}: running hash differs from the full one");
}

/// An edit by proportions, so that shrinking stays meaningful on every mesh.
#[derive(Debug, Clone)]
struct Draw {
    kind: Kind,
    level: f64,
    vertex: f64,
    delta: [f64; 3],
    radius: Option<f64>,
    falloff: Falloff,
    gain: Option<f64>,
}

fn draw() -> impl Strategy<Value = Draw> {
    let falloff = prop_oneof![
        Just(Falloff::Smooth),
        Just(Falloff::Linear),
        Just(Falloff::Sharp),
        Just(Falloff::Constant)
    ];
    (
        prop_oneof![Just(Kind::Scaling), Just(Kind::Wavelet)],
        0.0..1.0f64,
        0.0..1.0f64,
        prop::array::uniform3(-0.5..0.5f64),
        prop::option::of(0.01..1.5f64),
        falloff,
        prop::option::weighted(0.15, -1.5..1.5f64),
    )
        .prop_map(|(kind, level, vertex, delta, radius, falloff, gain)| Draw {
            kind,
            level,
            vertex,
            delta,
            radius,
            falloff,
            gain,
        })
}

fn edit_for(surface: &Surface, draw: &Draw) -> Edit {
    let finest = f64::from(surface.finest().0);
    if let Some(factor) = draw.gain {
        return Edit::Gain(Gain { level: (draw.level * finest) as u8, factor, v: 1 });
    }
    let (levels, kind) = match draw.kind {
        Kind::Scaling => (finest + 1.0, Kind::Scaling),
        Kind::Wavelet => (finest, Kind::Wavelet),
    };
    let level = (draw.level * levels) as u8;
    let layout = surface.hierarchy().layout(Level(level));
    let vertex = match kind {
        Kind::Scaling => (draw.vertex * f64::from(layout.len())) as u32,
        Kind::Wavelet => layout.len() + (draw.vertex * f64::from(layout.odd_len())) as u32,
    };
    let falloff = draw.radius.map(|_| draw.falloff);
    Edit::Move(Move {
        kind,
        level,
        vertex,
        delta: draw.delta,
        radius: draw.radius,
        falloff,
        mirror: None,
        v: 1,
    })
}

/// Whatever the surface reports as unmoved has not moved.
fn assert_report(before: &Surface, after: &Surface, moved: &[Moved], what: &str) {
    for (j, moved) in moved.iter().enumerate() {
        let level = Level(j as u8);
        let mut reported = vec![matches!(moved, Moved::Everything); before.scaling(level).len()];
        if let Moved::Some(runs) = moved {
            for slot in runs.slots() {
                reported[slot.index()] = true;
            }
        }
        for (slot, reported) in reported.iter().enumerate() {
            let same = before.scaling(level)[slot] == after.scaling(level)[slot];
            assert!(same || *reported, "{what}: slot {slot} of level {level} moved unreported");
        }
    }
}

fn run(mesh: &TriangleMesh, name: &str, wavelet: Wavelet, sharp: usize, draws: &[Draw]) -> Vec<SurfaceHash> {
    let start = surface(mesh, wavelet, sharp, FINEST, 99);
    assert_consistent(&start, name);
    let mut surface = start.clone();
    let mut record = undo::Record::new();
    let mut hashes = vec![surface.hash()];
    let mut states = vec![contents(&surface)];
    for draw in draws {
        let edit = edit_for(&surface, draw);
        let before = surface.clone();
        let planned = plan(&surface, &edit).unwrap_or_else(|e| panic!("{name}: {edit:?}: {e}"));
        let (step, changes) =
            Step::apply(&mut surface, edit.clone(), planned).expect("moves of half a unit stay in range");
        record.edit(&mut surface, step);
        let what = format!("{name}, {wavelet}, {sharp} sharp, {edit:?}");
        assert_report(&before, &surface, &changes.moved, &what);
        assert_consistent(&surface, &what);
        hashes.push(surface.hash());
        states.push(contents(&surface));
    }
    for at in (0..draws.len()).rev() {
        record.undo(&mut surface).expect("an edit to undo");
        assert_eq!(surface.hash(), hashes[at], "{name}: undo to {at}");
        assert!(contents(&surface) == states[at], "{name}: undo to {at}");
    }
    for (at, state) in states.iter().enumerate().skip(1) {
        record.redo(&mut surface).expect("an edit to redo");
        assert!(contents(&surface) == *state, "{name}: redo to {at}");
    }
    hashes
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 6, max_shrink_iters: 60, ..ProptestConfig::default() })]

    #[test]
    fn edits_are_local_exact_and_undoable(draws in prop::collection::vec(draw(), 1..6), sharp in 0usize..3) {
        for (name, mesh) in shapes::awkward() {
            for wavelet in Wavelet::ALL {
                run(&mesh, name, wavelet, sharp, &draws);
            }
        }
    }

    #[test]
    fn threads_do_not_matter(draws in prop::collection::vec(draw(), 1..4)) {
        for (name, mesh) in shapes::awkward().into_iter().take(7) {
            let with = |threads| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a thread pool");
                pool.install(|| run(&mesh, name, Wavelet::Disc(2), 0, &draws))
            };
            let one = with(1);
            prop_assert_eq!(&one, &with(2), "2 threads, {}", name);
            prop_assert_eq!(&one, &with(7), "7 threads, {}", name);
        }
    }
}

/// Levels fine enough for the constant stencil, where local paths cross from explicit rows to lattice arithmetic.
#[test]
fn deep_edits_are_local_and_exact() {
    for (name, mesh) in shapes::awkward() {
        if mesh.faces.len() > 30 {
            continue;
        }
        for (wavelet, sharp) in [(Wavelet::Disc(2), 0), (Wavelet::Disc(1), 1), (Wavelet::Disc(0), 0)] {
            let mut surface = surface(&mesh, wavelet, sharp, 6, 5);
            let start = contents(&surface);
            for (kind, level, radius) in [
                (Kind::Scaling, 6, None),
                (Kind::Scaling, 5, Some(0.4)),
                (Kind::Scaling, 2, None),
                (Kind::Wavelet, 5, Some(0.3)),
                (Kind::Wavelet, 4, None),
            ] {
                let layout = surface.hierarchy().layout(Level(level));
                let vertex = match kind {
                    Kind::Scaling => layout.len() - 3,
                    Kind::Wavelet => layout.len() + layout.odd_len() / 2,
                };
                let edit = Edit::Move(Move {
                    kind,
                    level,
                    vertex,
                    delta: [0.1, -0.2, 0.05],
                    radius,
                    falloff: None,
                    mirror: None,
                    v: 1,
                });
                let planned = plan(&surface, &edit).expect("a valid edit");
                let (mut step, _) = Step::apply(&mut surface, edit.clone(), planned).expect("in range");
                assert_consistent(&surface, &format!("{name}, {wavelet}, {edit:?}"));
                undo::Edit::undo(&mut step, &mut surface);
                assert!(contents(&surface) == start, "{name}, {wavelet}, {edit:?}: undo");
            }
        }
    }
}

/// One hash per golden surface: over debug and release, any number of threads, any machine. These never change.
#[test]
fn golden_hashes() {
    let golden = |name: &str, wavelet| {
        let (_, mesh) = shapes::awkward().into_iter().find(|(n, _)| *n == name).expect("a known mesh");
        surface(&mesh, wavelet, 1, 5, 2026).hash().to_string()
    };
    let found: Vec<String> = [
        ("octahedron", Wavelet::Lazy),
        ("octahedron", Wavelet::Disc(2)),
        ("genus 2", Wavelet::Disc(1)),
        ("open disc", Wavelet::Disc(2)),
        ("two components", Wavelet::Disc(0)),
        ("regular torus", Wavelet::Disc(2)),
    ]
    .map(|(name, wavelet)| format!("{name}, {wavelet}: {}", golden(name, wavelet)))
    .to_vec();
    let expected: Vec<&str> = include_str!("golden_hashes.txt").lines().collect();
    assert_eq!(found, expected, "found:\n{}", found.join("\n"));
}
