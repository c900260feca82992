//! Hundreds of random uses of the window, undone and redone.

mod window;

use bozzetto::editor::{Editor, Start};
use bozzetto_core::edit::Tool;
use bozzetto_core::surface::SurfaceHash;
use eframe::egui::{self, Key, Modifiers, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use window::{
    assert_replays_on, ball, can_draw, drag, editor, hash, middle, redo, release, session, settle, take, undo,
};

/// Numbers that look random and are the same everywhere.
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % u64::from(n)) as u32
    }
}

/// Clicks what has a label, wherever the inspector has it.
fn click(harness: &mut Harness<'_, Editor>, label: &str) {
    if harness.query_by_label(label).is_none_or(|node| node.accesskit_node().is_disabled()) {
        return;
    }
    harness.get_by_label(label).scroll_to_me();
    harness.run();
    harness.get_by_label(label).click();
    settle(harness);
}

/// A place on the ball, or now and then beside it.
fn place(harness: &Harness<'_, Editor>, numbers: &mut Numbers) -> Pos2 {
    let mut away = || numbers.below(400) as f32 - 200.0;
    middle(harness) + egui::vec2(away(), away())
}

/// A drag with whatever is in the hand.
fn use_hand(harness: &mut Harness<'_, Editor>, numbers: &mut Numbers) {
    let modifiers = [Modifiers::NONE, Modifiers::NONE, Modifiers::CTRL, Modifiers::SHIFT];
    let (from, to) = (place(harness, numbers), place(harness, numbers));
    drag(harness, from, from + (to - from) * 0.3, modifiers[numbers.below(4) as usize]);
    if numbers.below(8) == 0 {
        harness.key_press(Key::Escape);
        harness.run_steps(1);
    }
    release(harness, to);
    settle(harness);
}

/// Something that a hand may do, without undo and redo.
fn something(harness: &mut Harness<'_, Editor>, numbers: &mut Numbers) {
    let (finest, vertices) = {
        let surface = session(harness).surface();
        (surface.finest().0, surface.scaling(surface.finest()).len())
    };
    match numbers.below(100) {
        0..44 => {
            let tool = Tool::ALL[numbers.below(Tool::ALL.len() as u32) as usize];
            take(harness, tool.name());
            if tool == Tool::Copy {
                let from = middle(harness) + egui::vec2(40.0, -40.0);
                drag(harness, from, from, Modifiers::ALT);
                release(harness, from);
            }
            use_hand(harness, numbers);
        }
        44..64 => {
            take(harness, ["Handle", "Grab"][numbers.below(2) as usize]);
            match numbers.below(4) {
                0 => click(harness, "detail follows"),
                1 => click(harness, ["Raw", "Smooth bend"][numbers.below(2) as usize]),
                2 => harness.key_press(Key::W),
                _ => {}
            }
            harness.run();
            use_hand(harness, numbers);
        }
        64..72 => {
            let level = numbers.below(u32::from(finest));
            let name = format!("Gain of level {level}");
            harness.get_by_label(&name).scroll_to_me();
            harness.run();
            let rail = harness.get_by_label(&name).rect();
            let one = egui::pos2(rail.center().x, rail.bottom() - rail.height() / 3.0);
            let to = one + egui::vec2(0.0, numbers.below(40) as f32 - 20.0);
            drag(harness, one, to, Modifiers::NONE);
            release(harness, to);
            click(harness, ["Apply gains", "Reset gains"][numbers.below(2) as usize]);
        }
        72..78 => click(harness, ["erase", "½", "× 2"][numbers.below(3) as usize]),
        78..84 => {
            take(harness, "Mask");
            let names =
                ["Hide masked", "Isolate masked", "Swap hidden", "Show all", "Show all", "Clear mask"];
            click(harness, names[numbers.below(6) as usize]);
        }
        84..90 => {
            let key = [Key::X, Key::Z, Key::OpenBracket, Key::CloseBracket][numbers.below(4) as usize];
            harness.key_press(key);
            harness.run();
        }
        90..96 => {
            let modifiers = if numbers.below(2) == 0 { Modifiers::SHIFT } else { Modifiers::NONE };
            harness.key_press_modifiers(modifiers, Key::D);
            harness.run();
        }
        _ if finest < 3 || vertices < 200 => click(harness, "Add level"),
        _ if finest > 3 => click(harness, "Delete finer"),
        _ => {}
    }
}

/// Three hundred random uses of the window, by names and keys: whatever is undone or redone comes back to the bit, and the
/// history keeps to its budget.
#[test]
fn random_uses_of_the_window_return_exactly_within_the_budget() {
    const BUDGET: usize = 8 << 10;
    if !can_draw() {
        return;
    }
    let mut start = ball();
    start.set_history_budget(BUDGET);
    let mut harness = editor(Start::Session(Box::new(start)));
    click(&mut harness, "Equaliser");
    let mut numbers = Numbers(20_261_130);
    // The hash after so many steps, where it was seen.
    let mut hashes: Vec<Option<SurfaceHash>> = vec![Some(hash(&harness))];
    let (mut made, mut returned, mut most) = (0, 0, 0);
    for round in 0..300 {
        let (steps, before) = (session(&harness).steps(), hash(&harness));
        let back = [Modifiers::COMMAND, Modifiers::COMMAND | Modifiers::SHIFT];
        match numbers.below(10) {
            way @ 0..4 => {
                for _ in 0..=numbers.below(3) {
                    match numbers.below(2) {
                        0 => harness.key_press_modifiers(back[way as usize / 2], Key::Z),
                        _ => click(&mut harness, ["Undo", "Redo"][way as usize / 2]),
                    }
                    settle(&mut harness);
                }
                returned += usize::from(hash(&harness) != before);
            }
            _ => {
                something(&mut harness, &mut numbers);
                let now = session(&harness).steps();
                if now != steps {
                    assert!(now > steps, "round {round}: {now} steps after {steps}");
                    made += now - steps;
                    hashes.truncate(steps + 1);
                    hashes.resize(now + 1, None);
                }
            }
        }
        let now = hash(&harness);
        let (at, memory) = (session(&harness).steps(), session(&harness).history_in_memory());
        assert_eq!(*hashes[at].get_or_insert(now), now, "round {round}, after {at} steps");
        most = most.max(memory);
        assert!(memory <= BUDGET + (1 << 17), "round {round}: {memory} bytes of history");
    }
    println!("{made} steps made, {returned} times returned, at most {most} bytes of history in memory");
    assert!(made > 100 && returned > 30, "{made} steps made, {returned} times returned");
    let (after, steps) = (hash(&harness), session(&harness).steps());
    assert_replays_on(&harness, ball());
    for to in (0..steps).rev() {
        undo(&mut harness);
        assert_eq!(hash(&harness), *hashes[to].get_or_insert(hash(&harness)), "undone to {to} steps");
    }
    assert_eq!((session(&harness).steps(), hash(&harness)), (0, hashes[0].expect("seen")));
    for _ in 0..steps {
        redo(&mut harness);
    }
    assert_eq!(hash(&harness), after, "redone");
}
