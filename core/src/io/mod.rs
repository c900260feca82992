//! Mesh files: OBJ, PLY, OFF, STL and GLB, in and out.
//!
//! Guarantees of the readers:
//! - Vertex `i` of the mesh is vertex `i` of the file, unreferenced and repeated ones included, and faces
//!   keep the file's order. A polygon becomes triangles in its place; degenerate faces are kept. STL has no
//!   vertices of its own: they are its distinct positions, in order of first use. Those of GLB follow one
//!   another as its default scene places them.
//! - Every coordinate is finite and at most [`LARGEST_COORDINATE`]; every index is in range; there is at
//!   least one vertex and one face.
//! - Any file at all gives a mesh or an error, never a panic, in memory proportional to the file's size:
//!   what a header declares is checked against the file's length before anything is allocated.
//! - An error is one sentence that names the file, the place and the mend.
//!
//! Guarantees of the writers: the mesh's own vertex and face order; OBJ, OFF and PLY read back to the
//! same `f64` positions bit for bit. STL and GLB hold `f32`, as their formats demand, and read back to that.
//!
//! Sharp edges are read from OBJ (`l` lines; between faces of different smoothing groups) and from PLY (elements `edge`),
//! and written to both.
//!
//! Non-guarantees: colours, normals, texture coordinates, groups, materials, skins and morph targets are read past
//! and lost.

mod error;
mod glb;
mod obj;
mod off;
mod ply;
mod polygon;
mod stl;
mod text;
mod watch;

use std::fs::File;
use std::io::{BufWriter, Read, Write};
use std::path::Path;

use crate::mesh::TriangleMesh;
use watch::Watch;

pub use error::{Defect, MeshFileError, MeshWriteError, Place};

/// The largest magnitude of a coordinate that is read, in model units. Beyond it squared distances and
/// areas leave the range in which they can be computed with.
pub const LARGEST_COORDINATE: f64 = 1e30;

/// The largest number of vertices or faces of a mesh.
pub const LARGEST_COUNT: u64 = 1 << 31;

/// A mesh file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MeshFormat {
    /// Wavefront OBJ, text.
    Obj,
    /// The polygon file format of Stanford: ASCII or binary when read, binary little-endian when written.
    Ply,
    /// The object file format of Geomview, text.
    Off,
    /// Stereolithography: text or binary when read, binary when written.
    Stl,
    /// Binary glTF 2.0.
    Glb,
}

impl MeshFormat {
    /// The formats that [`read_mesh`] takes.
    pub const READABLE: [Self; 5] = [Self::Obj, Self::Ply, Self::Stl, Self::Glb, Self::Off];
    /// The formats that [`write_mesh`] takes.
    pub const WRITABLE: [Self; 5] = [Self::Obj, Self::Ply, Self::Stl, Self::Glb, Self::Off];

    /// The format a path's extension names, whatever its case.
    pub fn from_path(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?;
        Self::WRITABLE.into_iter().find(|format| extension.eq_ignore_ascii_case(format.extension()))
    }

    /// The usual extension, without a dot.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Off => "off",
            Self::Stl => "stl",
            Self::Glb => "glb",
        }
    }
}

/// What a format's parser says went wrong; the file's name is added by [`read_mesh_bytes`].
type Parsed<T> = Result<T, (Place, Defect)>;

/// Reads a mesh file; its extension names the format.
///
/// Cost: linear in the file's size, 0.1 s or less for 100 k faces. Memory while reading: some seven times the
/// file's size for a usual OBJ, four for the others, twenty at worst.
pub fn read_mesh(path: &Path) -> Result<TriangleMesh, MeshFileError> {
    let (format, bytes) = mesh_file_bytes(path, &mut |_| true)?;
    read_mesh_bytes(format, &bytes, &path.display().to_string())
}

/// The contents of a mesh file and the format that its extension names, for [`read_mesh_bytes`]. `progress` gets the
/// share read, every few megabytes, and returns whether to go on.
///
/// # Errors
/// The file cannot be read, its format is none that is read, or the progress function asked to stop.
pub fn mesh_file_bytes(
    path: &Path,
    progress: &mut dyn FnMut(f32) -> bool,
) -> Result<(MeshFormat, Vec<u8>), MeshFileError> {
    let name = path.display().to_string();
    if path.is_dir() {
        return Err(MeshFileError::not_a_file(&name));
    }
    let format = MeshFormat::from_path(path).filter(|format| MeshFormat::READABLE.contains(format));
    let Some(format) = format else {
        let extension = path.extension().map(|extension| extension.to_string_lossy().into_owned());
        return Err(MeshFileError::unsupported(&name, extension.as_deref()));
    };
    Ok((format, read_bytes(path, &name, progress)?))
}

/// Reads a mesh from the contents of a file; `name` is what errors call it.
///
/// Cost: as [`read_mesh`].
pub fn read_mesh_bytes(format: MeshFormat, bytes: &[u8], name: &str) -> Result<TriangleMesh, MeshFileError> {
    read_mesh_bytes_while(format, bytes, name, &mut || true)
}

/// [`read_mesh_bytes`], asking every few thousand lines whether to go on.
///
/// # Errors
/// As [`read_mesh_bytes`], or [`MeshFileError::Cancelled`] after the answer no.
pub fn read_mesh_bytes_while(
    format: MeshFormat,
    bytes: &[u8],
    name: &str,
    go_on: &mut dyn FnMut() -> bool,
) -> Result<TriangleMesh, MeshFileError> {
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(MeshFileError::malformed(name, Place::Whole, Defect::Empty));
    }
    let watch = Watch::new(go_on);
    let parsed = match format {
        MeshFormat::Obj => obj::parse(bytes, &watch),
        MeshFormat::Ply => ply::parse(bytes, &watch),
        MeshFormat::Off => off::parse(bytes, &watch),
        MeshFormat::Stl => stl::parse(bytes),
        MeshFormat::Glb => glb::parse(bytes),
    };
    parsed.map_err(|(place, defect)| match defect {
        Defect::Cancelled => MeshFileError::cancelled(name),
        defect => MeshFileError::malformed(name, place, defect),
    })
}

/// Writes a mesh in the given format. The writer is flushed, not synced.
///
/// Cost: linear; apart from the mesh, memory only for GLB (24 bytes a vertex).
pub fn write_mesh(
    mesh: &TriangleMesh,
    format: MeshFormat,
    out: &mut dyn Write,
) -> Result<(), MeshWriteError> {
    check(mesh, matches!(format, MeshFormat::Stl | MeshFormat::Glb))?;
    let mut out = BufWriter::with_capacity(1 << 16, out);
    match format {
        MeshFormat::Obj => obj::write(mesh, &mut out)?,
        MeshFormat::Ply => ply::write(mesh, &mut out)?,
        MeshFormat::Off => off::write(mesh, &mut out)?,
        MeshFormat::Stl => stl::write(mesh, &mut out)?,
        MeshFormat::Glb => glb::write(mesh, &mut out)?,
    }
    out.flush()?;
    Ok(())
}

/// Refuses what no file could hold.
fn check(mesh: &TriangleMesh, single_precision: bool) -> Result<(), MeshWriteError> {
    let holds = |x: f64| if single_precision { (x as f32).is_finite() } else { x.is_finite() };
    if let Some(vertex) = mesh.positions.iter().position(|position| !position.iter().all(|&x| holds(x))) {
        return Err(MeshWriteError::Coordinate { vertex });
    }
    let vertices = mesh.positions.len();
    if let Some(face) = mesh.faces.iter().position(|face| face.iter().any(|&v| v as usize >= vertices)) {
        return Err(MeshWriteError::VertexIndex { face, vertices });
    }
    Ok(())
}

/// Bytes read between two calls of the progress function: some hundredths of a second on a slow disk.
const READ_AT_ONCE: u64 = 4 << 20;

fn read_bytes(
    path: &Path,
    name: &str,
    progress: &mut dyn FnMut(f32) -> bool,
) -> Result<Vec<u8>, MeshFileError> {
    let unreadable = |error: std::io::Error| MeshFileError::unreadable(name, error);
    let metadata = std::fs::metadata(path).map_err(unreadable)?;
    if !metadata.is_file() {
        return Err(MeshFileError::not_a_file(name));
    }
    let mut bytes = Vec::new();
    let length = usize::try_from(metadata.len()).unwrap_or(usize::MAX);
    let room = bytes.try_reserve_exact(length);
    room.map_err(|_| MeshFileError::malformed(name, Place::Whole, Defect::OutOfMemory))?;
    let file = File::open(path).map_err(unreadable)?;
    let mut file = file.take(metadata.len());
    loop {
        if !progress(bytes.len() as f32 / length.max(1) as f32) {
            return Err(MeshFileError::cancelled(name));
        }
        if file.by_ref().take(READ_AT_ONCE).read_to_end(&mut bytes).map_err(unreadable)? == 0 {
            return Ok(bytes);
        }
    }
}

/// An empty vector with room for `count` entries, or the error that there is none.
fn with_room<T>(count: usize) -> Parsed<Vec<T>> {
    let mut entries = Vec::new();
    entries.try_reserve_exact(count).map_err(|_| (Place::Whole, Defect::OutOfMemory))?;
    Ok(entries)
}

#[cfg(test)]
mod tests;
