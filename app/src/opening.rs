//! Opening files, for command line and editor alike.

use anyhow::Result;
use bozzetto_core::conversion::{ImportError, ImportOptions, Imported, import};
use bozzetto_core::disk::{Disk, Vfs};
use bozzetto_core::file::{Metadata, Model, source_by_public_id};
use bozzetto_core::io::read_mesh;
use bozzetto_core::mesh::TriangleMesh;
use sha2::{Digest, Sha256};
use std::path::Path;

/// Whether a path names a wavelet file.
pub(crate) fn is_wavelet_file(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("boz"))
}

/// Imports a mesh file.
///
/// # Errors
/// The file cannot be read or is not a surface.
pub(crate) fn import_file(path: &Path, options: &ImportOptions) -> Result<(TriangleMesh, Imported)> {
    let mesh = read_mesh(path)?;
    let imported =
        import(&mesh, options).map_err(|e: ImportError| anyhow::anyhow!("{}: {e}", path.display()))?;
    Ok((mesh, imported))
}

/// A model with its origin noted.
pub(crate) fn model_of(path: &Path, imported: Imported) -> Model {
    let source = imported.source.map(|by_slot| source_by_public_id(imported.surface.hierarchy(), &by_slot));
    Model::new(imported.surface, source, metadata_of(path))
}

/// Name and hash of the file a surface is made from.
pub(crate) fn metadata_of(path: &Path) -> Metadata {
    let hash = |bytes: Vec<u8>| Sha256::digest(&bytes).iter().map(|b| format!("{b:02x}")).collect::<String>();
    Metadata {
        source: path.file_name().map(|name| name.to_string_lossy().into_owned()),
        source_sha256: Disk.read(path).ok().map(hash),
    }
}
