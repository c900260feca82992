//! The mesh that is being led onto the shape: positions as vectors, faces as the library keeps them.

use bozzetto_core::mesh::{TriangleMesh, shapes};

use crate::vector::{Vec3, vec3};

/// A closed triangle mesh, counter-clockwise seen from outside.
#[derive(Debug, Clone, Default)]
pub struct Skin {
    /// Where each vertex lies.
    pub positions: Vec<Vec3>,
    /// The corners of each face, as places in `positions`.
    pub faces: Vec<[u32; 3]>,
}

impl Skin {
    /// The positions of a face's corners.
    pub fn corners(&self, face: [u32; 3]) -> [Vec3; 3] {
        face.map(|corner| self.positions[corner as usize])
    }

    /// Every face split 1→4 at its edges' midpoints; old vertices keep their places.
    pub fn subdivided(&self) -> Self {
        let fine = shapes::subdivide(&self.to_triangle_mesh(), 1);
        Self { positions: fine.positions.iter().map(|&[x, y, z]| vec3(x, y, z)).collect(), faces: fine.faces }
    }

    /// The same mesh as the library's type.
    pub fn to_triangle_mesh(&self) -> TriangleMesh {
        let positions = self.positions.iter().map(|p| [p.x, p.y, p.z]).collect();
        TriangleMesh::new(positions, self.faces.clone())
    }

    /// The neighbours of every vertex, ascending.
    pub fn neighbours(&self) -> Vec<Vec<u32>> {
        let mut neighbours = vec![Vec::with_capacity(12); self.positions.len()];
        for [a, b, c] in &self.faces {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                neighbours[*from as usize].push(*to);
                neighbours[*to as usize].push(*from);
            }
        }
        for list in &mut neighbours {
            list.sort_unstable();
            list.dedup();
        }
        neighbours
    }

    /// The normal of every vertex, weighted by the areas around it, of length one.
    pub fn normals(&self) -> Vec<Vec3> {
        let mut normals = vec![Vec3::default(); self.positions.len()];
        for &face in &self.faces {
            let normal = area_vector(self.corners(face));
            for corner in face {
                normals[corner as usize] += normal;
            }
        }
        normals.into_iter().map(Vec3::normalised).collect()
    }
}

/// The normal of a triangle, as long as twice its area.
pub fn area_vector([a, b, c]: [Vec3; 3]) -> Vec3 {
    (b - a).cross(c - a)
}

/// How even a triangle is: 1 for an equilateral one, towards 0 for a sliver.
pub fn evenness([a, b, c]: [Vec3; 3]) -> f64 {
    let squares = (b - a).dot(b - a) + (c - b).dot(c - b) + (a - c).dot(a - c);
    if squares > 0.0 { 2.0 * 3f64.sqrt() * area_vector([a, b, c]).length() / squares } else { 0.0 }
}
