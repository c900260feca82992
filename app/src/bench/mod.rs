//! What this machine does with the engine: the measurements behind `bozzetto bench`.
//!
//! Everything is measured on the same wavy ball, an octahedron split nine times unless another level is asked for, with
//! the 2-disc wavelet. Figures are medians of repeated runs; baselines are measured by turns with what they are compared
//! to, in the same run.

mod edits;
mod files;
mod machine;
mod memory;
mod orbit;
mod shape;
mod sparse;
mod timings;
mod transform;

use anyhow::Result;
use bozzetto_core::hierarchy::Level;
use edits::{Sculpture, dab};
use machine::Machine;
pub(crate) use memory::{MemoryFigures, peaks};
use serde::Serialize;
use shape::Base;

/// Levels of the surface that is measured, if nothing else is asked for: 1,048,578 vertices.
pub(crate) const LEVELS: u8 = 9;

/// The levels that can be asked for: two fewer and two more are measured as well.
pub(crate) const LEVEL_RANGE: std::ops::RangeInclusive<i64> = 3..=10;

/// The share of the surface that a dab touches: 38,880 of 1,048,578 vertices.
const DAB: f64 = 38_880.0 / 1_048_578.0;

/// All figures.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Figures {
    /// The program's version.
    pub(crate) version: &'static str,
    /// What it ran on.
    pub(crate) machine: Machine,
    /// Levels of the surface.
    pub(crate) levels: u8,
    /// Its vertices.
    pub(crate) vertices: usize,
    /// Analysis of all levels, one thread.
    pub(crate) analysis_ns_per_vertex: f64,
    /// Synthesis of all levels, one thread.
    pub(crate) synthesis_ns_per_vertex: f64,
    /// Copying the finest level's vertices.
    pub(crate) copy_ns_per_vertex: f64,
    /// Analysis of all levels by explicit sparse matrices, one thread.
    pub(crate) sparse_ns_per_vertex: f64,
    /// Analysis and synthesis: one thread's time over two threads'.
    pub(crate) two_threads_speedup: f64,
    /// Copying the finest level's vertices: one thread's time over two threads'. What memory alone allows.
    pub(crate) copy_two_threads_speedup: f64,
    /// Cost per vertex two levels finer over that two levels coarser: analysis or synthesis, whichever is more.
    pub(crate) scale_ratio: f64,
    /// The same over 400 base faces, with five levels fewer and one fewer.
    pub(crate) scale_ratio_400_faces: f64,
    /// A scaling coefficient three levels above the finest, committed and shown.
    pub(crate) edit_fine_us: f64,
    /// The same on the surface two levels finer, over that.
    pub(crate) edit_scale_ratio: f64,
    /// A scaling coefficient of level 0, committed and shown.
    pub(crate) edit_coarse_ms: f64,
    /// A brush dab, neither committed nor shown.
    pub(crate) dab_ms: f64,
    /// The same with the normals and what is to be uploaded.
    pub(crate) dab_shown_ms: f64,
    /// The vertices it touched.
    pub(crate) dab_vertices: usize,
    /// Undo over edit, of the two edits the one where it is more.
    pub(crate) undo_ratio: f64,
    /// Processor time of the window's thread for a frame while the camera goes round, two levels finer; none without a
    /// graphics adapter.
    pub(crate) orbit_frame_ms: Option<f64>,
    /// The same over that two levels coarser.
    pub(crate) orbit_ratio: Option<f64>,
    /// Whether the adapter held both surfaces; a software one does not hold 16 million vertices, and draws none of them.
    pub(crate) orbit_drawn: Option<bool>,
    /// A wavelet file to a surface.
    pub(crate) open_ms: f64,
    /// A surface to a wavelet file on disk.
    pub(crate) save_ms: f64,
    /// A binary PLY with subdivision connectivity to a surface.
    pub(crate) import_ms: f64,
    /// The wavelet file's size.
    pub(crate) file_bytes: u64,
}

/// Measures everything on the octahedron split `levels` times. `progress` gets the share done.
///
/// # Errors
/// No room for threads or temporary files.
pub(crate) fn measure(levels: u8, progress: &dyn Fn(f32)) -> Result<Figures> {
    let share = |from: f32, to: f32| move |done: f32| progress(from + (to - from) * done);
    let surface = Base::EightFaces.surface(levels)?;
    let vertices = surface.scaling(surface.finest()).len();
    let transform = transform::transforms(&surface, 11, &share(0.05, 0.2))?;
    let scale_ratio = transform::growth(Base::EightFaces, [levels - 2, levels + 2], 5, &share(0.2, 0.4))?;
    let many = [levels.saturating_sub(5).max(1), levels - 1];
    let scale_ratio_400_faces = transform::growth(Base::FourHundredFaces, many, 5, &share(0.4, 0.55))?;

    // The editor's thread makes edits with the pool of all.
    progress(0.55);
    let mut sculpture = Sculpture::new(surface);
    let fine = sculpture.move_and_undo(Level(levels - 3), 301)?;
    let coarse = sculpture.move_and_undo(Level::BASE, 40)?;
    let surface = sculpture.into_surface();
    progress(0.6);
    let dab = dab(surface.clone(), (vertices as f64 * DAB).ceil() as usize, 9)?;
    progress(0.7);
    let files = files::files(surface, 3, &share(0.7, 0.8))?;
    let mut sculpture = Sculpture::new(Base::EightFaces.surface(levels + 2)?);
    progress(0.85);
    let large = sculpture.move_and_undo(Level(levels - 1), 301)?;
    let sizes = [Base::EightFaces.surface(levels - 2)?, sculpture.into_surface()];
    let orbit = orbit::frames(sizes, 51, &share(0.87, 1.0))?;
    Ok(Figures {
        version: env!("CARGO_PKG_VERSION"),
        machine: Machine::here(),
        levels,
        vertices,
        analysis_ns_per_vertex: transform.analysis,
        synthesis_ns_per_vertex: transform.synthesis,
        copy_ns_per_vertex: transform.copy,
        sparse_ns_per_vertex: transform.sparse,
        two_threads_speedup: transform.two_threads_speedup,
        copy_two_threads_speedup: transform.copy_two_threads_speedup,
        scale_ratio,
        scale_ratio_400_faces,
        edit_fine_us: fine.seconds * 1e6,
        edit_scale_ratio: large.seconds / fine.seconds,
        edit_coarse_ms: coarse.seconds * 1e3,
        dab_ms: dab.seconds * 1e3,
        dab_shown_ms: dab.shown * 1e3,
        dab_vertices: dab.vertices,
        undo_ratio: fine.undo_ratio.max(coarse.undo_ratio),
        orbit_frame_ms: orbit.map(|frames| frames.seconds[1] * 1e3),
        orbit_ratio: orbit.map(|frames| frames.seconds[1] / frames.seconds[0]),
        orbit_drawn: orbit.map(|frames| frames.drawn),
        open_ms: files.open * 1e3,
        save_ms: files.save * 1e3,
        import_ms: files.import * 1e3,
        file_bytes: files.bytes,
    })
}
