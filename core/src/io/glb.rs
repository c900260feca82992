//! Binary glTF 2.0. What is read is in [`reader`].
//!
//! Written: one mesh of one triangle primitive: positions and smooth normals in single precision, and 32-bit
//! indices. Layout (glTF 2.0 specification, section 4.4): a 12-byte header; a JSON chunk padded with
//! spaces; a binary chunk, all of whose parts are multiples of 4 bytes long. Coordinates are written as
//! they are: glTF takes +Y for up and metres for the unit, and placing the model so is the caller's part.

use std::io::Write;

use glam::DVec3;
use serde_json::{Value, json};

use super::MeshWriteError;
use crate::mesh::{FaceIndex, TriangleMesh};

mod accessor;
mod reader;
mod scene;

pub(super) use reader::parse;

/// Writes the header, the JSON chunk and the binary chunk.
pub(super) fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> Result<(), MeshWriteError> {
    if mesh.is_empty() {
        return Err(MeshWriteError::NoFaces);
    }
    let too_large = || MeshWriteError::TooLarge { format: "glTF" };
    let mut text = description(mesh).to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let binary = 24 * mesh.positions.len() + 12 * mesh.faces.len();
    let total = u32::try_from(12 + 8 + text.len() + 8 + binary).map_err(|_| too_large())?;

    out.write_all(b"glTF")?;
    write_words(out, [2, total])?;
    // The lengths are parts of the total, so they fit.
    write_words(out, [text.len() as u32, u32::from_le_bytes(*b"JSON")])?;
    out.write_all(&text)?;
    write_words(out, [binary as u32, u32::from_le_bytes(*b"BIN\0")])?;
    for position in &mesh.positions {
        write_words(out, position.map(|x| (x as f32).to_bits()))?;
    }
    for normal in smooth_normals(mesh) {
        write_words(out, normal.map(f32::to_bits))?;
    }
    for &face in &mesh.faces {
        write_words(out, face)?;
    }
    Ok(())
}

fn write_words<const N: usize>(out: &mut dyn Write, words: [u32; N]) -> std::io::Result<()> {
    words.iter().try_for_each(|word| out.write_all(&word.to_le_bytes()))
}

/// Unit normals of the vertices: the sum of the area vectors of the faces around each. A vertex without
/// any (unreferenced, or on degenerate faces alone) gets +Z, since glTF asks for unit length.
fn smooth_normals(mesh: &TriangleMesh) -> impl Iterator<Item = [f32; 3]> {
    let mut sums = vec![DVec3::ZERO; mesh.positions.len()];
    for (face, corners) in (0u32..).zip(&mesh.faces) {
        let [a, b, c] = mesh.corners(FaceIndex(face)).map(DVec3::from);
        let area = (b - a).cross(c - a);
        corners.iter().for_each(|&vertex| sums[vertex as usize] += area);
    }
    sums.into_iter().map(|sum| sum.normalize_or(DVec3::Z).to_array().map(|x| x as f32))
}

/// The least and greatest coordinates as stored. They are given as the exact `f64` of the stored `f32`,
/// since validators compare them with the stored values.
fn stored_bounds(mesh: &TriangleMesh) -> [[f64; 3]; 2] {
    let stored = |position: &[f64; 3]| position.map(|x| x as f32);
    let mut bounds = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
    for position in mesh.positions.iter().map(stored) {
        for (axis, &x) in position.iter().enumerate() {
            bounds[0][axis] = bounds[0][axis].min(x);
            bounds[1][axis] = bounds[1][axis].max(x);
        }
    }
    bounds.map(|bound| bound.map(f64::from))
}

fn description(mesh: &TriangleMesh) -> Value {
    const FLOAT: u32 = 5126;
    const UNSIGNED_INT: u32 = 5125;
    const ARRAY_BUFFER: u32 = 34962;
    const ELEMENT_ARRAY_BUFFER: u32 = 34963;
    const TRIANGLES: u32 = 4;

    let (vertices, indices) = (mesh.positions.len(), 3 * mesh.faces.len());
    let (vectors, index_bytes) = (12 * vertices, 4 * indices);
    let [min, max] = stored_bounds(mesh);
    json!({
        "asset": { "version": "2.0", "generator": "Bozzetto" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "NORMAL": 1 },
            "indices": 2,
            "mode": TRIANGLES,
        }] }],
        "accessors": [
            { "bufferView": 0, "componentType": FLOAT, "count": vertices, "type": "VEC3", "min": min, "max": max },
            { "bufferView": 1, "componentType": FLOAT, "count": vertices, "type": "VEC3" },
            { "bufferView": 2, "componentType": UNSIGNED_INT, "count": indices, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": vectors, "target": ARRAY_BUFFER },
            { "buffer": 0, "byteOffset": vectors, "byteLength": vectors, "target": ARRAY_BUFFER },
            { "buffer": 0, "byteOffset": 2 * vectors, "byteLength": index_bytes, "target": ELEMENT_ARRAY_BUFFER },
        ],
        "buffers": [{ "byteLength": 2 * vectors + index_bytes }],
    })
}

#[cfg(test)]
pub(super) mod tests;
