//! The surface that is fitted to an input: fixed faces, moving vertices.

use super::held::Held;
use super::normal_equations::Pattern;
use crate::mesh::TriangleMesh;
use glam::DVec3;

/// A fitted surface: fixed faces, moving vertices.
pub(super) struct Fitted {
    pub(super) pattern: Pattern,
    /// Boundary edges as face and corner they leave.
    pub(super) boundary: Vec<(u32, usize)>,
    /// For each vertex its neighbours along the boundary, if it lies on one.
    pub(super) along_boundary: Vec<Option<[u32; 2]>>,
    /// What keeps vertices on sharp edges.
    pub(super) held: Held,
}

impl Fitted {
    pub(super) fn new(vertices: usize, faces: &[[u32; 3]]) -> Self {
        let pattern = Pattern::new(vertices, faces);
        let leaves = |f: u32, a: u32, b: u32| {
            let face = faces[f as usize];
            (0..3).any(|k| face[k] == a && face[(k + 1) % 3] == b)
        };
        let mut boundary = Vec::new();
        let mut along_boundary: Vec<Option<[u32; 2]>> = vec![None; vertices];
        for (f, face) in faces.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                if !pattern.corners(a as usize).iter().any(|&c| leaves(c / 3, b, a)) {
                    boundary.push((f as u32, k));
                    along_boundary[a as usize].get_or_insert([u32::MAX; 2])[1] = b;
                    along_boundary[b as usize].get_or_insert([u32::MAX; 2])[0] = a;
                }
            }
        }
        Self { pattern, boundary, along_boundary, held: Held::default() }
    }

    pub(super) fn mesh(&self, positions: &[DVec3]) -> TriangleMesh {
        TriangleMesh::new(positions.iter().map(|p| p.to_array()).collect(), self.pattern.faces().to_vec())
    }
}
