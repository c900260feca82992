//! Wavelet files that end early: refused before the base mesh ends, a coarse model after it, the whole surface once
//! its end marker is there.

mod models;
mod program;

use models::ball_boz;
use program::{Outcome, Workplace, one_object, skipped};
use serde_json::Value;

/// How a cut file is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Taken {
    Refused,
    Partial,
    Whole,
}

/// `info --json` of a cut file.
fn taken(work: &Workplace, name: &str) -> (Taken, Option<Value>) {
    let Outcome { status, stdout, stderr } = work.run(&["info", name, "--json"]);
    if status != 0 {
        work.refuses(&["info", name, "--json"], &[name]);
        return (Taken::Refused, None);
    }
    let info = one_object(&stdout);
    let complete = info["complete"].as_bool().expect("complete is a truth value");
    assert!(complete || one_note(&stderr, name), "{stderr}");
    (if complete { Taken::Whole } else { Taken::Partial }, Some(info))
}

/// Standard error holds one note that names the file.
fn one_note(stderr: &str, name: &str) -> bool {
    stderr.starts_with("note: ") && stderr.contains(name) && stderr.matches('\n').count() == 1
}

#[test]
fn every_prefix_is_refused_or_a_model() {
    let work = Workplace::new();
    ball_boz(&work);
    let bytes = work.read("ball.boz");
    let whole = work.json(&["info", "ball.boz"]);
    let mut lengths: Vec<usize> = (0..bytes.len()).step_by(bytes.len() / 60).collect();
    lengths.extend([1, 8, 15, 16, 17, bytes.len() - 2, bytes.len() - 1, bytes.len()]);
    lengths.sort_unstable();

    let mut seen = Vec::new();
    for length in lengths {
        work.write("cut.boz", &bytes[..length]);
        let (how, info) = taken(&work, "cut.boz");
        assert!(seen.last() <= Some(&how), "{length} bytes: {how:?} after {seen:?}");
        seen.push(how);
        let Some(info) = info else { continue };
        assert_eq!(info["bytes"], length);
        for key in ["vertices", "faces", "levels", "base_vertices", "base_faces", "genus", "wavelet"] {
            assert_eq!(info[key], whole[key], "{key} at {length} bytes");
        }
        assert!(info["hash"] == whole["hash"] || how == Taken::Partial, "{length} bytes");
    }
    for how in [Taken::Refused, Taken::Partial, Taken::Whole] {
        let count = seen.iter().filter(|&&h| h == how).count();
        assert!(count >= 3, "only {count} of {} lengths are {how:?}", seen.len());
    }
    assert_eq!(seen.last(), Some(&Taken::Whole));
}

/// A cut with the base mesh and some of the detail.
fn cut_in_the_detail(work: &Workplace) {
    ball_boz(work);
    let bytes = work.read("ball.boz");
    work.write("cut.boz", &bytes[..bytes.len() / 2]);
    assert_eq!(taken(work, "cut.boz").0, Taken::Partial);
}

#[test]
fn a_partial_model_can_be_looked_at() {
    let work = Workplace::new();
    cut_in_the_detail(&work);
    for arguments in [
        &["export", "cut.boz", "-o", "cut.obj"][..],
        &["export", "cut.boz", "-o", "base.ply", "--level", "0"],
        &["compare", "ball.boz", "cut.boz", "--json"],
        &["compare", "cut.boz", "ball.obj"],
        &["coefficients", "cut.boz", "--csv", "cut.csv"],
        &["info", "cut.boz"],
    ] {
        let Outcome { status, stdout, stderr } = work.run(arguments);
        assert_eq!(status, 0, "{arguments:?}: {stderr}");
        assert!(one_note(&stderr, "cut.boz"), "{arguments:?}: {stderr}");
        if arguments.contains(&"--json") {
            let rms = one_object(&stdout)["rms"].as_f64().expect("a number");
            assert!((1e-6..0.1).contains(&rms), "coarser, but the same shape: {rms}");
        }
    }
    let rendered = work.run(&["render", "cut.boz", "-o", "cut.png", "--size", "64x64"]);
    if rendered.stderr.contains("adapter") {
        skipped("rendering a partial file", &rendered.stderr);
    } else {
        assert_eq!(rendered.status, 0, "{rendered:?}");
        assert!(one_note(&rendered.stderr, "cut.boz"), "{rendered:?}");
    }
    let mesh = models::read_obj(&work.text("cut.obj"));
    assert_eq!((mesh.positions.len(), mesh.faces.len()), (258, 512));
}

#[test]
fn a_partial_model_cannot_be_built_on() {
    let work = Workplace::new();
    cut_in_the_detail(&work);
    work.write("script.edits", "{\"edit\":\"gain\",\"level\":1,\"factor\":2}\n");
    let incomplete = ["cut.boz", "incomplete"];
    work.refuses(&["verify", "cut.boz"], &incomplete);
    work.refuses(&["bake", "cut.boz", "-o", "out.boz"], &incomplete);
    work.refuses(&["replay", "cut.boz", "script.edits", "-o", "out.boz"], &incomplete);
    work.refuses(&["replay", "cut.boz", "script.edits", "-o", "out.boz", "--bake", "--json"], &incomplete);
    // A log needs the surface it was written on.
    work.succeeds(&["replay", "ball.boz", "script.edits", "-o", "logged.boz"]);
    let bytes = work.read("logged.boz");
    work.write("logged.boz", &bytes[..bytes.len() / 2]);
    for arguments in [&["info", "logged.boz"][..], &["export", "logged.boz", "-o", "out.obj"]] {
        work.refuses(arguments, &["logged.boz", "incomplete"]);
    }
    assert_eq!(work.run(&["info", "logged.boz", "--base"]).status, 0);
}

/// What stands after the end marker is not the surface: losing it is worth a note, and `verify` refuses.
#[test]
fn a_file_cut_after_its_surface_is_whole() {
    let work = Workplace::new();
    ball_boz(&work);
    let bytes = work.read("ball.boz");
    work.write("tail.boz", &bytes[..bytes.len() - 1]);
    assert_eq!(taken(&work, "tail.boz").0, Taken::Whole);
    let exported = work.run(&["export", "tail.boz", "-o", "tail.obj"]);
    assert!(exported.status == 0 && one_note(&exported.stderr, "tail.boz"), "{exported:?}");
    work.succeeds(&["export", "ball.boz", "-o", "whole.obj"]);
    assert!(work.read("tail.obj") == work.read("whole.obj"));
    work.refuses(&["verify", "tail.boz"], &["tail.boz", "cut short"]);
}

/// Every byte lies under a checksum: one flipped bit anywhere is never taken for the same file.
#[test]
fn flipped_bits_are_found() {
    let work = Workplace::new();
    ball_boz(&work);
    let bytes = work.read("ball.boz");
    for at in (0..bytes.len()).step_by(bytes.len() / 50) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 1 << (at % 8);
        work.write("damaged.boz", damaged);
        work.refuses(&["verify", "damaged.boz"], &["damaged.boz"]);
        work.refuses(&["bake", "damaged.boz", "-o", "out.boz"], &["damaged.boz", "byte "]);
    }
}
