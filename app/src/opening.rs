//! Opening files, for command line and editor alike.

pub(crate) mod compact;
mod stages;

pub(crate) use stages::Stage;

use anyhow::{Result, anyhow, bail};
use bozzetto_core::conversion::remesh::Phase;
use bozzetto_core::conversion::{
    ConversionError, ConversionOptions, Converted, Remesh, convert_owned, convert_with_progress,
};
use bozzetto_core::disk::{Disk, Vfs};
use bozzetto_core::file::{Metadata, Model, SourceIndices};
use bozzetto_core::hierarchy::Slot;
use bozzetto_core::io::read_mesh_file;
use bozzetto_core::mesh::{Comparison, TriangleMesh, distances_to};
use bozzetto_core::surface::{FormOptions, Surface};
use sha2::{Digest, Sha256};
use stages::Clock;
use std::cell::Cell;
use std::path::Path;

/// How to import a mesh.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ImportOptions {
    /// How to find its hierarchy.
    pub conversion: ConversionOptions,
    /// The wavelet form to bring it into.
    pub form: FormOptions,
}

/// A mesh to import and where it is from.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct MeshSource {
    /// What messages call it.
    pub(crate) name: String,
    /// What the wavelet file will say of it.
    pub(crate) metadata: Metadata,
    /// The mesh.
    pub(crate) mesh: TriangleMesh,
}

/// A mesh as a model, with what was done to the mesh on the way.
#[derive(Debug)]
pub(crate) struct Imported {
    /// The model.
    pub(crate) model: Model,
    /// Whether the mesh had subdivision connectivity, or was taken as its own base mesh: it was not converted.
    pub(crate) kept: bool,
    /// One sentence each.
    pub(crate) cleaned: Vec<String>,
    /// The distance both ways, over the bounding-box diagonal, if the mesh was converted.
    pub(crate) measured: Option<Comparison>,
    /// Root mean square and maximum of the distance to the mesh, over the bounding-box diagonal: as measured, or with
    /// the mesh's own connectivity how far its vertices were moved to whole steps, which bounds both ways.
    pub(crate) distance: [f64; 2],
    /// How long everything took.
    pub(crate) seconds: Vec<(Stage, f64)>,
}

impl MeshSource {
    /// Reads a mesh file. `progress` gets the stage and the share of it done and returns whether to go on.
    ///
    /// # Errors
    /// The file cannot be read, or `progress` asked to stop.
    pub(crate) fn read(path: &Path, progress: &dyn Fn(Stage, f32) -> bool) -> Result<Self> {
        let (mut hash, share) = (Sha256::new(), Cell::new(0.0));
        let mut seen = |part: &[u8], done| {
            hash.update(part);
            share.set(done);
        };
        let mesh = read_mesh_file(path, &mut seen, &mut || progress(Stage::Read, share.get()))?;
        let name = path.display().to_string();
        if !progress(Stage::Read, 1.0) {
            bail!("{name}: reading it was cancelled");
        }
        let metadata = Metadata { source: file_name(path), source_sha256: Some(hex(&hash.finalize())) };
        Ok(Self { name, metadata, mesh })
    }
}

/// Imports a mesh file; see [`import`].
///
/// # Errors
/// The file cannot be read or is not a surface.
pub(crate) fn import_file(
    path: &Path,
    options: &ImportOptions,
    progress: &dyn Fn(Stage, f32) -> bool,
) -> Result<(MeshSource, Imported)> {
    let clock = Clock::new(progress);
    let source = MeshSource::read(path, &|stage, done| clock.report(stage, done))?;
    let mut imported = import(&source, options, &|stage, done| clock.report(stage, done))?;
    imported.seconds = clock.seconds();
    Ok((source, imported))
}

/// [`import_file`] without the mesh, which is let go as early as can be: a large one with subdivision connectivity takes less
/// memory than when it is kept.
///
/// # Errors
/// The file cannot be read or is not a surface.
pub(crate) fn import_file_alone(
    path: &Path,
    options: &ImportOptions,
    progress: &dyn Fn(Stage, f32) -> bool,
) -> Result<Imported> {
    let clock = Clock::new(progress);
    let report = |stage, done| clock.report(stage, done);
    let MeshSource { name, metadata, mesh } = MeshSource::read(path, &report)?;
    let diagonal = mesh.diagonal();
    let convert = |by_phase: &dyn Fn(Phase, f32) -> bool| convert_owned(mesh, &options.conversion, by_phase);
    let mut imported = converted(&name, metadata, options, &report, (convert, || diagonal))?;
    imported.seconds = clock.seconds();
    Ok(imported)
}

/// Imports a mesh. `progress` gets the stage and the share of it done and returns whether to go on.
///
/// # Errors
/// It is not a surface, or `progress` asked to stop.
pub(crate) fn import(
    source: &MeshSource,
    options: &ImportOptions,
    progress: &dyn Fn(Stage, f32) -> bool,
) -> Result<Imported> {
    let convert = |by_phase: &dyn Fn(Phase, f32) -> bool| {
        convert_with_progress(&source.mesh, &options.conversion, by_phase)
    };
    let diagonal = || source.mesh.diagonal();
    converted(&source.name, source.metadata.clone(), options, progress, (convert, diagonal))
}

/// Makes a model of what `convert` gives of a mesh with a diagonal.
fn converted(
    name: &str,
    metadata: Metadata,
    options: &ImportOptions,
    progress: &dyn Fn(Stage, f32) -> bool,
    (convert, diagonal): (
        impl FnOnce(&dyn Fn(Phase, f32) -> bool) -> Result<Converted, ConversionError>,
        impl FnOnce() -> f64,
    ),
) -> Result<Imported> {
    let named = |sentence: String| anyhow!("{name}: {sentence}");
    let cancelled = || named("importing it was cancelled".to_owned());
    let clock = Clock::new(progress);
    if options.conversion.remesh != Remesh::Always && !clock.report(Stage::Convert(Phase::Detect), 0.0) {
        return Err(cancelled());
    }
    let by_phase = |phase, done: f32| clock.report(Stage::Convert(phase), done);
    let converted = convert(&by_phase).map_err(|e| named(e.to_string()))?;
    let Converted { hierarchy, positions, source: from, cleaned, measured, .. } = converted;
    if !clock.report(Stage::Build, 0.0) {
        return Err(cancelled());
    }
    let surface =
        Surface::from_positions(hierarchy, &positions, &options.form).map_err(|e| named(e.to_string()))?;
    let distance = match measured {
        Some(measured) => [measured.rms, measured.max],
        None => displacement(&surface, &positions, diagonal()),
    };
    drop(positions);
    let from = from.map(|by_slot| SourceIndices::of_slots(surface.hierarchy(), &by_slot));
    let model = Model::new(surface, from, metadata);
    if !clock.report(Stage::Build, 1.0) {
        return Err(cancelled());
    }
    Ok(Imported { model, kept: measured.is_none(), cleaned, measured, distance, seconds: clock.seconds() })
}

/// Imports a mesh as [`import`] does, but only if it need not be converted; `None` if it has to be.
///
/// # Errors
/// It is not a surface, or `progress` asked to stop.
pub(crate) fn import_if_kept(
    source: &MeshSource,
    options: &ImportOptions,
    progress: &dyn Fn(Stage, f32) -> bool,
) -> Result<Option<Imported>> {
    let converts = Cell::new(false);
    let until_converting = |stage: Stage, done: f32| {
        converts.set(converts.get() || matches!(stage, Stage::Convert(phase) if phase != Phase::Detect));
        !converts.get() && progress(stage, done)
    };
    match import(source, options, &until_converting) {
        Err(_) if converts.get() => Ok(None),
        other => other.map(Some),
    }
}

/// The distance of every vertex of the finest level to the mesh, over the mesh's bounding-box diagonal, by slot.
///
/// # Errors
/// The mesh has no faces, or `progress` asked to stop.
pub(crate) fn error_map(
    surface: &Surface,
    mesh: &TriangleMesh,
    progress: &dyn Fn(Stage, f32) -> bool,
) -> Result<Vec<f64>> {
    let finest = surface.finest();
    let placement = &surface.form().placement;
    let positions: Vec<[f64; 3]> = surface.scaling(finest).iter().map(|&p| placement.to_model(p)).collect();
    let diagonal = mesh.diagonal();
    let distances = distances_to(mesh, &positions, &|done| progress(Stage::Map, done))?;
    Ok(distances.into_iter().map(|d| d / diagonal).collect())
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
    let hash = |bytes: Vec<u8>| hex(&Sha256::digest(&bytes));
    Metadata { source: file_name(path), source_sha256: Disk.read(path).ok().map(hash) }
}

fn file_name(path: &Path) -> Option<String> {
    path.file_name().map(|name| name.to_string_lossy().into_owned())
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}

#[cfg(test)]
mod tests;
