//! Opening files, for command line and editor alike.

use anyhow::{Result, anyhow};
use bozzetto_core::conversion::{ConversionOptions, Converted, convert};
use bozzetto_core::disk::{Disk, Vfs};
use bozzetto_core::file::{Metadata, Model, source_by_public_id};
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
    /// The mesh as the file holds it.
    pub(crate) mesh: TriangleMesh,
    /// The model.
    pub(crate) model: Model,
    /// One sentence each.
    pub(crate) cleaned: Vec<String>,
}

/// Imports a mesh file.
///
/// # Errors
/// The file cannot be read or is not a surface.
pub(crate) fn import_file(path: &Path, options: &ImportOptions) -> Result<Imported> {
    let mesh = read_mesh(path)?;
    let (model, cleaned) = import(path, &mesh, options)?;
    Ok(Imported { mesh, model, cleaned })
}

/// Imports a mesh that was read from a file.
///
/// # Errors
/// It is not a surface.
pub(crate) fn import(
    path: &Path,
    mesh: &TriangleMesh,
    options: &ImportOptions,
) -> Result<(Model, Vec<String>)> {
    let named = |sentence: String| anyhow!("{}: {sentence}", path.display());
    let Converted { hierarchy, positions, source, cleaned } =
        convert(mesh, &options.conversion).map_err(|e| named(e.to_string()))?;
    let surface =
        Surface::from_positions(hierarchy, &positions, &options.form).map_err(|e| named(e.to_string()))?;
    let source = source.map(|by_slot| source_by_public_id(surface.hierarchy(), &by_slot));
    Ok((Model::new(surface, source, metadata_of(path)), cleaned))
}

/// Name and hash of the file a surface is made from.
pub(crate) fn metadata_of(path: &Path) -> Metadata {
    let hash = |bytes: Vec<u8>| Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect::<String>();
    Metadata {
        source: path.file_name().map(|name| name.to_string_lossy().into_owned()),
        source_sha256: Disk.read(path).ok().map(hash),
    }
}
