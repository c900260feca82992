//! A triangle mesh exactly as a file holds it.
//!
//! Guarantees: vertex `i` is the `i`-th vertex of the file, whether or not a face uses it and whether or
//! not another vertex has the same position; faces are in the file's order, a polygon's triangles one
//! after another.
//! Non-guarantees: faces may be degenerate, edges non-manifold, orientation inconsistent. Only what the
//! readers in [`crate::io`] promise holds: indices in range and finite coordinates.

/// The number of a face in [`TriangleMesh::faces`], counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FaceIndex(pub u32);

/// Vertex positions in model units and triangles as triples of vertex indices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriangleMesh {
    /// One position for every vertex of the file, in model units.
    pub positions: Vec<[f64; 3]>,
    /// Corners of every triangle, as indices into `positions`, in the file's winding.
    pub faces: Vec<[u32; 3]>,
    /// The edges that are marked as sharp, each once in ascending order, ends ascending. An edge of no face may be there.
    pub sharp_edges: Vec<[u32; 2]>,
}

/// An axis-aligned box, in model units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The least coordinate on each axis.
    pub min: [f64; 3],
    /// The greatest coordinate on each axis.
    pub max: [f64; 3],
}

impl Bounds {
    /// The length of the box's diagonal, in model units.
    pub fn diagonal(&self) -> f64 {
        let side = |axis: usize| self.max[axis] - self.min[axis];
        (side(0) * side(0) + side(1) * side(1) + side(2) * side(2)).sqrt()
    }
}

impl TriangleMesh {
    /// A mesh without sharp edges.
    pub fn new(positions: Vec<[f64; 3]>, faces: Vec<[u32; 3]>) -> Self {
        Self { positions, faces, sharp_edges: Vec::new() }
    }

    /// The mesh with these edges marked as sharp, in any order and direction; repeated ones and those of one vertex are
    /// left out. Cost: sorting them.
    #[must_use]
    pub fn with_sharp_edges(mut self, mut edges: Vec<[u32; 2]>) -> Self {
        edges.iter_mut().for_each(|edge| edge.sort_unstable());
        edges.retain(|[a, b]| a != b);
        edges.sort_unstable();
        edges.dedup();
        self.sharp_edges = edges;
        self
    }

    /// Whether the mesh has no face, and so no surface.
    pub fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// The corner positions of a face, in model units.
    ///
    /// Panics if the face, or a vertex it refers to, does not exist.
    pub fn corners(&self, face: FaceIndex) -> [[f64; 3]; 3] {
        self.faces[face.0 as usize].map(|vertex| self.positions[vertex as usize])
    }

    /// The box around the surface, that is around the vertices that faces use; `None` without faces.
    /// Unreferenced vertices, which scans often carry, do not count. Cost: one pass over the faces.
    ///
    /// Panics if a face refers to a vertex that does not exist.
    pub fn bounds(&self) -> Option<Bounds> {
        let mut corners = self.faces.iter().flatten().map(|&vertex| self.positions[vertex as usize]);
        let first = corners.next()?;
        let mut bounds = Bounds { min: first, max: first };
        for position in corners {
            for (axis, &x) in position.iter().enumerate() {
                bounds.min[axis] = bounds.min[axis].min(x);
                bounds.max[axis] = bounds.max[axis].max(x);
            }
        }
        Some(bounds)
    }

    /// The diagonal of [`bounds`](Self::bounds) in model units; 0 without faces.
    pub fn diagonal(&self) -> f64 {
        self.bounds().map_or(0.0, |bounds| bounds.diagonal())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_leave_out_unreferenced_vertices() {
        let positions = vec![[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 4.0, 0.0], [99.0, 99.0, 99.0]];
        let mesh = TriangleMesh::new(positions, vec![[0, 1, 2]]);
        assert_eq!(mesh.bounds(), Some(Bounds { min: [0.0; 3], max: [3.0, 4.0, 0.0] }));
        assert_eq!(mesh.diagonal(), 5.0);
    }

    #[test]
    fn a_mesh_without_faces_has_no_bounds() {
        let mesh = TriangleMesh::new(vec![[1.0; 3]], Vec::new());
        assert!(mesh.is_empty());
        assert_eq!((mesh.bounds(), mesh.diagonal()), (None, 0.0));
    }
}
