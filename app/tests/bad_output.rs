//! Outputs that cannot be written, and arguments that mean nothing.

mod models;
mod program;

use models::{ball_boz, grey_png};
use program::Workplace;
use std::collections::BTreeMap;

/// Every command that writes a file, `OUTPUT` standing for its name without the extension that follows.
const WRITERS: [(&[&str], &str); 9] = [
    (&["import", "ball.obj", "-o", "OUTPUT"], "boz"),
    (&["globe", "grey.png", "-o", "OUTPUT", "--levels", "2"], "boz"),
    (&["export", "ball.boz", "-o", "OUTPUT"], "obj"),
    (&["export", "ball.boz", "-o", "OUTPUT", "--level", "1"], "glb"),
    (&["coefficients", "ball.boz", "--csv", "OUTPUT"], "csv"),
    (&["replay", "ball.boz", "script.edits", "-o", "OUTPUT"], "boz"),
    (&["replay", "ball.boz", "script.edits", "--bake", "-o", "OUTPUT"], "boz"),
    (&["bake", "ball.boz", "-o", "OUTPUT"], "boz"),
    (&["render", "ball.boz", "-o", "OUTPUT"], "png"),
];

fn workplace() -> Workplace {
    let work = Workplace::new();
    ball_boz(&work);
    work.write("script.edits", "{\"edit\":\"gain\",\"level\":1,\"factor\":2}\n");
    work.write("grey.png", grey_png(4, 2, |x, y| (1000 * x + y) as u16));
    work
}

fn refuses_output(work: &Workplace, command: &[&str], output: &str) {
    let arguments: Vec<&str> = command.iter().map(|&a| if a == "OUTPUT" { output } else { a }).collect();
    work.refuses(&arguments, &[output]);
}

#[test]
fn outputs_into_missing_folders() {
    let work = workplace();
    for (command, extension) in WRITERS {
        refuses_output(&work, command, &format!("missing/out.{extension}"));
        refuses_output(&work, command, &format!("ball.obj/out.{extension}"));
    }
}

#[test]
fn outputs_that_are_folders() {
    let work = workplace();
    for extension in ["boz", "obj", "glb", "csv", "png"] {
        std::fs::create_dir(work.path(&format!("folder.{extension}"))).expect("a folder");
    }
    for (command, extension) in WRITERS {
        refuses_output(&work, command, &format!("folder.{extension}"));
    }
}

/// A name that belongs to another kind of file is refused, so a slip never replaces an input.
#[test]
fn outputs_with_a_wrong_extension() {
    let work = workplace();
    for (command, _) in WRITERS {
        for output in ["out", "out.", "out.xyz", "script.edits"] {
            refuses_output(&work, command, output);
        }
    }
    for (command, extension) in WRITERS {
        if extension != "boz" {
            refuses_output(&work, command, "ball.boz");
        } else {
            refuses_output(&work, command, "ball.obj");
        }
    }
}

/// The log of a replay's output takes the place of no history and no lone log, and a script is kept.
#[test]
fn logs_that_would_be_lost() {
    let work = workplace();
    work.succeeds(&["replay", "ball.boz", "script.edits", "-o", "work.boz"]);
    work.write("lone.edits", work.read("work.edits"));
    let before = work.contents();
    for command in [
        &["replay", "work.boz", "script.edits", "-o", "work.boz"][..],
        &["replay", "ball.boz", "script.edits", "-o", "lone.boz"],
    ] {
        let output = command[4].replace(".boz", ".edits");
        work.refuses(command, &[&output]);
    }
    assert!(work.contents() == before);
    // A script whose name the output's log takes is kept.
    for copy in ["script.edits.script", "script.edits.script2"] {
        let script = work.text("script.edits");
        work.succeeds(&["replay", "ball.boz", "script.edits", "-o", "script.boz"]);
        assert_eq!(work.text(copy), script);
    }
    work.write("script.edits", &before["script.edits"]);
    for name in ["script.boz", "script.edits.script", "script.edits.script2"] {
        std::fs::remove_file(work.path(name)).expect("it is there");
    }
    // A pair may be made anew, and a file may go on from its own log.
    work.succeeds(&["replay", "ball.boz", "script.edits", "-o", "work.boz"]);
    assert!(work.contents() == before);
    work.succeeds(&["replay", "work.boz", "script.edits", "-o", "work.boz", "--onto-log"]);
    assert!(work.text("work.edits").starts_with(work_log(&before).as_str()));
}

fn work_log(contents: &BTreeMap<String, Vec<u8>>) -> String {
    String::from_utf8(contents["work.edits"].clone()).expect("text")
}

/// What a link leads to is replaced, and a new file is as readable as the system's usual ones.
#[cfg(unix)]
#[test]
fn outputs_through_a_link() {
    let work = workplace();
    std::fs::create_dir(work.path("elsewhere")).expect("a folder");
    work.write("elsewhere/real.obj", "old");
    std::os::unix::fs::symlink("elsewhere/real.obj", work.path("link.obj")).expect("a link");
    work.succeeds(&["export", "ball.boz", "-o", "link.obj"]);
    assert!(work.path("link.obj").is_symlink());
    assert!(work.text("elsewhere/real.obj").contains("\nv "));
    let mode = |name: &str| {
        use std::os::unix::fs::PermissionsExt;
        std::fs::metadata(work.path(name)).expect("a file").permissions().mode()
    };
    work.succeeds(&["export", "ball.boz", "-o", "new.obj"]);
    assert_eq!(mode("new.obj"), mode("script.edits"));
}

/// A wavelet file without a log is not put beside a log of something else.
#[test]
fn outputs_beside_a_log() {
    let work = workplace();
    work.succeeds(&["replay", "ball.boz", "script.edits", "-o", "work.boz"]);
    for command in [
        &["import", "ball.obj", "-o", "work.boz"][..],
        &["globe", "grey.png", "-o", "work.boz", "--levels", "2"],
        &["replay", "ball.boz", "script.edits", "--bake", "-o", "work.boz"],
        &["bake", "ball.boz", "-o", "work.boz"],
    ] {
        work.refuses(command, &["work.edits"]);
    }
}

#[test]
fn levels_and_coefficients_that_do_not_exist() {
    let work = workplace();
    let level = ["ball.boz", "level 4 does not exist"];
    work.refuses(&["export", "ball.boz", "-o", "out.obj", "--level", "4"], &level);
    work.refuses(&["render", "ball.boz", "-o", "out.png", "--level", "4"], &level);
    for overlay in ["edges=4", "handles=4", "control=4", "scaling=4/0", "wavelet=4/0"] {
        work.refuses(&["render", "ball.boz", "-o", "out.png", "--overlay", overlay], &level);
    }
    for overlay in ["scaling=0/6", "wavelet=0/5", "wavelet=0/18", "wavelet=3/300"] {
        work.refuses(&["render", "ball.boz", "-o", "out.png", "--overlay", overlay], &["ball.boz"]);
    }
    work.refuses(&["verify", "ball.obj"], &["ball.obj", ".boz"]);
    work.refuses(&["import", "ball.obj", "-o", "out.boz", "--base-faces", "7"], &["ball.obj", "8 faces"]);
    work.refuses(&["globe", "grey.png", "-o", "out.boz", "--levels", "0"], &["grey.png", "--levels"]);
    work.refuses(&["globe", "grey.png", "-o", "out.boz", "--relief", "-99"], &["grey.png", "--relief"]);
    work.refuses(&["globe", "grey.png", "-o", "out.boz", "--radius-grid"], &["grey.png", "not positive"]);
}

#[test]
fn arguments_that_mean_nothing() {
    let work = workplace();
    let before = work.contents();
    for arguments in [
        &["import"][..],
        &["import", "ball.obj"],
        &["import", "ball.obj", "-o", "out.boz", "--wavelet", "3"],
        &["import", "ball.obj", "-o", "out.boz", "--levels", "16"],
        &["import", "ball.obj", "-o", "out.boz", "--precision", "26"],
        &["import", "ball.obj", "-o", "out.boz", "--remesh", "perhaps"],
        &["import", "ball.obj", "-o", "out.boz", "--tolerance", "close"],
        &["import", "ball.obj", "-o", "out.boz", "--tolerance", "nan"],
        &["import", "ball.obj", "-o", "out.boz", "--tolerance", "0"],
        &["import", "ball.obj", "-o", "out.boz", "--tolerance=-1"],
        &["import", "ball.obj", "-o", "out.boz", "--tolerance", "inf"],
        &["import", "ball.obj", "-o", "out.boz", "--scheme", "butterfly"],
        &["compare", "ball.boz", "ball.obj", "--samples", "0"],
        &["info"],
        &["info", "ball.boz", "--base", "--saved"],
        &["info", "ball.boz", "more.boz"],
        &["export", "ball.boz", "-o", "out.obj", "--level", "-1"],
        &["export", "ball.boz", "-o", "out.obj", "--keep", "1.5"],
        &["export", "ball.boz", "-o", "out.obj", "--keep", "nan"],
        &["coefficients", "ball.boz"],
        &["compare", "ball.boz"],
        &["replay", "ball.boz", "script.edits"],
        &["replay", "ball.boz", "script.edits", "-o", "out.boz", "--threads", "0"],
        &["globe", "grey.png", "-o", "out.boz", "--radius-grid", "--relief", "1"],
        &["render", "ball.boz", "-o", "out.png", "--size", "0x10"],
        &["render", "ball.boz", "-o", "out.png", "--size", "99999x10"],
        &["render", "ball.boz", "-o", "out.png", "--view", "sideways"],
        &["render", "ball.boz", "-o", "out.png", "--overlay", "stars"],
        &["--unknown"],
    ] {
        let outcome = work.run(arguments);
        assert_eq!((outcome.status, outcome.stdout.as_str()), (2, ""), "{arguments:?}: {outcome:?}");
        assert!(outcome.stderr.starts_with("error: "), "{arguments:?}: {outcome:?}");
        assert!(outcome.stderr.contains("--help"), "{arguments:?} points to the help: {outcome:?}");
    }
    assert!(before == work.contents(), "nothing is written");
}

/// A full disk behind standard output is a failure, not a panic.
#[cfg(target_os = "linux")]
#[test]
fn standard_output_that_is_full() {
    let work = workplace();
    for arguments in [
        &["info", "ball.boz"][..],
        &["info", "ball.boz", "--json"],
        &["compare", "ball.boz", "ball.obj"],
        &["verify", "ball.boz"],
        &["bake", "ball.boz", "-o", "out.boz"],
    ] {
        let full = std::fs::File::create("/dev/full").expect("a device");
        let outcome = work.run_into(arguments, full.into());
        assert_eq!(outcome.status, 1, "{arguments:?}: {outcome:?}");
        assert!(outcome.stderr.starts_with("error: stdout"), "{arguments:?}: {outcome:?}");
    }
}
