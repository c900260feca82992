//! Steps of the history that move more than can follow at once: seen on a coarser level first, done away from the window, and
//! never lost.

mod window;

use bozzetto::editor::{Document, Editor, Start};
use bozzetto_core::disk::Disk;
use bozzetto_core::edit::{Edit, Kind, Pull};
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::session::Session;
use bozzetto_core::surface::Surface;
use eframe::egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::sync::Arc;
use window::{can_draw, differing, editor, hash, settle};

/// A ball of 262146 vertices, pulled twice.
fn pulled() -> Session {
    let surface = Surface::ball(8, |[x, y, _]| 1.0 + 0.05 * (9.0 * x).sin() * (9.0 * y).sin());
    let mut session = Session::new(Arc::new(Disk), Model::new(surface, None, Metadata::default()));
    for (follow, delta) in [(false, [0.0, 0.0, 0.6]), (true, [0.0, 0.5, 0.0])] {
        let pull = Pull { follow, ..Pull::of(Kind::Scaling, 0, 4, delta) };
        session.edit(Edit::Pull(pull)).expect("a sensible pull");
    }
    session
}

fn press(harness: &mut Harness<'_, Editor>, modifiers: Modifiers) {
    harness.key_press_modifiers(modifiers, Key::Z);
    harness.run_steps(1);
    if harness.state().is_working() {
        let says = "is shown until all levels have followed";
        assert!(harness.state().document().is_none() || harness.query_by_label_contains(says).is_some());
    }
}

/// Undone and redone, also faster than it can be done, everything comes back, and so does the picture.
#[test]
fn large_steps_come_back_however_fast_they_are_asked_for() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::Session(Box::new(pulled())));
    let last = hash(&harness);
    let steps = |harness: &Harness<'_, Editor>| harness.state().document().expect("open").session.steps();
    let pulled = harness.render().expect("a picture");
    let back = Modifiers::COMMAND;
    for _ in 0..2 {
        press(&mut harness, back);
    }
    settle(&mut harness);
    assert_eq!(steps(&harness), 0, "both are undone");
    let document = harness.state().document().expect("open");
    assert_eq!(hash(&harness), document.session.original_hash());
    let fresh = Session::new(Arc::new(Disk), document.session.model().clone());
    let fresh = Document::new(fresh, document.vertices().level());
    assert!(document.vertices().positions() == fresh.vertices().positions(), "what is shown has followed");
    assert!(document.vertices().normals() == fresh.vertices().normals(), "its normals too");
    let anew = harness.render().expect("a picture");
    assert!(differing(&harness, &pulled, &anew) >= 200, "it is seen");
    for _ in 0..2 {
        press(&mut harness, back | Modifiers::SHIFT);
    }
    settle(&mut harness);
    assert_eq!((steps(&harness), hash(&harness)), (2, last), "both are redone");
    assert_eq!(harness.state().document().expect("open").preview(), None);
    let again = harness.render().expect("a picture");
    assert_eq!(differing(&harness, &pulled, &again), 0, "the picture is as before");
}
