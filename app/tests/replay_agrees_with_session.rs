//! A long session at the editor's door, and its log played without a window: the same bits, for any number of threads.

mod models;
mod program;
mod random;

use bozzetto_core::disk::Disk;
use bozzetto_core::edit::{Edit, Move};
use bozzetto_core::session::{OpenOptions, Session};
use models::ball_boz;
use program::Workplace;
use random::Random;
use serde_json::{Value, json};
use std::sync::Arc;

/// Edits, undos and redos of the session.
const STEPS: usize = 200;
/// The ball's vertices by level.
const COUNTS: [usize; 4] = [6, 18, 66, 258];

/// A move of a random coefficient, alone or with its neighbourhood.
fn random_move(random: &mut Random) -> Value {
    let wavelet = random.below(2) == 1;
    let level = random.below(if wavelet { 3 } else { 4 });
    let vertex = match wavelet {
        true => COUNTS[level] + random.below(COUNTS[level + 1] - COUNTS[level]),
        false => random.below(COUNTS[level]),
    };
    let delta = random.point().map(|x| 0.05 * x);
    let kind = if wavelet { "wavelet" } else { "scaling" };
    let mut edit = json!({"edit": "move", "kind": kind, "level": level, "vertex": vertex, "delta": delta});
    if random.below(3) == 0 {
        edit["radius"] = json!(0.2 + 0.5 * random.signed().abs());
        if random.below(2) == 0 {
            edit["falloff"] = json!(["smooth", "linear", "sharp", "constant"][random.below(4)]);
        }
    }
    edit
}

/// Drags a coefficient about in several steps; every other drag is taken back.
fn random_drag(session: &mut Session, random: &mut Random) -> u64 {
    let Edit::Move(edit) = serde_json::from_value(random_move(random)).expect("an edit") else {
        unreachable!("it is a move")
    };
    session.begin_stroke(Move { delta: [0.0; 3], ..edit }).expect("the coefficient exists");
    for _ in 0..1 + random.below(5) {
        session.drag_to(random.point().map(|x| 0.05 * x)).expect("small");
    }
    if random.below(2) == 0 {
        session.cancel_stroke();
        return 0;
    }
    session.end_stroke();
    1
}

/// One step of the session; how many edits it logged.
fn random_step(session: &mut Session, random: &mut Random) -> u64 {
    match random.below(10) {
        0 => {
            session.undo();
            0
        }
        1 => {
            (0..random.below(4)).for_each(|_| drop(session.undo()));
            (0..random.below(4)).for_each(|_| drop(session.redo()));
            0
        }
        2 | 3 => random_drag(session, random),
        4 => {
            let factor = 1.2 * random.signed();
            let gain = json!({"edit": "gain", "level": random.below(3), "factor": factor});
            session.edit(serde_json::from_value(gain).expect("an edit")).expect("within the limit");
            1
        }
        _ => {
            session.edit(serde_json::from_value(random_move(random)).expect("an edit")).expect("small");
            1
        }
    }
}

#[test]
fn for_any_number_of_threads() {
    let work = Workplace::new();
    ball_boz(&work);
    let original = work.read("ball.boz");
    let opened = Session::open(Arc::new(Disk), &work.path("ball.boz"), OpenOptions::default(), &|_| true);
    let mut session = opened.expect("opens").session;
    let mut random = Random::seeded(20);
    let edits: u64 = (0..STEPS).map(|_| random_step(&mut session, &mut random)).sum();
    assert!(edits > 100, "a session of {edits} edits");
    let hash = session.hash().to_string();
    session.close().expect("the log is written");

    assert!(work.read("ball.boz") == original, "the session writes the log alone");
    let log = work.text("ball.edits");
    let count = |what: &str| log.lines().filter(|line| line.contains(what)).count();
    println!("{} lines, {} undo, {} redo", log.lines().count(), count("\"undo\""), count("\"redo\""));
    assert!(count("\"undo\"") > 5 && count("\"redo\"") > 2 && count("\"hash\"") >= 3, "{log}");

    for threads in ["1", "2", "7"] {
        let report = work.json(&["replay", "ball.boz", "ball.edits", "-o", "out.boz", "--threads", threads]);
        assert_eq!(report["hash"], hash, "{threads} threads");
        assert_eq!(report["edits"], edits, "{threads} threads");
        assert_eq!(work.json(&["info", "out.boz"])["hash"], hash, "the pair, {threads} threads");
    }
    assert_eq!(work.json(&["info", "ball.boz"])["hash"], hash, "file and log");
    work.succeeds(&["bake", "ball.boz", "-o", "baked.boz"]);
    assert_eq!(work.json(&["info", "baked.boz"])["hash"], hash, "baked");

    // One changed digit in one line is noticed: by its checksum, and without one by the next recorded hash.
    let line = log.lines().nth(3).expect("a line");
    let digit = line.rfind(|c: char| ('1'..='8').contains(&c)).expect("a digit");
    let changed = line[..digit].to_owned() + "9" + &line[digit + 1..];
    work.write("changed.edits", log.replacen(line, &changed, 1));
    work.refuses(&["replay", "ball.boz", "changed.edits", "-o", "changed.boz"], &["changed.edits", "line 4"]);
    let without = log.lines().filter(|other| *other != line).map(|line| format!("{line}\n"));
    work.write("shorter.edits", without.collect::<String>());
    work.refuses(&["replay", "ball.boz", "shorter.edits", "-o", "shorter.boz"], &["shorter.edits", "line "]);
}
