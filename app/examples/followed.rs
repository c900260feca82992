//! What a window takes before it draws: for every dab, for a handle of the base mesh from its beginning to its end and back, and
//! for showing another level. On a million vertices.
//!
//! ```text
//! cargo run --release -p bozzetto --example followed [LEVELS]
//! ```
//!
//! The core's own part of dabs of all brushes is timed by `cargo run --release -p bozzetto-core --example strokes`.

use bozzetto::editor::{Document, HistoryStep};
use bozzetto_core::disk::Disk;
use bozzetto_core::edit::{Dab, Kind, Over, Pull, Spread, Stroke, Tool};
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::session::Session;
use bozzetto_core::surface::Surface;
use std::sync::Arc;
use std::time::Instant;

fn report(name: &str, mut milliseconds: Vec<f64>, goal: &str) {
    milliseconds.sort_by(f64::total_cmp);
    let at = |share: f64| milliseconds[((milliseconds.len() - 1) as f64 * share).round() as usize];
    println!("{name:<28} median {:8.3} ms   p99 {:8.3} ms   {goal}", at(0.5), at(0.99));
}

fn since(begun: Instant) -> f64 {
    begun.elapsed().as_secs_f64() * 1e3
}

/// Dabs of a brush on a fine and a coarse level: the core's part, and what has to follow it for the picture.
fn dabs(document: &mut Document) {
    let finest = document.surface().finest();
    for level in [finest.0, finest.0.saturating_sub(3)] {
        let (mut whole, mut followed, mut ends, mut undos) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for round in 0..8 {
            let words = Stroke {
                tool: Tool::Draw,
                level,
                radius: 0.05,
                strength: 0.5,
                falloff: None,
                mirror: None,
                to: None,
                from: None,
                dabs: Vec::new(),
                v: 1,
            };
            document.session.begin_brush(words).expect("a sensible stroke");
            for dab in 0..80 {
                let turn = f64::from(dab) * 0.0125 + f64::from(round);
                let at = [turn.cos(), 0.1 * f64::from(round) - 0.4, turn.sin()];
                let begun = Instant::now();
                let changes = document.session.dab(Dab::new(at)).expect("in range");
                let core = since(begun);
                document.follow(&changes);
                whole.push(since(begun));
                followed.push(since(begun) - core);
            }
            let begun = Instant::now();
            let changes = document.session.end_stroke();
            document.follow(&changes);
            ends.push(since(begun));
            let begun = Instant::now();
            let changes = document.session.undo().expect("a stroke");
            document.follow(&changes);
            undos.push(since(begun));
        }
        report(&format!("dab, level {level}"), whole, "goal: 1 and 4 ms");
        report("  of it what the picture needs", followed, "");
        report("  end of the stroke", ends, "");
        report("  undo of the stroke", undos, "goal: 16 ms");
    }
}

/// A handle of the base mesh from its beginning to its end, and back.
fn handle(document: &mut Document, name: &str, spread: Spread, follow: bool) {
    let (mut begins, mut steps, mut ends, mut undos) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let (mut preview, mut slow, mut previews, mut wholes) = (None, false, Vec::new(), Vec::new());
    for _ in 0..3 {
        let pull = Pull { spread, follow, ..Pull::of(Kind::Scaling, 0, 2, [0.0; 3]) };
        let begun = Instant::now();
        document.session.begin_pull(pull).expect("it exists");
        document.preview_if_large();
        begins.push(since(begun));
        preview = document.preview();
        for step in 1..=20 {
            let begun = Instant::now();
            let changes = document.drag_to([0.01 * f64::from(step), 0.0, 0.0]).expect("in range");
            document.follow(&changes);
            steps.push(since(begun));
        }
        slow = document.session.ends_slowly();
        let begun = Instant::now();
        document.end_preview();
        let changes = document.session.end_stroke();
        document.follow(&changes);
        ends.push(since(begun));
        let begun = Instant::now();
        document.preview_step(HistoryStep::Undo);
        previews.push(since(begun));
        let begun = Instant::now();
        let changes = document.session.undo().expect("a pull");
        undos.push(since(begun));
        document.end_preview();
        document.follow(&changes);
        wholes.push(since(begun));
    }
    let shown = preview.map_or("whole".to_owned(), |level| format!("on level {level}"));
    report(&format!("handle of level 0, {name}"), begins, "its beginning");
    let first = steps.iter().step_by(20).copied().collect();
    report("  first step", first, &shown);
    report("  steps", steps, "goal: 16 ms");
    report("  end", ends, if slow { "away from the window" } else { "in the window" });
    report("  undo, as it is shown at first", previews, "goal: 16 ms");
    report("  and on all levels", wholes, "away from the window");
    report("    of it the core's part", undos, "");
}

/// Gains of the equaliser under the hand, as the window lets them go.
fn gains(document: &mut Document) {
    let finest = document.surface().finest();
    for level in [3, finest.0 - 1] {
        document.session.begin_equaliser(Over::All).expect("it has wavelets");
        let reach = document.session.affordable_gains(Level(level));
        if reach < finest {
            document.preview_level(reach);
        }
        let mut steps = Vec::new();
        for step in 1..=9 {
            let mut gains = vec![1.0; finest.index()];
            gains[usize::from(level)] = 1.0 + 0.05 * f64::from(step);
            let begun = Instant::now();
            let changes = document.session.set_gains(&gains, reach).expect("in range");
            document.follow(&changes);
            steps.push(since(begun));
        }
        report(&format!("gain of level {level}"), steps, &format!("on level {reach}"));
        let begun = Instant::now();
        document.end_preview();
        let changes = document.session.end_stroke();
        document.follow(&changes);
        report("  applied", vec![since(begun)], "");
        let begun = Instant::now();
        let changes = document.session.undo().expect("gains");
        document.follow(&changes);
        report("  undo", vec![since(begun)], "");
    }
}

fn main() {
    let levels = std::env::args().nth(1).map_or(9, |x| x.parse().expect("a number of levels"));
    let surface = Surface::ball(levels, |_| 1.0);
    let finest = surface.finest();
    println!("{} vertices", surface.scaling(finest).len());
    let session = Session::new(Arc::new(Disk), Model::new(surface, None, Metadata::default()));
    let mut document = Document::new(session, finest);
    document.surface().nearest([0.0; 3]);
    dabs(&mut document);
    for (name, spread, follow) in [
        ("raw", Spread::Hat, false),
        ("smooth", Spread::Smooth, false),
        ("smooth + follow", Spread::Smooth, true),
        ("raw + follow", Spread::Hat, true),
    ] {
        handle(&mut document, name, spread, follow);
    }
    gains(&mut document);
    for level in [finest, Level(finest.0 - 1), Level(finest.0 - 3)] {
        let (mut shown, mut triangles) = (Vec::new(), Vec::new());
        for _ in 0..9 {
            let begun = Instant::now();
            document.show(level);
            shown.push(since(begun));
            let begun = Instant::now();
            document.surface().hierarchy().triangles(level);
            triangles.push(since(begun));
        }
        report(&format!("level {level} shown"), shown, "goal: 50 ms");
        report("  its triangles", triangles, "with it");
    }
}
