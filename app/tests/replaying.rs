//! Scripts and logs through the program: pairs and baked files, logs on logs, threads, and what `--base` and `--saved`
//! leave out.

mod models;
mod program;

use bozzetto_core::disk::Disk;
use bozzetto_core::edit::Edit;
use bozzetto_core::session::{OpenOptions, Session};
use models::ball_boz;
use program::Workplace;
use serde_json::json;
use std::sync::Arc;

const FIRST: &str = concat!(
    "{\"edit\":\"move\",\"kind\":\"scaling\",\"level\":0,\"vertex\":3,\"delta\":[0,0.25,0]}\n",
    "{\"edit\":\"move\",\"kind\":\"wavelet\",\"level\":2,\"vertex\":211,\"delta\":[0.01,0,0]}\n",
    "{\"edit\":\"move\",\"kind\":\"scaling\",\"level\":2,\"vertex\":40,\"delta\":[0,0.1,0],\"radius\":0.3,",
    "\"falloff\":\"smooth\"}\n",
);
const SECOND: &str = concat!(
    "{\"edit\":\"gain\",\"level\":1,\"factor\":0.5}\n",
    "{\"edit\":\"move\",\"kind\":\"wavelet\",\"level\":0,\"vertex\":10,\"delta\":[0,0,-0.125]}\n",
);

fn workplace() -> Workplace {
    let work = Workplace::new();
    ball_boz(&work);
    work.write("first.edits", FIRST);
    work.write("second.edits", SECOND);
    work.write("both.edits", [FIRST, SECOND].concat());
    work
}

fn hash(work: &Workplace, arguments: &[&str]) -> String {
    work.json(arguments)["hash"].as_str().expect("a hash").to_owned()
}

#[test]
fn a_pair_is_the_wavelet_file_and_its_log() {
    let work = workplace();
    let report = work.json(&["replay", "ball.boz", "first.edits", "-o", "out.boz"]);
    assert_eq!(report["edits"], 3);
    let before = hash(&work, &["info", "ball.boz"]);
    let after = report["hash"].as_str().expect("a hash");
    assert_ne!(before, after);
    assert!(work.read("out.boz") == work.read("ball.boz"), "the wavelet file is as it was");
    assert_eq!(hash(&work, &["info", "out.boz"]), after);
    assert_eq!(hash(&work, &["info", "out.boz", "--base"]), before);
    assert_eq!(hash(&work, &["info", "out.boz", "--saved"]), after, "a replay ends in a save mark");
    // The log is a script like any other.
    assert_eq!(hash(&work, &["replay", "ball.boz", "out.edits", "-o", "again.boz"]), after);
    assert_eq!(work.text("again.edits"), work.text("out.edits"));
    assert!(work.succeeds(&["verify", "out.boz"]).contains(after));
}

/// A smooth pull of a wavelet replays to the session's bits, and moves detail of its level and finer alone.
#[test]
fn a_smooth_wavelet_is_a_line_like_any_other() {
    let work = workplace();
    let line =
        r#"{"edit":"pull","kind":"wavelet","level":1,"vertex":30,"delta":[0,0.1,0.05],"follow":true,"v":3}"#;
    work.write("smooth.edits", line);
    let report = work.json(&["replay", "ball.boz", "smooth.edits", "-o", "out.boz", "--threads", "2"]);
    let rows = |name: &str| -> Vec<(String, String)> {
        work.succeeds(&["coefficients", name, "--csv", "out.csv"]);
        let table = work.text("out.csv");
        table
            .lines()
            .skip(1)
            .map(|row| {
                let mut fields = row.splitn(3, ',');
                (
                    format!("{} {}", fields.next().expect("a kind"), fields.next().expect("a level")),
                    row.to_owned(),
                )
            })
            .collect()
    };
    let (before, after) = (rows("ball.boz"), rows("out.boz"));
    let changed = before.iter().zip(&after).filter(|(a, b)| a != b).map(|((of, _), _)| of.as_str());
    let mut changed: Vec<&str> = changed.collect();
    changed.dedup();
    assert_eq!(changed, ["wavelet 1", "wavelet 2"]);
    let opened = Session::open(Arc::new(Disk), &work.path("ball.boz"), OpenOptions::default(), &|_| true);
    let mut session = opened.expect("opens").session;
    session.edit(serde_json::from_str::<Edit>(line).expect("an edit")).expect("small");
    assert_eq!(report["hash"], session.hash().to_string());
    drop(session);
    work.write("old.edits", line.replace("\"v\":3", "\"v\":2"));
    work.refuses(&["replay", "ball.boz", "old.edits", "-o", "old.boz"], &["old.edits", "version 3"]);
}

/// A scaling move of level 0 moves that coefficient by its delta, to half a step, and no other of that level.
#[test]
fn an_edit_does_what_its_line_says() {
    let work = workplace();
    work.write("move.edits", FIRST.lines().next().expect("a line"));
    work.succeeds(&["replay", "ball.boz", "move.edits", "-o", "out.boz"]);
    let scaling = |name: &str| -> Vec<[f64; 3]> {
        work.succeeds(&["coefficients", name, "--csv", "out.csv"]);
        let table = work.text("out.csv");
        let rows = table.lines().filter(|line| line.starts_with("scaling"));
        rows.map(|row| {
            let numbers: Vec<f64> = row.split(',').skip(6).map(|x| x.parse().expect("a number")).collect();
            numbers.try_into().expect("three coordinates")
        })
        .collect()
    };
    let (before, after) = (scaling("ball.boz"), scaling("out.boz"));
    for vertex in 0..6 {
        let delta = if vertex == 3 { [0.0, 0.25, 0.0] } else { [0.0; 3] };
        for axis in 0..3 {
            let off = after[vertex][axis] - before[vertex][axis] - delta[axis];
            assert!(off.abs() < 1e-7, "vertex {vertex}, axis {axis}: {off}");
        }
    }
}

#[test]
fn baked_files_have_the_same_surface_and_no_log() {
    let work = workplace();
    let pair = hash(&work, &["replay", "ball.boz", "both.edits", "-o", "pair.boz"]);
    let baked = hash(&work, &["replay", "ball.boz", "both.edits", "-o", "baked.boz", "--bake"]);
    assert_eq!(baked, pair);
    assert!(work.succeeds(&["bake", "pair.boz", "-o", "folded.boz"]).contains(&pair));
    assert!(!work.path("baked.edits").exists() && !work.path("folded.edits").exists());
    for name in ["baked.boz", "folded.boz"] {
        assert_eq!(hash(&work, &["info", name]), pair, "{name}");
        assert_eq!(hash(&work, &["info", name, "--base"]), pair, "{name}");
        work.succeeds(&["verify", name]);
    }
    assert!(work.read("baked.boz") == work.read("folded.boz"));
    let compared = work.json(&["compare", "pair.boz", "baked.boz"]);
    assert_eq!(compared["max"], 0.0);
    // Which input vertex each coefficient belongs to is kept.
    work.succeeds(&["coefficients", "pair.boz", "--csv", "pair.csv"]);
    work.succeeds(&["coefficients", "baked.boz", "--csv", "baked.csv"]);
    assert_eq!(work.text("pair.csv"), work.text("baked.csv"));
    // Without the log, folding changes nothing.
    work.succeeds(&["bake", "pair.boz", "-o", "base.boz", "--base"]);
    assert!(work.read("base.boz") == work.read("ball.boz"));
}

#[test]
fn a_script_goes_onto_the_file_or_onto_its_log() {
    let work = workplace();
    let hash = |arguments: &[&str]| hash(&work, arguments);
    let both = hash(&["replay", "ball.boz", "both.edits", "-o", "both.boz"]);
    hash(&["replay", "ball.boz", "first.edits", "-o", "work.boz"]);
    let onto = hash(&["replay", "work.boz", "second.edits", "-o", "onto.boz", "--onto-log"]);
    assert_eq!(onto, both, "the log's edits count with --onto-log");
    let alone = hash(&["replay", "work.boz", "second.edits", "-o", "alone.boz"]);
    assert_eq!(alone, hash(&["replay", "ball.boz", "second.edits", "-o", "second.boz"]));
    assert_ne!(alone, both, "and do not count without it");
    // What the log says can still be undone.
    work.write("undo.edits", "{\"undo\":3}\n");
    let undone = hash(&["replay", "work.boz", "undo.edits", "-o", "undone.boz", "--onto-log"]);
    assert_eq!(undone, hash(&["info", "ball.boz"]));
    assert_eq!(hash(&["info", "undone.boz"]), undone);
}

#[test]
fn undo_and_redo_leave_what_is_in_effect() {
    let work = workplace();
    let lines: Vec<&str> = SECOND.lines().collect();
    let script =
        format!("{FIRST}{{\"undo\":2}}\n{{\"redo\":1}}\n{}\n{{\"undo\":1}}\n{}\n", lines[0], lines[1]);
    work.write("winding.edits", script);
    let first_two: Vec<&str> = FIRST.lines().take(2).collect();
    work.write("straight.edits", format!("{}\n{}\n", first_two.join("\n"), lines[1]));
    let winding = hash(&work, &["replay", "ball.boz", "winding.edits", "-o", "winding.boz"]);
    assert_eq!(winding, hash(&work, &["replay", "ball.boz", "straight.edits", "-o", "straight.boz"]));
}

#[test]
fn threads_do_not_matter() {
    let work = workplace();
    let mut outputs = Vec::new();
    for threads in ["1", "2", "7"] {
        let arguments = ["replay", "ball.boz", "both.edits", "-o", "out.boz", "--bake", "--threads", threads];
        outputs.push((hash(&work, &arguments), work.read("out.boz")));
    }
    assert!(outputs.iter().all(|output| *output == outputs[0]));
}

/// Edits since the last save mark count unless one asks for what was saved.
#[test]
fn unsaved_edits_are_in_the_log() {
    let work = workplace();
    let saved = hash(&work, &["replay", "ball.boz", "first.edits", "-o", "work.boz"]);
    let opened = Session::open(Arc::new(Disk), &work.path("work.boz"), OpenOptions::default(), &|_| true)
        .expect("opens");
    let mut session = opened.session;
    let gain: Edit =
        serde_json::from_value(json!({"edit": "gain", "level": 0, "factor": 3.0})).expect("an edit");
    session.edit(gain).expect("allowed");
    let unsaved = session.hash().to_string();
    session.close().expect("the log is written");
    assert_ne!(unsaved, saved);
    assert_eq!(hash(&work, &["info", "work.boz"]), unsaved);
    assert_eq!(hash(&work, &["info", "work.boz", "--saved"]), saved);
    work.succeeds(&["bake", "work.boz", "-o", "saved.boz", "--saved"]);
    assert_eq!(hash(&work, &["info", "saved.boz"]), saved);
    // Discarding is a line too: it takes back what was not saved.
    let again = Session::open(Arc::new(Disk), &work.path("work.boz"), OpenOptions::default(), &|_| true)
        .expect("opens");
    again.session.discard().expect("the log is written");
    assert_eq!(hash(&work, &["info", "work.boz"]), saved);
}
