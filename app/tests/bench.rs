//! The benchmark on a small surface: everything is measured and said; how long it takes is nobody's business here.

mod program;

use program::Workplace;

const KEYS: [&str; 12] = [
    "analysis_ns_per_vertex",
    "synthesis_ns_per_vertex",
    "copy_ns_per_vertex",
    "sparse_ns_per_vertex",
    "two_threads_speedup",
    "scale_ratio",
    "edit_fine_us",
    "edit_scale_ratio",
    "edit_coarse_ms",
    "dab_ms",
    "undo_ratio",
    "open_ms",
];

#[test]
fn every_figure_is_measured() {
    let work = Workplace::new();
    let figures = work.json(&["bench", "--levels", "3"]);
    for key in KEYS {
        let figure = figures[key].as_f64();
        assert!(figure.is_some_and(|x| x.is_finite() && x > 0.0), "{key}: {figures}");
    }
    // Without a graphics adapter there are no frames to time.
    let orbit = &figures["orbit_ratio"];
    assert!(orbit.is_null() || orbit.as_f64() > Some(0.0), "{figures}");
    assert_eq!(figures["vertices"], 258);
    assert!(figures["machine"]["threads"].as_u64() >= Some(1), "{figures}");
    assert!(figures["machine"]["processor"].as_str().is_some_and(|name| !name.is_empty()), "{figures}");
    assert!(work.contents().is_empty(), "nothing is left behind");
}

#[test]
fn people_get_a_table() {
    let text = Workplace::new().succeeds(&["bench", "--levels", "3"]);
    for line in ["machine", "analysis by sparse matrices", "undo over edit", "opening"] {
        assert!(text.contains(line), "{line}: {text}");
    }
}

/// Commands run as processes of their own, and what they take is read off the system.
#[test]
#[cfg(target_os = "linux")]
fn memory_is_measured_by_command() {
    let work = Workplace::new();
    let figures = work.json(&["bench", "--memory", "--levels", "3"]);
    let peaks = figures["peaks"].as_array().expect("a list");
    let vertices: Vec<u64> = peaks.iter().filter_map(|peak| peak["vertices"].as_u64()).collect();
    assert_eq!(vertices, [4098, 4098, 4098, 1026]);
    for peak in peaks {
        assert!(peak["peak_bytes"].as_u64() > Some(1 << 20), "{peak}");
        assert!(peak["file_bytes"].as_u64() > Some(500), "{peak}");
    }
    assert!(work.contents().is_empty(), "nothing is left behind");
    let text = work.succeeds(&["bench", "--memory", "--levels", "3"]);
    assert!(text.contains("import an OBJ"), "{text}");
}

#[test]
fn levels_have_bounds() {
    let outcome = Workplace::new().run(&["bench", "--levels", "2"]);
    assert_eq!(outcome.status, 2, "{outcome:?}");
}
