//! Running the program as its users do: in a folder of its own, with arguments, looking at what comes out.
//!
//! Every test file is a program of its own and uses its part of this.
#![allow(dead_code, unreachable_pub)]

use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use tempfile::TempDir;

/// A fresh folder in which the program runs; it goes away with its value.
pub struct Workplace {
    folder: TempDir,
}

/// What a run of the program left: exit status and both streams.
#[derive(Debug)]
pub struct Outcome {
    /// The exit status; −1 if a signal ended it.
    pub status: i32,
    /// Everything on standard output.
    pub stdout: String,
    /// Everything on standard error.
    pub stderr: String,
}

impl Workplace {
    /// An empty folder.
    pub fn new() -> Self {
        Self { folder: TempDir::new().expect("a temporary folder") }
    }

    /// The path of a name in the folder.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file.
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        std::fs::write(self.path(name), content).expect("the folder can be written");
    }

    /// The bytes of a file.
    pub fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// The text of a file.
    pub fn text(&self, name: &str) -> String {
        String::from_utf8(self.read(name)).expect("text")
    }

    /// Every file in the folder with its bytes, locks left out: some systems keep them, empty.
    pub fn contents(&self) -> BTreeMap<String, Vec<u8>> {
        let mut contents = BTreeMap::new();
        collect(self.folder.path(), "", &mut contents);
        contents
    }

    /// Runs the program.
    pub fn run(&self, arguments: &[&str]) -> Outcome {
        self.run_with(arguments, &[])
    }

    /// Runs the program with additional environment variables.
    pub fn run_with(&self, arguments: &[&str], environment: &[(&str, &str)]) -> Outcome {
        Outcome::of(self.command(arguments).envs(environment.iter().copied()))
    }

    /// Runs the program with its standard output led elsewhere.
    pub fn run_into(&self, arguments: &[&str], stdout: Stdio) -> Outcome {
        Outcome::of(self.command(arguments).stdout(stdout))
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_bozzetto"));
        command.args(arguments).current_dir(self.folder.path()).stdin(Stdio::null());
        // Without it, libraries that look for a window system complain on standard error.
        command.env("XDG_RUNTIME_DIR", self.folder.path());
        command
    }

    /// Runs the program, which must succeed and say nothing on standard error; gives its standard output.
    #[track_caller]
    pub fn succeeds(&self, arguments: &[&str]) -> String {
        let outcome = self.run(arguments);
        assert!(outcome.status == 0 && outcome.stderr.is_empty(), "{arguments:?}: {outcome:?}");
        outcome.stdout
    }

    /// Runs a command with `--json`, which must print one object and nothing else.
    #[track_caller]
    pub fn json(&self, arguments: &[&str]) -> Value {
        let outcome = self.run(&[arguments, &["--json"]].concat());
        assert!(outcome.status == 0 && outcome.stderr.is_empty(), "{arguments:?}: {outcome:?}");
        one_object(&outcome.stdout)
    }

    /// Runs the program, which must fail with status 1 and one sentence that holds all of `naming`, print nothing, and
    /// leave every file as it was. Gives the sentence.
    #[track_caller]
    pub fn refuses(&self, arguments: &[&str], naming: &[&str]) -> String {
        let before = self.contents();
        let outcome = self.run(arguments);
        assert_eq!(outcome.status, 1, "{arguments:?}: {outcome:?}");
        assert_eq!(outcome.stdout, "", "{arguments:?} prints nothing");
        let sentence = outcome.stderr;
        assert_one_sentence(&sentence);
        for name in naming {
            assert!(sentence.contains(name), "{arguments:?} names {name}: {sentence}");
        }
        let after = self.contents();
        let names = |contents: &BTreeMap<String, Vec<u8>>| contents.keys().cloned().collect::<Vec<_>>();
        assert_eq!(names(&before), names(&after), "{arguments:?} leaves no other files");
        assert!(before == after, "{arguments:?} leaves every file as it was");
        sentence
    }
}

impl Outcome {
    fn of(command: &mut Command) -> Self {
        let output = command.output().expect("the program starts");
        Self {
            status: output.status.code().unwrap_or(-1),
            stdout: String::from_utf8(output.stdout).expect("standard output is text"),
            stderr: String::from_utf8(output.stderr).expect("standard error is text"),
        }
    }
}

/// Says that a test was skipped, where the test harness does not swallow it.
pub fn skipped(what: &str, why: &str) {
    let _ = writeln!(std::io::stderr(), "\n*** SKIPPED: {what}: {why}");
}

/// One JSON object in one line, and nothing else.
#[track_caller]
pub fn one_object(stdout: &str) -> Value {
    assert_eq!(stdout.matches('\n').count(), 1, "one line: {stdout}");
    let value: Value = serde_json::from_str(stdout).unwrap_or_else(|e| panic!("{e}: {stdout}"));
    assert!(value.is_object(), "an object: {stdout}");
    value
}

/// `error: `, one line, nothing said twice, no trace of a panic.
#[track_caller]
fn assert_one_sentence(stderr: &str) {
    let line = stderr.strip_suffix('\n').unwrap_or_else(|| panic!("a whole line: {stderr:?}"));
    let sentence = line.strip_prefix("error: ").unwrap_or_else(|| panic!("an error: {stderr:?}"));
    assert!(!sentence.contains(['\n', '\r']), "one line: {stderr:?}");
    for trace in ["panicked", "RUST_BACKTRACE", "unwrap", "src/", ".bozzetto-"] {
        assert!(!sentence.contains(trace), "{trace} is not for users: {stderr:?}");
    }
    for part in sentence.split("; ").flat_map(|half| half.split(": ")).filter(|part| part.len() > 12) {
        assert_eq!(sentence.matches(part).count(), 1, "said once: {stderr:?}");
    }
}

fn collect(folder: &Path, prefix: &str, contents: &mut BTreeMap<String, Vec<u8>>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let entry = entry.expect("an entry");
        let name = format!("{prefix}{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            collect(&entry.path(), &format!("{name}/"), contents);
            contents.insert(name + "/", Vec::new());
        } else if !name.ends_with(".edits.lock") {
            contents.insert(name, std::fs::read(entry.path()).expect("a file"));
        }
    }
}
