//! The tools in the window: every one changes the surface, the mask or the picture, and its log plays the same bits.

mod window;

use bozzetto::editor::{Editor, Hand, RecordedPen, Start};
use bozzetto_core::conversion::{ConversionOptions, convert};
use bozzetto_core::disk::Disk;
use bozzetto_core::edit::{Edit, Stroke, Tool};
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::mesh::shapes;
use bozzetto_core::session::{OpenOptions, Session, open_model};
use bozzetto_core::surface::{FormOptions, Surface};
use eframe::egui::{self, Event, Key, Modifiers, PointerButton};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use std::sync::Arc;
use window::{
    assert_replays, button, can_draw, differing, differing_where, drag, editor, hash, last, middle, picture,
    redo, release, save_as, session, settle, stroke, take, undo,
};

fn last_stroke(harness: &Harness<'_, Editor>) -> Stroke {
    match last(harness) {
        Edit::Stroke(stroke) => stroke,
        other => panic!("{other}"),
    }
}

#[test]
fn every_brush_changes_the_surface_and_is_undone() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    harness.get_by_label("Edit level 4").click();
    harness.run();
    for tool in Tool::ALL {
        take(&mut harness, tool.name());
        assert_eq!(harness.state().settings().hand, Hand::Brush(tool));
        let before = hash(&harness);
        if tool == Tool::Copy {
            // Where it comes from is chosen with Alt.
            let from = middle(&harness) + egui::vec2(40.0, -90.0);
            drag(&mut harness, from, from, Modifiers::ALT);
            release(&mut harness, from);
        }
        stroke(&mut harness, Modifiers::NONE);
        let made = last_stroke(&harness);
        assert_eq!((made.tool, made.level), (tool, 4), "{:?}", harness.state().message());
        assert!(made.dabs.len() >= 2, "{tool:?}: {} dabs", made.dabs.len());
        if tool == Tool::Mask {
            let mask = harness.state().document().expect("open").surface().mask().clone();
            assert!(mask.values().iter().any(|&m| m > 60), "something is masked");
            assert_eq!(hash(&harness), before, "the mask is no part of the surface");
            continue;
        }
        let after = hash(&harness);
        assert_ne!(after, before, "{tool:?}");
        undo(&mut harness);
        assert_eq!(hash(&harness), before, "{tool:?}: undo");
        redo(&mut harness);
        assert_eq!(hash(&harness), after, "{tool:?}: redo");
    }
    assert_replays(&harness);
}

#[test]
fn a_mask_keeps_brushes_off_and_is_seen_and_cleared() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    harness.get_by_label("Edit level 5").click();
    let plain = harness.render().expect("a picture");
    take(&mut harness, "Mask");
    for _ in 0..6 {
        stroke(&mut harness, Modifiers::NONE);
    }
    let masked = picture(&mut harness);
    let seen = differing(&harness, &plain, &masked);
    assert!(seen >= 200, "the mask is seen: {seen} pixels");
    let document = harness.state().document().expect("open");
    let surface = document.surface();
    let kept: Vec<usize> =
        surface.mask().values().iter().enumerate().filter(|(_, m)| **m == 255).map(|(at, _)| at).collect();
    assert!(kept.len() > 10, "{} vertices are fully masked", kept.len());
    let before: Vec<[i32; 3]> = kept.iter().map(|&at| surface.scaling(surface.finest())[at]).collect();
    take(&mut harness, "Inflate");
    stroke(&mut harness, Modifiers::NONE);
    let surface = harness.state().document().expect("open").surface();
    let moved = kept.iter().zip(&before).filter(|(at, old)| surface.scaling(surface.finest())[**at] != **old);
    // Level 5 vertices that are masked stay; finer ones between a masked and a free one may follow.
    assert!(moved.count() < kept.len() / 2, "what is masked stays");
    harness.get_by_label("Clear mask").click();
    settle(&mut harness);
    let values = harness.state().document().expect("open").surface().mask().values().to_vec();
    assert!(values.iter().all(|&m| m == 0), "cleared");
    assert_replays(&harness);
}

#[test]
fn shift_smooths_ctrl_inverts_and_escape_cancels() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    take(&mut harness, "Draw");
    stroke(&mut harness, Modifiers::SHIFT);
    assert_eq!(last_stroke(&harness).tool, Tool::Smooth);
    stroke(&mut harness, Modifiers::CTRL);
    let inverted = last_stroke(&harness);
    assert!(inverted.tool == Tool::Draw && inverted.strength < 0.0, "{inverted:?}");
    let (before, steps) = (hash(&harness), session(&harness).history_len());
    let from = middle(&harness);
    drag(&mut harness, from, from + egui::vec2(60.0, 10.0), Modifiers::NONE);
    let stroking = session(&harness).brush_words().cloned();
    assert!(stroking.is_some_and(|words| words.dabs.len() >= 2), "a stroke is under way");
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert_eq!(hash(&harness), before, "every bit is back");
    release(&mut harness, from);
    assert_eq!(session(&harness).history_len(), steps, "and no step is left");
}

#[test]
fn symmetry_mirrors_the_stroke_in_space() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    take(&mut harness, "Inflate");
    stroke(&mut harness, Modifiers::NONE);
    let alone = hash(&harness);
    undo(&mut harness);
    harness.key_press(Key::X);
    harness.run();
    assert_eq!(harness.state().settings().symmetry, [true, false, false]);
    stroke(&mut harness, Modifiers::NONE);
    assert_ne!(hash(&harness), alone);
    let mirror = last_stroke(&harness).mirror.expect("a mirror");
    assert!(mirror.x.is_some() && mirror.y.is_none() && mirror.z.is_none());
    harness.key_press(Key::X);
    harness.key_press(Key::Z);
    harness.run();
    assert_eq!(harness.state().settings().symmetry, [false, false, true]);
    assert_replays(&harness);
}

#[test]
fn radius_and_strength_are_chosen_by_moving_and_by_keys() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    take(&mut harness, "Draw");
    let at = middle(&harness);
    harness.event(Event::PointerMoved(at));
    harness.run_steps(2);
    let before = harness.state().settings().clone();
    let seen = harness.render().expect("a picture");
    harness.key_press(Key::F);
    harness.run_steps(2);
    harness.event(Event::PointerMoved(at + egui::vec2(120.0, 0.0)));
    harness.run_steps(2);
    let radius = harness.state().settings().brush_radius;
    assert!((radius / before.brush_radius - 2.0).abs() < 0.05, "{radius}");
    let larger = harness.render().expect("a picture");
    let grown = differing_where(&seen, &larger, |_| true);
    assert!(grown >= 200, "the ring grows: {grown} pixels");
    harness.key_press(Key::Escape);
    harness.run_steps(2);
    assert_eq!(harness.state().settings().brush_radius, before.brush_radius, "Esc takes it back");
    harness.event(Event::PointerMoved(at));
    harness.key_press_modifiers(Modifiers::SHIFT, Key::F);
    harness.run_steps(2);
    harness.event(Event::PointerMoved(at + egui::vec2(60.0, 0.0)));
    harness.run_steps(2);
    let pos = at + egui::vec2(60.0, 0.0);
    harness.event(button(true, pos, PointerButton::Primary, Modifiers::NONE));
    harness.event(button(false, pos, PointerButton::Primary, Modifiers::NONE));
    harness.run_steps(2);
    assert!((harness.state().settings().strength - before.strength - 0.25).abs() < 0.02, "a click keeps it");
    assert_eq!(session(&harness).history_len(), 0, "the click is no stroke");
    harness.key_press(Key::CloseBracket);
    harness.run();
    assert!(harness.state().settings().brush_radius > before.brush_radius * 1.1);
    harness.key_press(Key::OpenBracket);
    harness.key_press(Key::OpenBracket);
    harness.run();
    assert!(harness.state().settings().brush_radius < before.brush_radius);
}

#[test]
fn a_pen_presses_on_strength_and_radius() {
    if !can_draw() {
        return;
    }
    let hashes = [0.2, 1.0].map(|pressure| {
        let mut harness = editor(Start::sample().expect("the sample opens"));
        harness.state_mut().set_pen(Box::new(RecordedPen::new([pressure])));
        take(&mut harness, "Draw");
        harness.get_by_label("pressure: radius").click();
        harness.run();
        stroke(&mut harness, Modifiers::NONE);
        let dab = *last_stroke(&harness).dabs.last().expect("a dab");
        assert!((dab.strength - pressure).abs() < 0.01 && (dab.size - pressure).abs() < 0.01, "{dab:?}");
        assert_replays(&harness);
        hash(&harness)
    });
    assert_ne!(hashes[0], hashes[1]);
}

#[test]
fn the_radius_chooses_the_level_and_n_hides_the_inspector() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    take(&mut harness, "Draw");
    harness.get_by_label("auto level").click();
    harness.run();
    let (coarse, finest) = (harness.state().settings().level, harness.state().settings().shown);
    for _ in 0..16 {
        harness.key_press(Key::OpenBracket);
        harness.run();
    }
    let fine = harness.state().settings().level;
    assert!(fine > coarse && fine <= finest, "{coarse} then {fine}");
    stroke(&mut harness, Modifiers::NONE);
    assert_eq!(Level(last_stroke(&harness).level), fine, "a stroke acts there");
    let width = harness.state().picture().width();
    harness.key_press(Key::N);
    harness.run();
    assert!(harness.state().picture().width() > width + 200.0);
    harness.key_press(Key::N);
    harness.run();
    assert_eq!(harness.state().picture().width(), width);
}

#[test]
fn grab_and_smooth_handles_are_pulls_with_detail_that_follows() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("pulled.boz");
    let mut harness = editor(Start::sample().expect("the sample opens"));
    let before = hash(&harness);
    harness.key_press(Key::G);
    harness.run();
    assert_eq!(harness.state().settings().hand, Hand::Grab);
    stroke(&mut harness, Modifiers::NONE);
    let Edit::Pull(grab) = last(&harness) else { panic!("{}", last(&harness)) };
    assert!(grab.at.is_some() && grab.radius.is_some() && grab.follow, "{grab:?}");
    let grabbed = hash(&harness);
    assert_ne!(grabbed, before);
    harness.key_press(Key::H);
    harness.run();
    stroke(&mut harness, Modifiers::NONE);
    let Edit::Pull(handle) = last(&harness) else { panic!("{}", last(&harness)) };
    assert!(handle.vertex.is_some() && handle.follow, "{handle:?}");
    harness.get_by_label("detail follows").click();
    harness.get_by_label("Raw").click();
    harness.run();
    stroke(&mut harness, Modifiers::NONE);
    assert!(matches!(last(&harness), Edit::Move(_)), "raw and without following: the paper's coefficient");
    assert_replays(&harness);
    // The files say the same.
    let after = hash(&harness);
    save_as(&mut harness, &path);
    drop(harness);
    let (model, _) = open_model(&Disk, &path, OpenOptions::default()).expect("a sound pair");
    assert_eq!(Session::new(Arc::new(Disk), model).hash(), after);
}

/// A brush within one triangle of its level still moves what it touches, and that is seen.
#[test]
fn a_brush_smaller_than_the_levels_triangles_moves_what_it_touches() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    take(&mut harness, "Draw");
    harness.get_by_label("Edit level 0").click();
    harness.run();
    for _ in 0..8 {
        harness.key_press(Key::OpenBracket);
        harness.run();
    }
    let vertices = harness.state().document().expect("open").surface().scaling(Level::BASE).len();
    let spacing = (4.0 * std::f64::consts::PI / vertices as f64).sqrt();
    let radius = harness.state().settings().brush_radius;
    assert!(radius < 0.5 * spacing, "{radius} of the model's radius, triangles of {spacing}");
    let plain = picture(&mut harness);
    let before = hash(&harness);
    stroke(&mut harness, Modifiers::NONE);
    assert_eq!(last_stroke(&harness).level, 0);
    assert_ne!(hash(&harness), before);
    let after = picture(&mut harness);
    let seen = differing(&harness, &plain, &after);
    assert!(seen >= 200, "{seen} pixels");
    assert_replays(&harness);
}

/// A surface of 65538 vertices, without a file.
fn large() -> Session {
    let mesh = shapes::subdivide(&shapes::octahedron(), 7);
    let converted = convert(&mesh, &ConversionOptions::default()).expect("subdivided");
    let surface = Surface::from_positions(converted.hierarchy, &converted.positions, &FormOptions::default());
    Session::new(Arc::new(Disk), Model::new(surface.expect("small"), None, Metadata::default()))
}

/// The status bar says which level is seen while a drag moves more than can follow the hand.
#[test]
fn a_large_drag_shows_a_coarser_level_and_says_so() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::Session(Box::new(large())));
    harness.get_by_label("Edit level 0").click();
    harness.run();
    harness.key_press(Key::G);
    harness.run();
    let before = hash(&harness);
    let finest = harness.state().document().expect("open").surface().finest();
    let says = "shown until you let go";
    assert!(harness.query_by_label_contains(says).is_none());
    let to = middle(&harness) + egui::vec2(60.0, 30.0);
    let from = middle(&harness);
    drag(&mut harness, from, to, Modifiers::NONE);
    let preview = harness.state().document().expect("open").preview().expect("a large drag is previewed");
    assert!(preview < finest, "level {preview}");
    assert!(harness.query_by_label_contains(&format!("at level {preview}, {says}")).is_some());
    release(&mut harness, to);
    settle(&mut harness);
    assert_eq!(harness.state().document().expect("open").preview(), None);
    assert!(harness.query_by_label_contains(says).is_none());
    assert_ne!(hash(&harness), before);
    let mut fresh = large();
    fresh.edit(last(&harness)).expect("it was accepted before");
    assert_eq!(hash(&harness), fresh.hash());
}

#[test]
fn mouse_habits_of_other_programs() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    let at = middle(&harness);
    let turned = |harness: &mut Harness<'_, Editor>, which: PointerButton, modifiers: Modifiers| {
        let before = *harness.state().camera();
        harness.event(Event::ModifiersChanged(modifiers));
        harness.event(Event::PointerMoved(at));
        harness.run_steps(1);
        harness.event(button(true, at, which, modifiers));
        harness.run_steps(1);
        harness.event(Event::PointerMoved(at + egui::vec2(40.0, 30.0)));
        harness.run_steps(1);
        harness.event(button(false, at + egui::vec2(40.0, 30.0), which, modifiers));
        harness.event(Event::ModifiersChanged(Modifiers::NONE));
        harness.run_steps(2);
        let after = *harness.state().camera();
        let panned = (after.target - before.target).length() > 1e-6;
        (after.yaw != before.yaw, panned, after.distance != before.distance)
    };
    let (orbit, pan, zoom) = ((true, false, false), (false, true, false), (false, false, true));
    let (middle, right) = (PointerButton::Middle, PointerButton::Secondary);
    for (name, which, modifiers, expected) in [
        ("Blender", middle, Modifiers::NONE, orbit),
        ("Blender", middle, Modifiers::SHIFT, pan),
        ("Blender", right, Modifiers::NONE, pan),
        ("Maya", PointerButton::Primary, Modifiers::ALT, orbit),
        ("Maya", middle, Modifiers::ALT, pan),
        ("Maya", right, Modifiers::ALT, zoom),
        ("ZBrush", right, Modifiers::NONE, orbit),
        ("ZBrush", right, Modifiers::ALT, pan),
    ] {
        harness.get_by_label(name).click();
        harness.run();
        assert_eq!(turned(&mut harness, which, modifiers), expected, "{name}, {which:?}, {modifiers:?}");
    }
}

#[test]
fn the_last_stroke_is_framed() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    take(&mut harness, "Draw");
    stroke(&mut harness, Modifiers::NONE);
    let far = harness.state().camera().distance;
    harness.key_press(Key::Period);
    harness.run();
    assert!(harness.state().camera().distance < 0.6 * far, "nearer");
    harness.key_press(Key::Home);
    harness.run();
    assert!((harness.state().camera().distance / far - 1.0).abs() < 0.1, "all of it again");
}
