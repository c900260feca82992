//! Moves with mirrors: single coefficients move with their partners, as one line, exact and undone like every edit.

mod memory_disk;
mod samples;

use bozzetto_core::edit::{Edit, EditError, Kind, Mirror, Move, Step, plan};
use bozzetto_core::hierarchy::{Level, Slot};
use bozzetto_core::mesh::shapes;
use bozzetto_core::surface::Surface;
use bozzetto_core::wavelet::Wavelet;
use memory_disk::session_of;
use samples::{Numbers, assert_consistent, contents, draw_move, surface};

/// Across x = 0, which an octahedron's ball is symmetric to.
const PLANE: Mirror = Mirror { x: Some(0.0), y: None, z: None };

fn moved(kind: Kind, level: u8, vertex: u32, delta: [f64; 3]) -> Move {
    Move { kind, level, vertex, delta, radius: None, falloff: None, mirror: Some(PLANE), v: 2 }
}

/// How far from the surface the mirror image of a vertex lies at most, in model units.
fn asymmetry(surface: &Surface) -> f64 {
    let placement = &surface.form().placement;
    let finest = surface.finest();
    let of_vertex = |slot: u32| {
        let [x, y, z] = surface.position(finest, Slot(slot));
        let image = [-x, y, z];
        let near =
            surface.nearest(std::array::from_fn(|c| (image[c] - placement.origin[c]) / placement.step));
        near.squared_distance.sqrt() * placement.step
    };
    (0..surface.scaling(finest).len() as u32).map(of_vertex).fold(0.0, f64::max)
}

#[test]
fn a_coefficient_moves_with_its_mirror_image() {
    for (kind, level, radius) in
        [(Kind::Wavelet, 1, None), (Kind::Wavelet, 2, Some(0.3)), (Kind::Scaling, 2, None)]
    {
        let mut session = session_of(Surface::ball(4, |_| 1.0));
        let layout = session.surface().hierarchy().layout(Level(level)).clone();
        let first = if kind == Kind::Wavelet { layout.len() } else { 0 };
        let before = session.hash();
        // A vertex off the plane.
        let finer = if kind == Kind::Wavelet { Level(level).finer() } else { Level(level) };
        let fine = session.surface().hierarchy().layout(finer).clone();
        let off = |&vertex: &u32| {
            let slot = fine.slot(fine.site_of(bozzetto_core::hierarchy::PublicId(vertex)));
            let fine = session.surface().hierarchy().refine_slot(finer, Level(4), slot);
            session.surface().position(Level(4), fine)[0].abs() > 0.4
        };
        let vertex = (first..first + 20).find(off).expect("most are");
        let edit = Move { radius, ..moved(kind, level, vertex, [0.03, 0.08, -0.05]) };
        assert_eq!(session.begin_stroke(edit).expect("sensible"), 0, "{kind}: it has a partner");
        session.drag_to(edit.delta).expect("in range");
        session.end_stroke();
        let live = session.hash();
        assert!(asymmetry(session.surface()) < 2e-3, "{kind}: {}", asymmetry(session.surface()));
        session.undo();
        assert_eq!(session.hash(), before);
        session.edit(Edit::Move(edit)).expect("sensible");
        assert_eq!(session.hash(), live, "{kind}: the line says the same");
        session.undo();
        session.edit(Edit::Move(Move { mirror: None, ..edit })).expect("sensible");
        assert!(asymmetry(session.surface()) > 1e-2, "{kind}: alone it is seen");
    }
}

#[test]
fn without_a_partner_a_coefficient_moves_alone_and_that_is_told() {
    let mut session = session_of(Surface::ball(4, |_| 1.0));
    let first = session.surface().hierarchy().layout(Level(1)).len();
    let off = Mirror { x: Some(0.83), y: None, z: None };
    let edit = Move { mirror: Some(off), ..moved(Kind::Wavelet, 1, first + 3, [0.0, 0.1, 0.0]) };
    assert_eq!(session.begin_stroke(edit).expect("sensible"), 1);
    session.drag_to(edit.delta).expect("in range");
    session.end_stroke();
    let mirrored = session.hash();
    session.undo();
    session.edit(Edit::Move(Move { mirror: None, v: 1, ..edit })).expect("sensible");
    assert_eq!(session.hash(), mirrored);
}

#[test]
fn mirrored_moves_are_whole_and_undone_exactly_on_awkward_meshes() {
    for (name, mesh) in shapes::awkward() {
        let mut surface = surface(&mesh, Wavelet::Disc(2), 1, 3, 7);
        let mut numbers = Numbers(3 + mesh.faces.len() as u64);
        let origin = surface.form().placement.origin;
        for _ in 0..6 {
            let mirror =
                Mirror { x: Some(origin[0]), y: None, z: (numbers.below(2) == 0).then_some(origin[2]) };
            let edit = Move { mirror: Some(mirror), v: 2, ..draw_move(&mut numbers, &surface) };
            let before = contents(&surface);
            let planned =
                plan(&surface, &Edit::Move(edit)).unwrap_or_else(|e| panic!("{name}: {edit:?}: {e}"));
            match Step::apply(&mut surface, Edit::Move(edit), planned) {
                Ok((mut step, _)) => {
                    assert_consistent(&surface);
                    undo::Edit::undo(&mut step, &mut surface);
                    assert!(contents(&surface) == before, "{name}: undo of {edit:?}");
                    let _ = undo::Edit::edit(&mut step, &mut surface);
                    undo::Edit::edit(&mut step, &mut surface);
                }
                Err(EditError::BeyondLimit) => assert!(contents(&surface) == before, "{name}: {edit:?}"),
                Err(error) => panic!("{name}: {edit:?}: {error}"),
            }
        }
    }
}

#[test]
fn mirrors_without_sense_are_refused() {
    let mut session = session_of(Surface::ball(3, |_| 1.0));
    let good = moved(Kind::Wavelet, 1, 20, [0.0, 0.1, 0.0]);
    let nowhere = Mirror { x: Some(f64::NAN), y: None, z: None };
    for bad in [Move { v: 1, ..good }, Move { v: 3, ..good }, Move { mirror: Some(nowhere), ..good }] {
        assert!(session.edit(Edit::Move(bad)).is_err(), "{bad:?}");
        assert_eq!(session.history_len(), 0);
    }
    session.edit(Edit::Move(good)).expect("the one that is fine");
}
