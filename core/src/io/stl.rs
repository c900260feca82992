//! Stereolithography: text and binary in, binary out.
//!
//! STL holds triangles without shared vertices. Written in binary, 50 bytes a face: positions are rounded to
//! `f32`, unreferenced vertices lost. Normals are those of the faces; a degenerate face has the normal 0,
//! which readers take as "compute it". What is read is in [`reader`].

use std::io::Write;

use glam::DVec3;

use super::MeshWriteError;
use crate::mesh::{FaceIndex, TriangleMesh};

mod reader;

pub(super) use reader::parse;

/// The 80 bytes before the count. They must not begin with `solid`, which marks the text variant.
const HEADER: [u8; 80] = {
    let mut header = [b' '; 80];
    let name = b"Bozzetto";
    let mut index = 0;
    while index < name.len() {
        header[index] = name[index];
        index += 1;
    }
    header
};

/// Writes the header and the triangles.
pub(super) fn write(mesh: &TriangleMesh, out: &mut dyn Write) -> Result<(), MeshWriteError> {
    let faces = u32::try_from(mesh.faces.len()).map_err(|_| MeshWriteError::TooLarge { format: "STL" })?;
    out.write_all(&HEADER)?;
    out.write_all(&faces.to_le_bytes())?;
    for face in 0..faces {
        let corners = mesh.corners(FaceIndex(face));
        let [a, b, c] = corners.map(DVec3::from);
        let normal = (b - a).cross(c - a).normalize_or_zero().to_array();
        let mut record = [0u8; 50];
        let numbers = normal.into_iter().chain(corners.into_iter().flatten());
        for (bytes, number) in record.chunks_exact_mut(4).zip(numbers) {
            bytes.copy_from_slice(&(number as f32).to_le_bytes());
        }
        out.write_all(&record)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
