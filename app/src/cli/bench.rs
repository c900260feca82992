//! `bozzetto bench`: what this machine does with the engine.

use super::output;
use super::progress::Progress;
use crate::bench::{Figures, LEVEL_RANGE, LEVELS, MemoryFigures, measure, peaks};
use crate::figures::{grouped, significant};
use anyhow::Result;
use std::fmt::Write;

/// Measure analysis, synthesis, edits, import, opening and saving on this machine, beside copying the same bytes and the
/// same filters as explicit sparse matrices.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "It takes about a minute and needs 3 GB of memory; other programs under way make it slower.\n\n\
    Example: bozzetto bench\n\
    Example: bozzetto bench --levels 7 --json\n\
    Example: bozzetto bench --memory"
)]
pub(super) struct Args {
    /// How often the surface that is measured is split. Surfaces split two times less and more are measured as well.
    #[arg(long, value_name = "J", default_value_t = LEVELS, value_parser = clap::value_parser!(u8).range(LEVEL_RANGE))]
    levels: u8,
    /// Measure the most memory that importing, editing and saving take instead, each as a process of its own, on the surface
    /// split two times more. Linux alone tells.
    #[arg(long)]
    memory: bool,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// No room for threads or temporary files.
pub(super) fn run(args: &Args) -> Result<()> {
    let progress = Progress::new("Measuring");
    if args.memory {
        let figures = peaks(args.levels + 2, &|done| {
            progress.report(done);
        })?;
        drop(progress);
        return if args.json { output::print_json(&figures) } else { output::print(&memory_text(&figures)) };
    }
    let figures = measure(args.levels, &|done| {
        progress.report(done);
    })?;
    drop(progress);
    if args.json { output::print_json(&figures) } else { output::print(&text(&figures)) }
}

fn memory_text(figures: &MemoryFigures) -> String {
    let mib = |bytes: u64| (bytes as f64 / f64::from(1 << 20)).round();
    let mut text = String::new();
    for peak in &figures.peaks {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{:<44} {:>11} vertices  {:>5} MiB, beyond the file of {} MiB {} bytes a vertex",
            peak.what,
            grouped(peak.vertices),
            mib(peak.peak_bytes),
            mib(peak.file_bytes),
            significant(peak.bytes_per_vertex),
        );
    }
    text
}

fn text(f: &Figures) -> String {
    let m = &f.machine;
    let memory = m.memory_gib.map_or(String::new(), |gib| format!(", {gib:.1} GiB"));
    let mut text = format!(
        "machine      {}, {} threads, {}{memory}, {}\n\
         program      {}\n\
         surface      {} vertices: an octahedron split {} times, 2-disc wavelets\n",
        m.processor,
        m.threads,
        m.instructions,
        m.system,
        f.version,
        grouped(f.vertices as u64),
        f.levels,
    );
    let mut section = |title: &str, lines: &[(&str, f64, &str)]| {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "\n{title}");
        for (what, value, unit) in lines {
            let _ = writeln!(text, "  {what:<42} {:>8} {unit}", significant(*value));
        }
    };
    section(
        "Transform, all levels, one thread",
        &[
            ("analysis", f.analysis_ns_per_vertex, "ns per vertex"),
            ("synthesis", f.synthesis_ns_per_vertex, "ns per vertex"),
            ("copying the vertices", f.copy_ns_per_vertex, "ns per vertex"),
            ("analysis by sparse matrices", f.sparse_ns_per_vertex, "ns per vertex"),
            ("analysis over sparse matrices", f.analysis_ns_per_vertex / f.sparse_ns_per_vertex, "times"),
            ("synthesis over sparse matrices", f.synthesis_ns_per_vertex / f.sparse_ns_per_vertex, "times"),
            ("faster with two threads", f.two_threads_speedup, "times"),
            ("copying, faster with two threads", f.copy_two_threads_speedup, "times"),
            ("a vertex with 256 times as many, 8 faces", f.scale_ratio, "times"),
            ("a vertex with 256 times as many, 400 faces", f.scale_ratio_400_faces, "times"),
        ],
    );
    let touched = format!("a dab on {} vertices", grouped(f.dab_vertices as u64));
    section(
        "Edits, up to the normals and what is to be uploaded",
        &[
            ("a coefficient three levels up, committed", f.edit_fine_us, "µs"),
            ("the same with 16 times as many vertices", f.edit_scale_ratio, "times"),
            ("a coefficient of level 0, committed", f.edit_coarse_ms, "ms"),
            (&touched, f.dab_ms, "ms, neither committed nor shown"),
            ("the same, shown", f.dab_shown_ms, "ms"),
            ("undo over edit", f.undo_ratio, "times"),
        ],
    );
    if let (Some(frame), Some(ratio)) = (f.orbit_frame_ms, f.orbit_ratio) {
        section(
            "Turning the camera, what the window's thread does for a frame",
            &[
                ("with 16 times as many vertices", frame, "ms"),
                ("over that with a sixteenth as many", ratio, "times"),
            ],
        );
    }
    section(
        "Files",
        &[
            ("opening", f.open_ms, "ms"),
            ("saving", f.save_ms, "ms"),
            ("importing a subdivided mesh", f.import_ms, "ms"),
            ("the wavelet file", f.file_bytes as f64 / f64::from(1 << 20), "MiB"),
        ],
    );
    text
}
