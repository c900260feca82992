//! Binary STL, written only.
//!
//! STL holds triangles without shared vertices, in single precision: 50 bytes a face, positions rounded to
//! `f32`, unreferenced vertices lost. Normals are those of the faces; a degenerate face has the normal 0,
//! which readers take as "compute it".

use std::io::Write;

use glam::DVec3;

use super::MeshWriteError;
use crate::mesh::{FaceIndex, TriangleMesh};

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
mod tests {
    use super::*;

    #[test]
    fn faces_carry_their_corners_and_normals() {
        let positions = vec![[0.0, 0.0, 1.5], [2.0, 0.0, 1.5], [0.0, 3.0, 1.5]];
        let mesh = TriangleMesh { positions, faces: vec![[0, 1, 2], [0, 0, 1]] };
        let mut bytes = Vec::new();
        write(&mesh, &mut bytes).unwrap();
        assert_eq!(bytes.len(), 84 + 2 * 50);
        assert!(!bytes.starts_with(b"solid"));
        assert_eq!(bytes[80..84], 2u32.to_le_bytes());
        let floats = |face: usize| -> Vec<f32> {
            let record = &bytes[84 + 50 * face..][..48];
            record.as_chunks().0.iter().map(|&bytes| f32::from_le_bytes(bytes)).collect()
        };
        assert_eq!(floats(0), [0.0, 0.0, 1.0, 0.0, 0.0, 1.5, 2.0, 0.0, 1.5, 0.0, 3.0, 1.5]);
        assert_eq!(floats(1)[..3], [0.0; 3]);
        assert_eq!(bytes[84 + 48..84 + 50], [0, 0]);
    }
}
