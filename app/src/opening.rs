//! Opening files, for command line and editor alike.

use anyhow::{Result, anyhow};
use bozzetto_core::conversion::remesh::Phase;
use bozzetto_core::conversion::{ConversionOptions, Converted, convert_with_progress};
use bozzetto_core::disk::{Disk, Vfs};
use bozzetto_core::file::{Metadata, Model, source_by_public_id};
use bozzetto_core::hierarchy::Slot;
use bozzetto_core::io::read_mesh;
use bozzetto_core::mesh::TriangleMesh;
use bozzetto_core::surface::{FormOptions, Surface};
use sha2::{Digest, Sha256};
use std::path::Path;

/// Whether a path names a wavelet file.
pub(crate) fn is_wavelet_file(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("boz"))
}

/// How to import a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ImportOptions {
    /// How to find its hierarchy.
    pub conversion: ConversionOptions,
    /// The wavelet form to bring it into.
    pub form: FormOptions,
}

/// A mesh file as a model, with what was done to the mesh on the way.
pub(crate) struct Imported {
    /// The model.
    pub(crate) model: Model,
    /// One sentence each.
    pub(crate) cleaned: Vec<String>,
    /// Root mean square and maximum of the distance to the mesh, over the bounding-box diagonal: measured both ways
    /// where the mesh was remeshed; with the mesh's own connectivity how far its vertices were moved to whole steps,
    /// which bounds both ways.
    pub(crate) distance: [f64; 2],
}

/// Imports a mesh file. `progress` gets the share done and returns whether to go on.
///
/// # Errors
/// The file cannot be read or is not a surface.
pub(crate) fn import_file(
    path: &Path,
    options: &ImportOptions,
    progress: &dyn Fn(f32) -> bool,
) -> Result<Imported> {
    import(path, &read_mesh(path)?, options, progress)
}

/// Imports a mesh that was read from a file.
///
/// # Errors
/// It is not a surface.
pub(crate) fn import(
    path: &Path,
    mesh: &TriangleMesh,
    options: &ImportOptions,
    progress: &dyn Fn(f32) -> bool,
) -> Result<Imported> {
    let named = |sentence: String| anyhow!("{}: {sentence}", path.display());
    let by_phase = |phase, done: f32| progress(share_of(phase, done));
    let Converted { hierarchy, positions, source, cleaned, measured } =
        convert_with_progress(mesh, &options.conversion, &by_phase).map_err(|e| named(e.to_string()))?;
    let surface =
        Surface::from_positions(hierarchy, &positions, &options.form).map_err(|e| named(e.to_string()))?;
    let source = source.map(|by_slot| source_by_public_id(surface.hierarchy(), &by_slot));
    let distance = match measured {
        Some(measured) => [measured.rms, measured.max],
        None => displacement(&surface, &positions, mesh.diagonal()),
    };
    Ok(Imported { model: Model::new(surface, source, metadata_of(path)), cleaned, distance })
}

/// The share of a whole import that is done; fitting takes most of the time.
fn share_of(phase: Phase, done: f32) -> f32 {
    let (from, to) = match phase {
        Phase::Clean => (0.0, 0.03),
        Phase::Simplify => (0.03, 0.12),
        Phase::Resample => (0.12, 0.15),
        Phase::Relax => (0.15, 0.22),
        Phase::Fit => (0.22, 0.92),
        Phase::Measure => (0.92, 1.0),
    };
    from + (to - from) * done.clamp(0.0, 1.0)
}

/// Root mean square and maximum of the distances between positions and the surface's own, over `diagonal`.
fn displacement(surface: &Surface, positions: &[[f64; 3]], diagonal: f64) -> [f64; 2] {
    let finest = surface.finest();
    let squared = |(slot, wanted): (usize, &[f64; 3])| -> f64 {
        let placed = surface.position(finest, Slot(slot as u32));
        (0..3).map(|c| (placed[c] - wanted[c]) * (placed[c] - wanted[c])).sum()
    };
    let (sum, most) = positions
        .iter()
        .enumerate()
        .map(squared)
        .fold((0.0, 0.0), |(sum, most): (f64, f64), d| (sum + d, most.max(d)));
    [(sum / positions.len() as f64).sqrt() / diagonal, most.sqrt() / diagonal]
}

/// Name and hash of the file a surface is made from.
pub(crate) fn metadata_of(path: &Path) -> Metadata {
    let hash = |bytes: Vec<u8>| Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect::<String>();
    Metadata {
        source: path.file_name().map(|name| name.to_string_lossy().into_owned()),
        source_sha256: Disk.read(path).ok().map(hash),
    }
}
