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
mod stream;
mod text;
mod watch;

use std::io::{BufRead, BufWriter, Write};
use std::path::Path;

use crate::mesh::TriangleMesh;
use stream::Stream;
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
/// Cost: linear in the file's size, 0.1 s or less for 100 k faces. Memory while reading: OBJ and binary PLY are read as they
/// come, so the mesh and little more; of the others the file as well, and some four times its size at worst.
pub fn read_mesh(path: &Path) -> Result<TriangleMesh, MeshFileError> {
    read_mesh_file(path, &mut |_, _| {}, &mut || true)
}

/// [`read_mesh`] with two calls back: `seen` gets every byte of the file once, in order, and the share of the work done so
/// far; `go_on` is asked every few thousand lines or elements whether to go on.
///
/// # Errors
/// The file cannot be read, its format is none that is read, its contents are wrong, or `go_on` said no.
pub fn read_mesh_file(
    path: &Path,
    seen: &mut dyn FnMut(&[u8], f32),
    go_on: &mut dyn FnMut() -> bool,
) -> Result<TriangleMesh, MeshFileError> {
    let name = path.display().to_string();
    if path.is_dir() {
        return Err(MeshFileError::not_a_file(&name));
    }
    let format = MeshFormat::from_path(path).filter(|format| MeshFormat::READABLE.contains(format));
    let Some(format) = format else {
        let extension = path.extension().map(|extension| extension.to_string_lossy().into_owned());
        return Err(MeshFileError::unsupported(&name, extension.as_deref()));
    };
    let streamed = matches!(format, MeshFormat::Obj | MeshFormat::Ply);
    // Where the file is read first, that is little beside the text in it.
    let share = if streamed { 1.0 } else { 0.2 };
    let mut shared = |bytes: &[u8], done: f32| seen(bytes, done * share);
    let mut file = Stream::open(path, &name, &mut shared)?;
    if !streamed {
        let bytes = file.read_whole(&name, go_on)?;
        return read_mesh_bytes_while(format, &bytes, &name, go_on);
    }
    let length = file.length();
    let parsed = parse_stream(format, &mut file, length, go_on);
    if parsed.is_ok() {
        file.pass_over_rest();
    }
    match file.failure() {
        Some(error) => Err(MeshFileError::unreadable(&name, error)),
        None => parsed.map_err(|wrong| said(&name, wrong)),
    }
}

/// Parses a format that can be read as it comes.
fn parse_stream(
    format: MeshFormat,
    file: &mut impl BufRead,
    length: u64,
    go_on: &mut dyn FnMut() -> bool,
) -> Parsed<TriangleMesh> {
    let watch = Watch::new(go_on);
    watch.ask()?;
    let begun = file.fill_buf().unwrap_or_default();
    if begun.len() as u64 >= length && begun.iter().all(u8::is_ascii_whitespace) {
        return Err((Place::Whole, Defect::Empty));
    }
    match format {
        MeshFormat::Obj => obj::parse(file, &watch),
        _ => ply::parse(file, length, &watch),
    }
}

/// An error in the file of a name.
fn said(name: &str, (place, defect): (Place, Defect)) -> MeshFileError {
    match defect {
        Defect::Cancelled => MeshFileError::cancelled(name),
        defect => MeshFileError::malformed(name, place, defect),
    }
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
        MeshFormat::Obj => obj::parse(&mut &bytes[..], &watch),
        MeshFormat::Ply => ply::parse(&mut &bytes[..], bytes.len() as u64, &watch),
        MeshFormat::Off => off::parse(bytes, &watch),
        MeshFormat::Stl => stl::parse(bytes, &watch),
        MeshFormat::Glb => glb::parse(bytes, &watch),
    };
    parsed.map_err(|wrong| said(name, wrong))
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

/// An empty vector with room for `count` entries, or the error that there is none.
fn with_room<T>(count: usize) -> Parsed<Vec<T>> {
    let mut entries = Vec::new();
    entries.try_reserve_exact(count).map_err(|_| (Place::Whole, Defect::OutOfMemory))?;
    Ok(entries)
}

#[cfg(test)]
mod tests;
