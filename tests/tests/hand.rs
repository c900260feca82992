//! What the hand does over time: strokes steadied, brushes seen on coarse levels, a tablet's pen, wavelet handles.

mod window;

use bozzetto::editor::{Editor, PenEvent, PenInput, Start};
use bozzetto_core::edit::{Edit, Kind, Spread, Tool};
use bozzetto_core::file::read_log;
use bozzetto_core::hierarchy::{Level, PublicId};
use eframe::egui::{self, Event, Key, Modifiers, PointerButton, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use glam::DVec3;
use std::collections::{HashMap, VecDeque};
use std::time::Duration;
use window::{
    assert_replays, assert_replays_on, ball, button, can_draw, differing, differing_where, drag, editor,
    hash, last, middle, picture, redo, release, save_as, session, take, undo,
};

/// Draws across the face with a trembling hand; the dabs of the logged stroke.
fn trembling(harness: &mut Harness<'_, Editor>) -> Vec<[f64; 3]> {
    let from = middle(harness) + egui::vec2(-110.0, -20.0);
    harness.event(Event::PointerMoved(from));
    harness.run_steps(2);
    harness.event(button(true, from, PointerButton::Primary, Modifiers::NONE));
    harness.run_steps(1);
    let mut at = from;
    for step in 1..=44 {
        let tremble = if step % 2 == 0 { 9.0 } else { -9.0 };
        at = from + egui::vec2(5.0 * step as f32, tremble);
        harness.event(Event::PointerMoved(at));
        harness.run_steps(1);
    }
    release(harness, at);
    match last(harness) {
        Edit::Stroke(stroke) => stroke.dabs.iter().map(|dab| dab.at).collect(),
        other => panic!("{other}"),
    }
}

/// How far the dabs of a stroke across go up and down on their way.
fn restlessness(dabs: &[[f64; 3]]) -> f64 {
    let ways = dabs.windows(2).map(|pair| (pair[1][1] - pair[0][1]).abs());
    ways.sum::<f64>() / dabs.len() as f64
}

/// A steadied brush draws a calmer line than the hand, and its log is a script that gives the same bits.
#[test]
fn a_steadied_stroke_is_calm_and_its_log_is_a_script() {
    if !can_draw() {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("steadied.boz");
    let mut harness = editor(Start::sample().expect("the sample opens"));
    let original = hash(&harness);
    take(&mut harness, "Draw");
    for _ in 0..8 {
        harness.key_press(Key::OpenBracket);
        harness.run();
    }
    let restless = trembling(&mut harness);
    let unsteadied = hash(&harness);
    undo(&mut harness);
    assert_eq!(hash(&harness), original);

    let rail = harness.get_by_role_and_label(egui::accesskit::Role::Slider, "steady").rect();
    let middle = rail.left_center() + egui::vec2(0.5 * rail.width().min(100.0), 0.0);
    drag(&mut harness, rail.left_center() + egui::vec2(6.0, 0.0), middle, Modifiers::NONE);
    release(&mut harness, middle);
    let steady = harness.state().settings().steady;
    assert!((20.0..70.0).contains(&steady), "{steady} points");
    let before = picture(&mut harness);
    let calm = trembling(&mut harness);
    let steadied = hash(&harness);
    assert!(steadied != original && steadied != unsteadied);
    assert!(calm.len() >= 8 && restless.len() >= 8, "{} and {} dabs", calm.len(), restless.len());
    let (calm, restless) = (restlessness(&calm), restlessness(&restless));
    assert!(calm < 0.5 * restless, "{calm} steadied, {restless} as the hand goes");
    let after = picture(&mut harness);
    assert!(differing(&harness, &before, &after) >= 200, "it is seen");

    save_as(&mut harness, &path);
    drop(harness);
    let log = path.with_extension("edits");
    let script = read_log(&std::fs::read(&log).expect("a log"), true);
    let Start::Session(mut fresh) = Start::sample().expect("the sample opens") else { panic!("a session") };
    fresh.play(&script.lines, &|_| true).expect("every line plays");
    assert_eq!(fresh.hash(), steadied, "the log, played as a script");
}

/// Copied detail goes to the finest level; where a coarser one is shown, the finest is seen until the brush is let go.
#[test]
fn a_brush_on_a_finer_level_than_is_shown_is_seen_live() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    harness.get_by_label("Show level 3").click();
    harness.run();
    harness.get_by_label("Edit level 1").click();
    harness.run();
    take(&mut harness, "Copy detail");
    let from = middle(&harness) + egui::vec2(10.0, -110.0);
    drag(&mut harness, from, from, Modifiers::ALT);
    release(&mut harness, from);
    let finest = session(&harness).surface().finest();
    let shown = |harness: &Harness<'_, Editor>| {
        let vertices = harness.state().document().expect("open").vertices();
        (vertices.level(), vertices.positions().to_vec())
    };
    let (before, start) = (shown(&harness), middle(&harness));
    assert_eq!(before.0, Level(3));
    drag(&mut harness, start, start + egui::vec2(20.0, 10.0), Modifiers::NONE);
    let first = shown(&harness);
    assert!(
        session(&harness).in_stroke() && first.0 == finest,
        "the brush is down, level {} is seen",
        first.0
    );
    assert!(harness.query_by_label_contains("shown until you let go").is_some());
    let seen = harness.render().expect("a picture");
    for step in 1..=4 {
        harness.event(Event::PointerMoved(
            start + egui::vec2(20.0 + 10.0 * step as f32, 10.0 + 5.0 * step as f32),
        ));
        harness.run_steps(1);
    }
    let moved = shown(&harness).1.iter().zip(&first.1).filter(|(a, b)| a != b).count();
    assert!(moved > 20, "{moved} vertices follow the brush");
    let later = harness.render().expect("a picture");
    assert!(differing(&harness, &seen, &later) >= 200, "and that is seen");
    release(&mut harness, start);
    let after = shown(&harness);
    assert!(after.0 == Level(3) && after.1 != before.1, "the level chosen is shown as it is now");
    assert!(matches!(last(&harness), Edit::Stroke(s) if s.tool == Tool::Copy));
    assert_replays(&harness);
}

/// Erasing takes the levels from the edited one to the one chosen, and finer detail stays.
#[test]
fn detail_of_chosen_levels_is_erased() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    take(&mut harness, "Erase detail");
    let rail = harness.get_by_role_and_label(egui::accesskit::Role::Slider, "erase to level").rect();
    let (right, left) =
        (rail.left_center() + egui::vec2(60.0, 0.0), rail.left_center() + egui::vec2(5.0, 0.0));
    drag(&mut harness, right, left, Modifiers::NONE);
    release(&mut harness, left);
    let (level, to) = (harness.state().settings().level.0, harness.state().settings().erase_to);
    assert_eq!(to, Some(level), "from the edited level to itself");
    let finest = session(&harness).surface().finest().0 - 1;
    let wavelets =
        |harness: &Harness<'_, Editor>, level: u8| session(harness).surface().wavelets(Level(level)).to_vec();
    let before = [wavelets(&harness, level), wavelets(&harness, finest)];
    let from = middle(&harness);
    drag(&mut harness, from, from + egui::vec2(50.0, 20.0), Modifiers::NONE);
    release(&mut harness, from);
    let Edit::Stroke(stroke) = last(&harness) else { panic!("no stroke") };
    assert_eq!((stroke.tool, stroke.to), (Tool::Erase, Some(level)));
    assert!(wavelets(&harness, level) != before[0], "its detail goes");
    assert!(wavelets(&harness, finest) == before[1], "finer detail stays");
    assert_replays(&harness);
}

/// Copying without a place to copy from says what to do; the place is then marked.
#[test]
fn copying_asks_for_its_source_and_marks_it() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    take(&mut harness, "Copy detail");
    let at = middle(&harness);
    drag(&mut harness, at, at + egui::vec2(40.0, 0.0), Modifiers::NONE);
    release(&mut harness, at);
    assert!(harness.state().message().is_some_and(|(text, failed)| text.contains("Alt + click") && !failed));
    assert_eq!(session(&harness).history_len(), 0);
    let without = picture(&mut harness);
    drag(&mut harness, at, at, Modifiers::ALT);
    release(&mut harness, at);
    let with = picture(&mut harness);
    let seen = differing_where(&without, &with, |pixel| (pixel - at).length() < 14.0);
    assert!(seen >= 30, "the mark covers {seen} pixels");
}

/// A tablet whose pen was written down: what it does frame by frame, with its force.
struct RecordedTablet {
    frames: VecDeque<Vec<PenEvent>>,
    forces: VecDeque<f64>,
}

impl PenInput for RecordedTablet {
    fn heard(&mut self, _: Option<f32>) {}

    fn pressure(&mut self) -> Option<f64> {
        self.forces.pop_front()
    }

    fn strokes(&mut self) -> Vec<PenEvent> {
        self.frames.pop_front().unwrap_or_default()
    }

    fn asks_again_in(&self) -> Option<Duration> {
        (!self.frames.is_empty()).then_some(Duration::from_millis(8))
    }
}

/// A tablet's pen, of which the window hears nothing otherwise, points and draws, and every dab has the force of its moment.
#[test]
fn a_tablets_pen_draws_with_its_own_force() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::sample().expect("the sample opens"));
    let original = hash(&harness);
    take(&mut harness, "Draw");
    let from = middle(&harness);
    let at = |x: f32| [from.x + x, from.y];
    let frames = [
        vec![PenEvent::Moved(at(0.0))],
        vec![PenEvent::Down(at(0.0)), PenEvent::Moved(at(40.0))],
        vec![PenEvent::Moved(at(80.0)), PenEvent::Up(at(80.0)), PenEvent::Gone],
    ];
    harness
        .state_mut()
        .set_pen(Box::new(RecordedTablet { frames: frames.into(), forces: [0.1, 0.5, 0.9].into() }));
    for _ in 0..4 {
        let ctx = harness.ctx.clone();
        let mut raw = egui::RawInput::default();
        eframe::App::raw_input_hook(harness.state_mut(), &ctx, &mut raw);
        raw.events.into_iter().for_each(|event| harness.event(event));
        harness.run_steps(1);
    }
    harness.run();
    let Edit::Stroke(stroke) = last(&harness) else { panic!("no stroke") };
    let strengths: Vec<f64> = stroke.dabs.iter().map(|dab| dab.strength).collect();
    assert_eq!((strengths[0], strengths[strengths.len() - 1]), (0.1, 0.9), "{strengths:?}");
    assert!(strengths.is_sorted() && strengths.contains(&0.5), "{strengths:?}");
    assert_ne!(hash(&harness), original);
    assert_replays(&harness);
}

/// A wavelet under symmetry moves with its mirror image, and the line says so.
#[test]
fn a_wavelet_handle_is_mirrored() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::Session(Box::new(ball())));
    let original = hash(&harness);
    harness.key_press(Key::W);
    harness.key_press(Key::X);
    harness.get_by_label("Raw").click();
    harness.get_by_label("detail follows").click();
    harness.run();
    let from = middle(&harness) + egui::vec2(110.0, -40.0);
    let plain = harness.render().expect("a picture");
    let to = from + egui::vec2(20.0, -30.0);
    drag(&mut harness, from, to, Modifiers::NONE);
    release(&mut harness, to);
    let Edit::Move(edit) = last(&harness) else { panic!("no move") };
    assert!(edit.mirror.is_some_and(|mirror| mirror.x.is_some()), "{edit:?}");
    assert_eq!(harness.state().message(), None, "it has a partner");
    let moved = picture(&mut harness);
    // Left of the middle, too, where the mouse never was.
    let middle = middle(&harness).x;
    let left = |at: Pos2| at.x < middle - 20.0 && harness.state().picture().left() < at.x;
    let seen = differing_where(&plain, &moved, left);
    assert!(seen >= 200, "{seen} pixels of the mirror image");
    assert_ne!(hash(&harness), original);
    assert_replays_on(&harness, ball());
}

/// A wavelet handle makes a smooth bump of detail unless told to be raw, and neither moves the coarser form. The vertex goes
/// where the cursor goes.
#[test]
fn a_wavelet_handle_is_smooth_by_default() {
    if !can_draw() {
        return;
    }
    let mut harness = editor(Start::Session(Box::new(ball())));
    harness.key_press(Key::W);
    harness.run();
    let (level, original) = (harness.state().settings().level, hash(&harness));
    let coarser = |harness: &Harness<'_, Editor>| session(harness).surface().scaling(level).to_vec();
    let before = coarser(&harness);
    // Where the vertices are that wavelets of the level have, by id.
    let document = harness.state().document().expect("open");
    let places: HashMap<u32, DVec3> = (0..document.surface().scaling(level.finer()).len() as u32)
        .filter_map(|id| Some((id, document.target(Kind::Wavelet, level, PublicId(id))?.position)))
        .collect();
    let (from, plain) = (middle(&harness) + egui::vec2(110.0, -40.0), picture(&mut harness));
    let to = from + egui::vec2(20.0, -30.0);
    let mut pictures = Vec::new();
    for raw in [false, true] {
        if raw {
            harness.get_by_label("Raw").click();
            harness.run();
        }
        drag(&mut harness, from, to, Modifiers::NONE);
        release(&mut harness, to);
        let Edit::Pull(edit) = last(&harness) else { panic!("{}", last(&harness)) };
        assert_eq!((edit.kind, edit.level, edit.spread == Spread::Hat), (Kind::Wavelet, level.0, raw));
        assert!(coarser(&harness) == before, "the coarser form stays");
        let document = harness.state().document().expect("open");
        let vertex = PublicId(edit.vertex.expect("a vertex"));
        let now = document.target(Kind::Wavelet, level, vertex).expect("it is seen").position;
        let asked = DVec3::from_array(edit.delta);
        assert!(asked.length() > 0.05, "{asked}");
        let went = now - places[&vertex.0];
        // Its own detail turns along.
        assert!((went - asked).length() < 0.05 * asked.length(), "{went}, asked for {asked}");
        let dragged = hash(&harness);
        assert_ne!(dragged, original);
        assert_replays_on(&harness, ball());
        pictures.push(picture(&mut harness));
        undo(&mut harness);
        assert_eq!(hash(&harness), original);
        redo(&mut harness);
        assert_eq!(hash(&harness), dragged);
        undo(&mut harness);
    }
    for (a, b) in [(&plain, &pictures[0]), (&pictures[0], &pictures[1])] {
        let seen = differing(&harness, a, b);
        assert!(seen >= 200, "{seen} pixels");
    }
}
