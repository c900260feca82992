//! Windows of all sizes: whatever can be used is seen, or comes into sight by scrolling.

mod window;

use bozzetto::editor::{Editor, Start};
use bozzetto_core::edit::Tool;
use eframe::egui::{self, Key, Rect, accesskit::Role, vec2};
use egui_kittest::kittest::{NodeT, Queryable};
use egui_kittest::{Harness, Node};
use window::{can_draw, editor_of_size, settle, stroke, take};

/// What can be used, in the order of the window.
fn controls<'a>(harness: &'a Harness<'_, Editor>) -> Vec<Node<'a>> {
    let usable = |node: &Node<'_>| {
        matches!(
            node.accesskit_node().role(),
            Role::Button
                | Role::CheckBox
                | Role::RadioButton
                | Role::Slider
                | Role::SpinButton
                | Role::TextInput
        )
    };
    harness.root().children_recursive().filter(usable).collect()
}

/// Every control comes wholly into the window, and not under the status bar.
fn assert_reachable(harness: &mut Harness<'_, Editor>, size: egui::Vec2, what: &str) {
    let window = Rect::from_min_size(egui::Pos2::ZERO, size - vec2(0.0, 28.0)).expand(1.0);
    let count = controls(harness).len();
    assert!(count > 20 || what.contains("dialog") && count > 2, "{what}: {count} controls");
    for at in 0..count {
        controls(harness)[at].scroll_to_me();
        harness.run();
        let node = controls(harness).swap_remove(at);
        let (rect, label) = (node.rect(), node.accesskit_node().label());
        assert!(window.contains_rect(rect), "{what}, {size}: {label:?} is at {rect}");
    }
}

#[test]
fn everything_is_reachable_in_small_windows() {
    if !can_draw() {
        return;
    }
    for size in [vec2(820.0, 520.0), vec2(900.0, 600.0)] {
        let mut harness = editor_of_size(Start::sample().expect("the sample opens"), size);
        harness.get_by_label("Equaliser").scroll_to_me();
        harness.run();
        harness.get_by_label("Equaliser").click();
        harness.run();
        for name in ["Handle", "Grab"].into_iter().chain(Tool::ALL.map(Tool::name)) {
            take(&mut harness, name);
            if name == Tool::Mask.name() {
                stroke(&mut harness, egui::Modifiers::NONE);
                settle(&mut harness);
            }
            assert_reachable(&mut harness, size, &format!("with {name}"));
        }
        for name in ["Open", "Save as", "Export", "Import mesh", "Remesh", "Keys"] {
            harness.get_by_label(name).scroll_to_me();
            harness.run();
            harness.get_by_label(name).click();
            harness.run();
            assert_reachable(&mut harness, size, &format!("dialog {name}"));
            harness.key_press(Key::Escape);
            harness.run();
        }
    }
}
