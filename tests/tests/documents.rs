//! Files that would be lost: by a name that is taken, and by a window that closes while a worker has the surface.

mod window;

use bozzetto::editor::{Editor, Start};
use bozzetto_core::disk::Disk;
use bozzetto_core::edit::{Edit, Kind, Pull, Spread};
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::session::Session;
use bozzetto_core::surface::Surface;
use eframe::egui::{Key, Modifiers, ViewportEvent, ViewportId};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::sync::Arc;
use window::{can_draw, editor, hash, save_as, session, settle, type_path};

#[test]
fn a_file_is_replaced_only_where_that_is_said() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let (own, other) = (folder.path().join("own.boz"), folder.path().join("other.boz"));
    std::fs::write(&other, "somebody's").expect("the folder can be written");
    let mut harness = editor(Start::sample().expect("the sample opens"));
    save_as(&mut harness, &own);
    harness.get_by_label("Save as").click();
    harness.run();
    // The ending is added, so the name is taken.
    type_path(&mut harness, &other.with_extension(""));
    assert!(harness.query_by_label("Save file").is_none());
    harness.key_press(Key::Enter);
    harness.run();
    assert_eq!(std::fs::read(&other).expect("there"), b"somebody's", "Enter replaces nothing");
    harness.get_by_label("Replace file").click();
    settle(&mut harness);
    assert_eq!(session(&harness).path(), Some(other.as_path()));
    assert_eq!(std::fs::read(&other).expect("there"), std::fs::read(&own).expect("there"));
}

/// Asks the window to close, as its frame does.
fn close(harness: &mut Harness<'_, Editor>) {
    let window = harness.input_mut().viewports.get_mut(&ViewportId::ROOT).expect("the window");
    window.events.push(ViewportEvent::Close);
    harness.run_steps(1);
    let window = harness.input_mut().viewports.get_mut(&ViewportId::ROOT).expect("the window");
    window.events.clear();
}

#[test]
fn a_window_closes_when_the_surface_is_back() {
    if !can_draw() {
        return;
    }
    let surface = Surface::ball(8, |_| 1.0);
    let mut session = Session::new(Arc::new(Disk), Model::new(surface, None, Metadata::default()));
    let pull = Pull {
        kind: Kind::Scaling,
        level: 0,
        vertex: Some(4),
        at: None,
        delta: [0.0, 0.5, 0.0],
        radius: None,
        falloff: None,
        spread: Spread::Smooth,
        follow: true,
        mirror: None,
        v: Pull::LATEST_VERSION,
    };
    session.edit(Edit::Pull(pull)).expect("a sensible pull");
    let mut harness = editor(Start::Session(Box::new(session)));
    let before = hash(&harness);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(1);
    assert!(harness.state().is_working(), "a worker undoes it");
    close(&mut harness);
    settle(&mut harness);
    // Something was done and undone, and no file has it: the question comes, with the surface.
    assert_ne!(hash(&harness), before);
    harness.get_by_label("Close with unsaved edits?");
}
