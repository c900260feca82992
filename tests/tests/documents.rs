//! Files that would be lost: by a name that is taken, and by a window that closes while a worker has the surface.

mod window;

use bozzetto::editor::{Editor, Start};
use bozzetto_core::disk::Disk;
use bozzetto_core::edit::{Edit, Kind, Pull};
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::session::Session;
use bozzetto_core::surface::Surface;
use eframe::egui::{self, Key, Modifiers, ViewportEvent, ViewportId};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::sync::Arc;
use window::{can_draw, drag, editor, hash, middle, release, save_as, session, settle, take, type_path};

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

/// A place to copy detail from is one of the surface that was open: another asks for its own.
#[test]
fn another_surface_has_no_place_to_copy_from() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let other = folder.path().join("other.boz");
    let mut harness = editor(Start::sample().expect("the sample opens"));
    save_as(&mut harness, &other);
    save_as(&mut harness, &folder.path().join("own.boz"));
    take(&mut harness, "Copy detail");
    let at = middle(&harness);
    drag(&mut harness, at, at, Modifiers::ALT);
    release(&mut harness, at);
    harness.get_by_label("Open").click();
    harness.run();
    type_path(&mut harness, &other);
    harness.get_by_label("Open file").click();
    settle(&mut harness);
    assert_eq!(session(&harness).path(), Some(other.as_path()));
    take(&mut harness, "Copy detail");
    drag(&mut harness, at, at + egui::vec2(40.0, 0.0), Modifiers::NONE);
    release(&mut harness, at);
    assert!(harness.state().message().is_some_and(|(text, _)| text.contains("Alt + click")));
    assert_eq!(session(&harness).history_len(), 0);
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
    let pull = Pull { follow: true, ..Pull::of(Kind::Scaling, 0, 4, [0.0, 0.5, 0.0]) };
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
