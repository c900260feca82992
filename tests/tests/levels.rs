//! The equaliser, changes of levels and hiding in the window: each changes the surface or the picture, is undone, and its
//! log plays the same bits.

mod window;

use bozzetto::editor::{Editor, Start};
use bozzetto_core::hierarchy::Level;
use eframe::egui::{self, Event, Modifiers, PointerButton, Pos2, Rect};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use window::{assert_replays, can_draw, editor, hash, settle};

fn press(harness: &mut Harness<'_, Editor>, pos: Pos2, pressed: bool) {
    let button = PointerButton::Primary;
    harness.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
    harness.run_steps(1);
}

fn drag(harness: &mut Harness<'_, Editor>, from: Pos2, to: Pos2) {
    harness.event(Event::PointerMoved(from));
    harness.run_steps(2);
    press(harness, from, true);
    for step in 1..=4 {
        harness.event(Event::PointerMoved(from + (to - from) * (step as f32 / 4.0)));
        harness.run_steps(1);
    }
    press(harness, to, false);
    harness.run();
}

fn click(harness: &mut Harness<'_, Editor>, label: &str) {
    harness.get_by_label(label).scroll_to_me();
    harness.run();
    harness.get_by_label(label).click();
    settle(harness);
}

/// Pixels of the picture that differ between two renderings.
fn differing(harness: &Harness<'_, Editor>, a: &image::RgbaImage, b: &image::RgbaImage) -> usize {
    let picture = harness.state().picture();
    a.enumerate_pixels()
        .filter(|(x, y, p)| picture.contains(egui::pos2(*x as f32, *y as f32)) && b.get_pixel(*x, *y) != *p)
        .count()
}

fn slider(harness: &Harness<'_, Editor>, level: u8) -> Rect {
    harness.get_by_label(&format!("Gain of level {level}")).rect()
}

#[test]
fn gains_are_dragged_live_applied_and_taken_back() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    let original = hash(&harness);
    let plain = harness.render().expect("a picture");
    click(&mut harness, "Equaliser");
    harness.get_by_label("Apply gains").scroll_to_me();
    harness.run();
    let rail = slider(&harness, 2);
    // From 1, a third of the way up, to the top.
    let middle = egui::pos2(rail.center().x, rail.bottom() - rail.height() / 3.0);
    drag(&mut harness, middle, egui::pos2(rail.center().x, rail.top() + 8.0));
    let session = &harness.state().document().expect("open").session;
    let gains = session.equaliser().expect("under the hand").gains.clone();
    assert!(gains[2] > 2.0 && gains.iter().filter(|&&g| g != 1.0).count() == 1, "{gains:?}");
    assert_eq!(session.history_len(), 0, "nothing is logged yet");
    harness.remove_cursor();
    harness.run();
    let exaggerated = harness.render().expect("a picture");
    assert!(differing(&harness, &plain, &exaggerated) >= 200, "the surface follows live");
    click(&mut harness, "Reset gains");
    assert_eq!(hash(&harness), original);
    assert!(harness.state().document().expect("open").session.equaliser().is_none());

    let rail = slider(&harness, 3);
    let middle = egui::pos2(rail.center().x, rail.bottom() - rail.height() / 3.0);
    drag(&mut harness, middle, egui::pos2(rail.center().x, rail.bottom() - 8.0));
    click(&mut harness, "Apply gains");
    let applied = hash(&harness);
    assert_ne!(applied, original);
    assert_replays(&harness);
    // Whatever comes next makes a step of gains under the hand first.
    let rail = slider(&harness, 1);
    let middle = egui::pos2(rail.center().x, rail.bottom() - rail.height() / 3.0);
    drag(&mut harness, middle, rail.center_top() + egui::vec2(0.0, 30.0));
    click(&mut harness, "Undo");
    assert_eq!(hash(&harness), applied);
    assert_eq!(harness.state().document().expect("open").session.history_len(), 2);
    click(&mut harness, "Undo");
    assert_eq!(hash(&harness), original);
}

#[test]
fn levels_are_added_and_deleted() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    let original = hash(&harness);
    let finest = harness.state().document().expect("open").surface().finest();
    click(&mut harness, "Edit level 3");
    harness.remove_cursor();
    harness.run();
    let whole = harness.render().expect("a picture");
    click(&mut harness, "Delete finer");
    assert_eq!(harness.state().document().expect("open").surface().finest(), Level(3));
    assert_eq!(harness.state().settings().shown, Level(3));
    harness.remove_cursor();
    harness.run();
    let coarse = harness.render().expect("a picture");
    assert!(differing(&harness, &whole, &coarse) >= 200, "detail is gone");
    let next = harness.state().document().expect("open").surface().vertices_of_next_level();
    click(&mut harness, "Add level");
    let surface = harness.state().document().expect("open").surface();
    assert_eq!(surface.finest(), Level(4));
    assert_eq!(surface.scaling(Level(4)).len() as u32, next.expect("small"));
    click(&mut harness, "Edit level 1");
    click(&mut harness, "Delete coarser");
    assert_eq!(harness.state().document().expect("open").surface().finest(), Level(3));
    assert_replays(&harness);
    for _ in 0..3 {
        click(&mut harness, "Undo");
    }
    assert_eq!(hash(&harness), original);
    assert_eq!(harness.state().document().expect("open").surface().finest(), finest);
}

#[test]
fn masked_parts_are_hidden_and_isolated() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    harness.get_by_label("Mask tool").click();
    harness.run();
    let middle = harness.state().picture().center();
    for _ in 0..8 {
        drag(&mut harness, middle - egui::vec2(30.0, 20.0), middle + egui::vec2(30.0, 20.0));
    }
    harness.remove_cursor();
    harness.run();
    let masked = harness.render().expect("a picture");
    click(&mut harness, "Hide masked");
    harness.remove_cursor();
    harness.run();
    let holed = harness.render().expect("a picture");
    assert!(differing(&harness, &masked, &holed) >= 200, "a hole is seen");
    click(&mut harness, "Swap hidden");
    harness.remove_cursor();
    harness.run();
    let alone = harness.render().expect("a picture");
    assert!(differing(&harness, &holed, &alone) >= 200, "the part is alone");
    // What is hidden is not hit: a drag where it was turns the camera.
    let (before, camera) = (hash(&harness), *harness.state().camera());
    harness.get_by_label("Draw tool").click();
    harness.run();
    let beside = middle + egui::vec2(0.0, 170.0);
    drag(&mut harness, beside, beside + egui::vec2(40.0, 0.0));
    assert_eq!(hash(&harness), before);
    assert_ne!(harness.state().camera().yaw, camera.yaw);
    click(&mut harness, "Show all");
    assert!(!harness.state().document().expect("open").surface().mask().hides_something());
    assert_replays(&harness);
}

#[test]
fn edges_give_way_where_they_are_dense() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    let finest = harness.state().document().expect("open").surface().finest();
    harness.get_by_label("Draw tool").click();
    harness.run();
    let mut shown = Vec::new();
    for level in [2, finest.0] {
        let mut pictures = Vec::new();
        click(&mut harness, &format!("Edit level {level}"));
        for _ in 0..2 {
            harness.remove_cursor();
            harness.run();
            pictures.push(harness.render().expect("a picture"));
            click(&mut harness, "level's edges");
        }
        shown.push(differing(&harness, &pictures[0], &pictures[1]));
    }
    assert!(shown[0] >= 200, "coarse edges are drawn: {shown:?} pixels");
    assert!(shown[1] < shown[0], "fine edges do not hide the form: {shown:?} pixels");
}
