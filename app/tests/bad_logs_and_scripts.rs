//! Scripts that ask for what is not there, and logs that are damaged or belong to another file.

mod models;
mod program;

use models::{ball_boz, obj, wavy_ball};
use program::Workplace;

const GOOD: &str = "{\"edit\":\"move\",\"kind\":\"scaling\",\"level\":0,\"vertex\":3,\"delta\":[0,0.2,0]}\n";

#[test]
fn a_script_is_refused_at_the_line_that_is_wrong() {
    let work = Workplace::new();
    ball_boz(&work);
    let moved = |fields: &str| format!("{{\"edit\":\"move\",\"delta\":[0,0.1,0],{fields}}}");
    let lines = [
        ("not JSON at all".to_owned(), "JSON"),
        ("[1,2,3]".to_owned(), "JSON"),
        ("{\"edit\":\"move\"".to_owned(), "JSON"),
        ("{\"colour\":1}".to_owned(), "neither"),
        ("{\"edit\":\"twist\",\"level\":0}".to_owned(), "twist"),
        (moved("\"kind\":\"scaling\",\"level\":4,\"vertex\":0"), "level 4"),
        (moved("\"kind\":\"wavelet\",\"level\":3,\"vertex\":258"), "level 3"),
        (moved("\"kind\":\"scaling\",\"level\":300,\"vertex\":0"), "300"),
        (moved("\"kind\":\"scaling\",\"level\":0,\"vertex\":6"), "6"),
        (moved("\"kind\":\"wavelet\",\"level\":0,\"vertex\":5"), "5"),
        (moved("\"kind\":\"wavelet\",\"level\":0,\"vertex\":18"), "18"),
        (moved("\"kind\":\"scaling\",\"level\":0,\"vertex\":-1"), "-1"),
        (moved("\"kind\":\"hat\",\"level\":0,\"vertex\":0"), "hat"),
        (moved("\"kind\":\"scaling\",\"level\":0"), "vertex"),
        (moved("\"kind\":\"scaling\",\"level\":0,\"vertex\":0,\"colour\":1"), "colour"),
        (moved("\"kind\":\"scaling\",\"level\":0,\"vertex\":0,\"radius\":-1"), "radius"),
        (moved("\"kind\":\"scaling\",\"level\":0,\"vertex\":0,\"radius\":0"), "radius"),
        (moved("\"kind\":\"scaling\",\"level\":0,\"vertex\":0,\"falloff\":\"smooth\""), "radius"),
        (moved("\"kind\":\"scaling\",\"level\":0,\"vertex\":0,\"v\":3"), "version 3"),
        (GOOD.trim_end().replace("0.2", "1e9"), "beyond"),
        (GOOD.trim_end().replace("0.2", "\"up\""), "up"),
        (GOOD.trim_end().replace("[0,0.2,0]", "[0,0.2]"), "3"),
        ("{\"edit\":\"gain\",\"level\":3,\"factor\":2}".to_owned(), "level 3"),
        ("{\"edit\":\"gain\",\"level\":0,\"factor\":1e12}".to_owned(), "beyond"),
        ("{\"edit\":\"gain\",\"level\":0}".to_owned(), "factor"),
        ("{\"undo\":2}".to_owned(), "only 1"),
        ("{\"redo\":1}".to_owned(), "only 0"),
        ("{\"undo\":0}".to_owned(), "positive"),
        ("{\"undo\":-1}".to_owned(), "positive"),
        ("{\"undo\":1,\"redo\":1}".to_owned(), "undo"),
        (GOOD.trim_end().replace('}', ",\"crc\":\"00000000\"}"), "checksum"),
        (GOOD.trim_end().replace('}', ",\"hash\":\"00000000000000000000000000000000\"}"), "hash"),
        (GOOD.trim_end().replace('}', ",\"hash\":\"xyz\"}"), "hash"),
        ("{\"log\":1,\"of\":\"00000000000000000000000000000000\"}".to_owned(), "once"),
    ];
    for (line, what) in lines {
        for after in ["", "\n", &format!("\n{GOOD}")] {
            work.write("script.edits", format!("{GOOD}{line}{after}"));
            let sentence = work.refuses(
                &["replay", "ball.boz", "script.edits", "-o", "out.boz", "--json"],
                &["script.edits", "line 2", what],
            );
            assert!(sentence.len() < 400, "{sentence}");
        }
    }
}

#[test]
fn comments_and_blank_lines_are_no_edits() {
    let work = Workplace::new();
    ball_boz(&work);
    work.write("script.edits", format!("# up\n\n{GOOD}  \n{{\"undo\":1}}\n# and again\n{{\"redo\":1}}"));
    let report = work.json(&["replay", "ball.boz", "script.edits", "-o", "out.boz"]);
    assert_eq!(report["edits"], 1);
}

/// Writes `work.boz` with a log of three edits beside it.
fn logged(work: &Workplace) {
    ball_boz(work);
    work.write("script.edits", GOOD.repeat(3));
    work.succeeds(&["replay", "ball.boz", "script.edits", "-o", "work.boz"]);
}

/// Every command that opens a wavelet file with its log.
const COMMANDS: [&[&str]; 8] = [
    &["info", "work.boz", "--json"],
    &["export", "work.boz", "-o", "out.obj"],
    &["coefficients", "work.boz", "--csv", "out.csv"],
    &["compare", "work.boz", "ball.boz", "--json"],
    &["replay", "work.boz", "script.edits", "-o", "out.boz", "--onto-log"],
    &["bake", "work.boz", "-o", "out.boz"],
    &["verify", "work.boz"],
    &["render", "work.boz", "-o", "out.png"],
];

#[test]
fn a_log_of_another_file_is_refused() {
    let work = Workplace::new();
    logged(&work);
    work.write("other.obj", obj(&wavy_ball(2)));
    work.succeeds(&["import", "other.obj", "-o", "other.boz"]);
    work.write("work.boz", work.read("other.boz"));
    for command in COMMANDS {
        work.refuses(command, &["work.edits", "another wavelet file", "--rebind"]);
    }
    // As a script it is refused too, unless one insists.
    let replay = ["replay", "other.boz", "work.edits", "-o", "out.boz"];
    work.refuses(&replay, &["work.edits", "--rebind"]);
    assert_eq!(work.json(&[&replay[..], &["--rebind"]].concat())["edits"], 3);
    // Without its log the file opens.
    assert_eq!(work.json(&["info", "work.boz", "--base"])["levels"], 2);
}

#[test]
fn a_damaged_log_is_refused_and_kept() {
    let work = Workplace::new();
    logged(&work);
    let log = work.text("work.edits");
    let lines: Vec<&str> = log.lines().collect();
    assert_eq!(lines.len(), 5, "binding, three edits, save mark: {log}");
    let changed = |bad: &str| [lines[0], lines[1], bad, lines[3], lines[4], ""].join("\n");
    for bad in ["junk", "{}", &lines[2].replace("0.2", "0.3"), &lines[2][..40], GOOD.trim_end()] {
        work.write("work.edits", changed(bad));
        for command in COMMANDS {
            work.refuses(command, &["work.edits", "line 3"]);
        }
        // A script's line needs no checksum; for the rest the log is no better as a script.
        if bad != GOOD.trim_end() {
            work.refuses(&["replay", "ball.boz", "work.edits", "-o", "out.boz"], &["work.edits", "line 3"]);
        }
    }
    assert_eq!(work.json(&["info", "work.boz", "--base"])["levels"], 3);
}

#[test]
fn a_torn_last_line_is_left_out_with_a_note() {
    let work = Workplace::new();
    logged(&work);
    let log = work.read("work.edits");
    let ends: Vec<usize> = (0..log.len()).filter(|&at| log[at] == b'\n').map(|at| at + 1).collect();
    let hash_after = |edits: usize| {
        work.write("part.edits", GOOD.repeat(edits));
        let report = work.json(&["replay", "ball.boz", "part.edits", "-o", "baked.boz", "--bake"]);
        report["hash"].as_str().expect("a hash").to_owned()
    };
    for (edits, end) in [(0, ends[0]), (1, ends[1]), (2, ends[2]), (3, ends[3])] {
        for torn in [0, 1, 5, 40] {
            work.write("work.edits", &log[..end + torn]);
            let info = work.run(&["info", "work.boz", "--json"]);
            assert_eq!(info.status, 0, "{info:?}");
            let note = info.stderr.starts_with("note: ") && info.stderr.contains("work.edits");
            assert_eq!(note, torn > 0, "{torn} bytes of a line: {info:?}");
            assert_eq!(program::one_object(&info.stdout)["hash"], hash_after(edits), "{edits} edits");
        }
    }
}
