//! Vertex normals: made from faces, and packed into four bytes for the GPU.

use glam::Vec3;

/// Area-weighted unit normals of a mesh whose faces run counter-clockwise seen from outside; +z where a vertex
/// has no face of any area. For meshes that come without normals; cost: one pass over faces and vertices.
///
/// # Panics
/// If a face names a vertex that is not there.
pub fn vertex_normals(positions: &[[f32; 3]], faces: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![Vec3::ZERO; positions.len()];
    for face in faces {
        let [a, b, c] = face.map(|v| Vec3::from(positions[v as usize]));
        let area = (b - a).cross(c - a);
        for vertex in face {
            sums[*vertex as usize] += area;
        }
    }
    sums.into_iter().map(|sum| sum.normalize_or(Vec3::Z).to_array()).collect()
}

/// A direction folded onto an octahedron and from there to a square, as two signed 16-bit fractions: at most
/// 0.004° off. After Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors".
pub(super) fn packed(normal: [f32; 3]) -> [i16; 2] {
    let [x, y, z] = normal;
    let size = x.abs() + y.abs() + z.abs();
    // A zero or broken normal packs as +z: the picture shows it, the program goes on.
    if !(size > 0.0 && size.is_finite()) {
        return [0, 0];
    }
    let (mut u, mut v) = (x / size, y / size);
    if z < 0.0 {
        (u, v) = ((1.0 - v.abs()).copysign(u), (1.0 - u.abs()).copysign(v));
    }
    [u, v].map(|part| (part * 32767.0).round() as i16)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the shader does with a packed normal (`unpack_normal` in `frame.wgsl`).
    fn unpacked(packed: [i16; 2]) -> Vec3 {
        let [u, v] = packed.map(|part| f32::from(part) / 32767.0);
        let z = 1.0 - u.abs() - v.abs();
        let fold = (-z).max(0.0);
        Vec3::new(u - fold.copysign(u), v - fold.copysign(v), z).normalize()
    }

    #[test]
    fn packing_keeps_every_direction() {
        for i in 0..4000 {
            let z = 1.0 - (2 * i + 1) as f32 / 4000.0;
            let (sin, cos) = (i as f32 * 2.399_963).sin_cos();
            let ring = (1.0 - z * z).sqrt();
            let normal = Vec3::new(ring * cos, ring * sin, z);
            let off = unpacked(packed(normal.to_array())).distance(normal);
            assert!(off < 1e-4, "{normal} came back {off} away");
        }
    }

    #[test]
    fn packing_takes_broken_normals() {
        for broken in [[0.0; 3], [f32::NAN; 3], [f32::INFINITY, 0.0, 0.0]] {
            assert_eq!(packed(broken), [0, 0]);
        }
    }

    #[test]
    fn normals_of_a_square_point_out_of_it() {
        let positions = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [9.0, 9.0, 9.0]];
        let normals = vertex_normals(&positions, &[[0, 1, 2], [0, 2, 3]]);
        assert_eq!(normals, [[0.0, 0.0, 1.0]; 5]);
    }
}
