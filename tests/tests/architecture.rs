//! The house's borders, held by reading the sources: who may import whom, and what the core must not do.

use std::fs;
use std::path::{Path, PathBuf};

/// The core's modules: each may import those before it, and no others.
const CORE: [&str; 12] = [
    "memory",
    "disk",
    "mesh",
    "io",
    "hierarchy",
    "wavelet",
    "conversion",
    "surface",
    "edit",
    "file",
    "lod",
    "session",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ lies in the workspace").to_owned()
}

/// All Rust files below a folder, or the file itself.
fn sources(at: &Path) -> Vec<PathBuf> {
    if at.is_file() {
        return vec![at.to_owned()];
    }
    let entries = fs::read_dir(at).unwrap_or_else(|e| panic!("{}: {e}", at.display()));
    entries
        .map(|entry| entry.expect("readable").path())
        .flat_map(|path| if path.is_dir() { sources(&path) } else { vec![path] })
        .filter(|path| path.extension().is_some_and(|e| e == "rs"))
        .collect()
}

/// The lines of a file that are code, with their numbers: no comments, and nothing from the first test module on.
fn code(path: &Path) -> Vec<(usize, String)> {
    let text = fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    text.lines()
        .take_while(|line| !line.contains("#[cfg(test)]"))
        .enumerate()
        .filter(|(_, line)| !line.trim_start().starts_with("//"))
        .map(|(at, line)| (at + 1, line.to_owned()))
        .collect()
}

/// Asserts that no code below `at` holds any of the words.
fn assert_free_of(at: &str, words: &[&str]) {
    for path in sources(&root().join(at)) {
        for (number, line) in code(&path) {
            for word in words {
                assert!(!line.contains(word), "{}:{number} holds {word:?}: {line}", path.display());
            }
        }
    }
}

#[test]
fn imports_in_the_core_point_up_the_list() {
    for (place, module) in CORE.iter().enumerate() {
        for path in sources(&root().join("core/src").join(module)) {
            for (number, line) in code(&path) {
                for later in &CORE[place + 1..] {
                    let import = format!("crate::{later}::");
                    assert!(!line.contains(&import), "{}:{number}: {module} imports {later}", path.display());
                }
            }
        }
    }
}

#[test]
fn every_module_of_the_core_is_in_the_list() {
    let lib = fs::read_to_string(root().join("core/src/lib.rs")).expect("readable");
    let modules: Vec<&str> =
        lib.lines().filter_map(|line| line.trim().strip_prefix("pub mod ")?.strip_suffix(';')).collect();
    assert!(modules.iter().all(|m| CORE.contains(m)), "{modules:?}");
    assert_eq!(modules.len(), CORE.len(), "{modules:?}");
}

#[test]
fn the_core_prints_nothing_and_knows_no_window() {
    assert_free_of("core/src", &["println!", "eprintln!", "print!(", "dbg!", "egui", "wgpu", "rfd::"]);
}

#[test]
fn the_renderer_knows_no_panels_and_no_surface() {
    assert_free_of("app/src/render", &["crate::editor", "crate::cli", "crate::display", "bozzetto_core"]);
}

#[test]
fn panels_and_tools_know_no_device() {
    let device = ["wgpu", "SurfaceRenderer", "Viewport"];
    assert_free_of("app/src/editor/panels", &device);
    assert_free_of("app/src/editor/tools", &device);
    assert_free_of("app/src/editor/tools", &["panels"]);
}

#[test]
fn command_line_and_editor_do_not_lean_on_each_other() {
    assert_free_of("app/src/editor", &["crate::cli"]);
    for path in sources(&root().join("app/src/cli")) {
        let leaning = code(&path).into_iter().filter(|(_, line)| line.contains("crate::editor"));
        // Without a command the program opens the editor: the one place where it is named.
        let allowed = usize::from(path.ends_with("cli/mod.rs"));
        assert!(leaning.count() <= allowed, "{}", path.display());
    }
}

#[test]
fn a_report_needs_no_window_and_no_command() {
    assert_free_of("app/src/report", &["crate::editor", "crate::cli", "egui"]);
    assert_free_of("app/src/opening", &["crate::editor", "crate::cli", "crate::report", "crate::render"]);
    assert_free_of("app/src/editor", &["crate::report"]);
}

#[test]
fn files_stay_small() {
    for folder in ["core/src", "app/src", "assets/src"] {
        for path in sources(&root().join(folder)) {
            let lines = fs::read_to_string(&path).expect("readable").lines().count();
            assert!(lines <= 500, "{}: {lines} lines", path.display());
        }
    }
}
