//! The editor, driven through its widgets and its picture on the software GPU.

mod window;

use bozzetto::editor::{Editor, Start, Target};
use bozzetto_core::disk::Disk;
use bozzetto_core::edit::{Edit, Kind, Move};
use bozzetto_core::hierarchy::{Level, PublicId};
use bozzetto_core::session::{OpenOptions, Session, open_model};
use bozzetto_core::surface::SurfaceHash;
use eframe::egui::{self, Event, Key, Modifiers, PointerButton, Pos2, Vec2};
use egui_kittest::SnapshotOptions;
use egui_kittest::kittest::Queryable;
use glam::{DVec2, DVec3};
use std::path::Path;
use std::sync::Arc;
use window::{
    button, can_draw, drag, editor, hash, redo, release, save_as, session, settle, type_path, undo,
};

fn points(v: Vec2) -> DVec2 {
    DVec2::new(f64::from(v.x), f64::from(v.y))
}

/// Where a point of drawing space is in the window.
fn on_screen(editor: &Editor, point: DVec3) -> DVec2 {
    let picture = editor.picture();
    let pixel = editor.camera().project(point, points(picture.size())).expect("in front of the eye");
    pixel + points(picture.min.to_vec2())
}

/// The coefficient that looks most straight at the eye.
fn facing(editor: &Editor, kind: Kind, level: u8) -> Target {
    let document = editor.document().expect("a surface is open");
    let layout = document.surface().hierarchy().layout(Level(level));
    let ids = match kind {
        Kind::Scaling => 0..layout.len(),
        Kind::Wavelet => layout.len()..layout.len() + layout.odd_len(),
    };
    let towards_eye = |t: &Target| t.normal.dot((editor.camera().eye() - t.position).normalize());
    ids.filter_map(|id| document.target(kind, Level(level), PublicId(id)))
        .filter(|t| {
            // Seen, and itself the nearest coefficient where it is seen.
            let pixel = on_screen(editor, t.position) - points(editor.picture().min.to_vec2());
            let ray = editor.camera().ray(pixel, points(editor.picture().size()));
            document.pick(&ray).is_some_and(|hit| {
                (hit.point - t.position).length() < 1e-3
                    && document.target_at(&hit, kind, Level(level)).vertex == t.vertex
            })
        })
        .max_by(|a, b| towards_eye(a).total_cmp(&towards_eye(b)))
        .expect("some coefficient faces the eye")
}

/// The delta that keeps the surface under the cursor, from pixels and camera alone.
fn expected_delta(editor: &Editor, target: &Target, from: Pos2, to: Pos2) -> [f64; 3] {
    let picture = points(editor.picture().size());
    let at = |p: Pos2| points(p - editor.picture().min);
    let grip = at(from) - editor.camera().project(target.position, picture).expect("in front of the eye");
    let moved = editor.camera().unproject(at(to) - grip, target.position, picture) - target.position;
    (moved / target.peak).to_array()
}

/// Replays one move onto the baked-free wavelet file and gives the hash.
fn replayed(path: &Path, edit: Move) -> SurfaceHash {
    let base = OpenOptions { log: bozzetto_core::session::LogUse::Ignored, rebind: false };
    let (model, _) = open_model(&Disk, path, base).expect("the file opens");
    let mut session = Session::new(Arc::new(Disk), model);
    session.edit(Edit::Move(edit)).expect("the edit is accepted");
    session.hash()
}

fn drag_undo_save_reopen(kind: Kind) {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("dragged.boz");
    let mut harness = editor(Start::sample().expect("the sample opens"));
    let original = hash(&harness);
    save_as(&mut harness, &path);
    assert_eq!(hash(&harness), original, "saving changes nothing");

    // The paper's coefficient as it is.
    harness.get_by_label("Raw").click();
    harness.get_by_label("detail follows").click();
    harness.run();
    if kind == Kind::Wavelet {
        harness.get_by_label("Wavelet").click();
    }
    harness.get_by_label("Edit level 2").click();
    harness.run();
    assert_eq!(harness.state().settings().level, Level(2));
    let target = facing(harness.state(), kind, 2);
    let at = on_screen(harness.state(), target.position);
    let from = egui::pos2(at.x as f32, at.y as f32);
    let to = from + egui::vec2(37.0, -23.0);
    let delta = expected_delta(harness.state(), &target, from, to);
    drag(&mut harness, from, to, Modifiers::NONE);

    let now =
        harness.state().document().expect("open").target(kind, Level(2), target.vertex).expect("still there");
    let stray = (on_screen(harness.state(), now.position) - points(to.to_vec2())).length();
    assert!(stray < 1.0, "the vertex is {stray} px from the pointer");
    // A hand that goes on within the frame of the release no longer drags.
    harness.input_mut().events.extend([
        button(false, to, PointerButton::Primary, Modifiers::NONE),
        Event::PointerMoved(to + egui::vec2(150.0, 60.0)),
    ]);
    harness.run_steps(1);
    harness.run();

    let now =
        harness.state().document().expect("open").target(kind, Level(2), target.vertex).expect("still there");
    let stray = (on_screen(harness.state(), now.position) - points(to.to_vec2())).length();
    assert!(stray < 1.0, "after the release the vertex is {stray} px from where the pointer let go");
    let dragged = hash(&harness);
    assert_ne!(dragged, original);
    let edit = Move {
        kind,
        level: 2,
        vertex: target.vertex.0,
        delta,
        radius: None,
        falloff: None,
        mirror: None,
        v: 1,
    };
    assert_eq!(dragged, replayed(&path, edit), "the drag is the line that pixels and camera give");

    undo(&mut harness);
    assert_eq!(hash(&harness), original, "undo");
    redo(&mut harness);
    assert_eq!(hash(&harness), dragged, "redo");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::S);
    settle(&mut harness);
    assert!(!session(&harness).is_unsaved());
    drop(harness);

    let reopened = editor(Start::File(path));
    assert_eq!(hash(&reopened), dragged, "reopened");
    assert_eq!(session(&reopened).steps(), 1, "the history is there");
}

#[test]
fn a_scaling_coefficient_dragged_undone_saved_and_reopened() {
    drag_undo_save_reopen(Kind::Scaling);
}

#[test]
fn a_wavelet_coefficient_dragged_undone_saved_and_reopened() {
    drag_undo_save_reopen(Kind::Wavelet);
}

#[test]
fn escape_restores_every_bit_and_leaves_no_step() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    let original = hash(&harness);
    let target = facing(harness.state(), Kind::Scaling, 1);
    let at = on_screen(harness.state(), target.position);
    let from = egui::pos2(at.x as f32, at.y as f32);
    drag(&mut harness, from, from + egui::vec2(60.0, 20.0), Modifiers::NONE);
    assert_ne!(hash(&harness), original);
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert_eq!(hash(&harness), original);
    release(&mut harness, from);
    assert_eq!(session(&harness).history_len(), 0);
}

#[test]
fn levels_clamp_visibly_and_change_nothing() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    let original = hash(&harness);
    let finest = harness.state().document().expect("open").surface().finest();
    harness.get_by_label(&format!("Edit level {finest}")).click();
    harness.run();
    harness.get_by_label("Wavelet").click();
    harness.run();
    assert_eq!(harness.state().settings().level, Level(finest.0 - 1));
    assert!(harness.state().message().is_some_and(|(text, failed)| text.contains("end at level") && !failed));
    for shown in [0, 3, finest.0] {
        harness.get_by_label(&format!("Show level {shown}")).click();
        harness.run();
        assert_eq!(hash(&harness), original);
    }
}

#[test]
fn a_bad_file_is_a_sentence_in_the_window() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("junk.boz");
    std::fs::write(&path, b"not a wavelet file").expect("written");
    let mut harness = editor(Start::sample().expect("the sample opens"));
    let original = hash(&harness);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::O);
    harness.run();
    type_path(&mut harness, &path);
    harness.get_by_label("Open file").click();
    settle(&mut harness);
    let (text, failed) = harness.state().message().expect("a message");
    assert!(failed && text.contains("junk.boz") && text.contains("not a Bozzetto wavelet file"), "{text}");
    assert_eq!(hash(&harness), original, "the open surface stays");
}

#[test]
fn an_idle_window_does_not_repaint() {
    if !can_draw() {
        return;
    }
    let harness = editor(Start::sample().expect("the sample opens"));
    let delay = harness.output().viewport_output[&egui::ViewportId::ROOT].repaint_delay;
    assert!(delay > std::time::Duration::from_secs(5), "the next repaint is due in {delay:?}");
}

#[test]
fn pictures_of_the_window() {
    if !can_draw() {
        return;
    }
    // Rasterisers of different Mesa versions differ along edges.
    let options = SnapshotOptions::new().threshold(2.0).max_failed_pixels(6000);
    let mut harness = editor(Start::sample().expect("the sample opens"));
    harness.snapshot_options("window_sample", &options);
    harness.get_by_label("Wavelet").click();
    harness.get_by_label("Edit level 2").click();
    harness.run();
    let target = facing(harness.state(), Kind::Wavelet, 2);
    let at = on_screen(harness.state(), target.position);
    let from = egui::pos2(at.x as f32, at.y as f32);
    drag(&mut harness, from, from + egui::vec2(30.0, -40.0), Modifiers::NONE);
    release(&mut harness, from + egui::vec2(30.0, -40.0));
    harness.remove_cursor();
    harness.run();
    harness.snapshot_options("window_wavelet", &options);
}
