//! A mesh that shrinks: faces are only ever added and retired, so a face's number names it for good.
//!
//! Guarantees: oriented, manifold and simplicial after every step that [`WorkingMesh::replace`] makes with patches
//! that keep it so. Non-guarantees: replace checks nothing; the callers do.

use super::creases::Creases;
use crate::mesh::TriangleMesh;
use crate::mesh::connectivity::{Connectivity, NONE};
use glam::DVec3;

/// Triangles with retired ones in between.
#[derive(Debug, Clone)]
pub(super) struct WorkingMesh {
    /// Where each vertex is; those of vertices without faces mean nothing.
    pub(super) positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    live: Vec<bool>,
    stars: Vec<Vec<u32>>,
    boundary: Vec<bool>,
    /// Vertices of the seam of half a mesh: an edge between two of them is part of it.
    seam: Vec<bool>,
    creases: Creases,
    live_count: usize,
}

impl WorkingMesh {
    /// The whole mesh, nothing retired.
    pub(super) fn new(positions: Vec<DVec3>, connectivity: &Connectivity) -> Self {
        let faces = connectivity.faces().to_vec();
        let mut stars: Vec<Vec<u32>> = positions.iter().map(|_| Vec::with_capacity(8)).collect();
        for (f, face) in faces.iter().enumerate() {
            face.iter().for_each(|&v| stars[v as usize].push(f as u32));
        }
        let boundary = (0..positions.len() as u32)
            .map(|v| connectivity.outgoing(v) != NONE && connectivity.is_boundary(v))
            .collect();
        let creases =
            Creases { ends: vec![Vec::new(); positions.len()], corners: vec![false; positions.len()] };
        Self {
            seam: vec![false; positions.len()],
            positions,
            live: vec![true; faces.len()],
            live_count: faces.len(),
            faces,
            stars,
            boundary,
            creases,
        }
    }

    /// The same mesh with sharp edges and corners.
    pub(super) fn with_creases(self, creases: Creases) -> Self {
        Self { creases, ..self }
    }

    /// The same mesh as half of one that is mirrored in the plane x = 0, where these vertices lie.
    pub(super) fn with_seam(self, seam: Vec<bool>) -> Self {
        Self { seam, ..self }
    }

    /// The live faces with their vertices numbered anew, in the same order, and the sharp edges.
    pub(super) fn compact(&self) -> TriangleMesh {
        let mut number = vec![NONE; self.positions.len()];
        self.live_faces().flat_map(|f| self.face(f)).for_each(|v| number[v as usize] = 0);
        let mut positions = Vec::new();
        for (number, position) in number.iter_mut().zip(&self.positions).filter(|(number, _)| **number == 0) {
            *number = positions.len() as u32;
            positions.push(position.to_array());
        }
        let faces = self.live_faces().map(|f| self.face(f).map(|v| number[v as usize])).collect();
        let sharp = self.creases.edges().map(|ends| ends.map(|v| number[v as usize])).collect();
        TriangleMesh::new(positions, faces).with_sharp_edges(sharp)
    }

    /// Live faces.
    pub(super) fn live_count(&self) -> usize {
        self.live_count
    }

    /// Whether the face is part of the mesh now.
    pub(super) fn is_live(&self, face: u32) -> bool {
        self.live[face as usize]
    }

    /// The numbers of the live faces, ascending.
    pub(super) fn live_faces(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.faces.len() as u32).filter(|&f| self.live[f as usize])
    }

    /// The vertices of live faces, ascending.
    pub(super) fn live_vertices(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.stars.len() as u32).filter(|&v| !self.stars[v as usize].is_empty())
    }

    /// The corners of a face, live or not.
    pub(super) fn face(&self, face: u32) -> [u32; 3] {
        self.faces[face as usize]
    }

    /// The live faces of a vertex, in no particular but a repeatable order.
    pub(super) fn star(&self, vertex: u32) -> &[u32] {
        &self.stars[vertex as usize]
    }

    /// Whether the vertex lies on the boundary.
    pub(super) fn is_boundary(&self, vertex: u32) -> bool {
        self.boundary[vertex as usize]
    }

    /// Whether the vertex lies on the seam of half a mesh, which is part of its boundary.
    pub(super) fn is_seam(&self, vertex: u32) -> bool {
        self.seam[vertex as usize]
    }

    /// Whether the vertex lies on the seam and on no other curve.
    pub(super) fn is_only_seam(&self, vertex: u32) -> bool {
        self.is_seam(vertex) && self.crease_ends(vertex).is_empty() && !self.is_corner(vertex)
    }

    /// Whether the vertex lies on the boundary or on a sharp edge.
    pub(super) fn is_on_curve(&self, vertex: u32) -> bool {
        self.is_boundary(vertex) || !self.creases.ends[vertex as usize].is_empty()
    }

    /// Whether the vertex keeps its place.
    pub(super) fn is_corner(&self, vertex: u32) -> bool {
        self.creases.corners[vertex as usize]
    }

    /// The other ends of a vertex's sharp edges.
    pub(super) fn crease_ends(&self, vertex: u32) -> &[u32] {
        &self.creases.ends[vertex as usize]
    }

    /// Whether the edge is sharp.
    pub(super) fn is_crease(&self, a: u32, b: u32) -> bool {
        self.creases.holds(a, b)
    }

    /// The next vertex along the curve through a vertex that is no corner, away from `from`.
    pub(super) fn beyond(&self, vertex: u32, from: u32) -> u32 {
        let pair = match self.creases.ends[vertex as usize][..] {
            [a, b] => [a, b],
            _ => self.along_boundary(vertex),
        };
        if pair[0] == from { pair[1] } else { pair[0] }
    }

    /// The number of faces at an interior vertex between the sharp edges that enclose `face`, and the sum of their
    /// angles there.
    pub(super) fn wedge(&self, vertex: u32, face: u32) -> (usize, f64) {
        let angle = |f: u32| {
            let k = self.face(f).iter().position(|&v| v == vertex).expect("a face of the vertex");
            let corners = self.corners(f);
            let [p, q] = [1, 2].map(|step| corners[(k + step) % 3] - corners[k]);
            libm::atan2(p.cross(q).length(), p.dot(q))
        };
        let (mut count, mut sum) = (1, angle(face));
        for back in [false, true] {
            let mut at = face;
            for _ in 0..self.star(vertex).len() {
                let corners = self.face(at);
                let k = corners.iter().position(|&v| v == vertex).expect("a face of the vertex");
                let other = corners[(k + if back { 1 } else { 2 }) % 3];
                let [out, into] = self.sides(vertex, other);
                match if back { into } else { out } {
                    Some(next) if next != face && !self.is_crease(vertex, other) => at = next,
                    _ => break,
                }
                count += 1;
                sum += angle(at);
            }
        }
        (count, sum)
    }

    /// Lets a vertex of a sharp curve be gone: its edge to `kept` is no more, and `kept` takes its place in the other.
    pub(super) fn shorten_crease(&mut self, kept: u32, gone: u32) {
        let pair = std::mem::take(&mut self.creases.ends[gone as usize]);
        let Some(&next) = pair.iter().find(|&&w| w != kept) else { return };
        for (v, new) in [(kept, next), (next, kept)] {
            let ends = &mut self.creases.ends[v as usize];
            ends.iter_mut().filter(|end| **end == gone).for_each(|end| *end = new);
        }
    }

    /// Where the corners of a face are.
    pub(super) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.face(face).map(|v| self.positions[v as usize])
    }

    /// The number of neighbouring vertices, in the whole mesh for one on the seam of half a mesh.
    pub(super) fn valence(&self, vertex: u32) -> usize {
        self.valence_with(vertex, self.star(vertex).len())
    }

    /// The valence that a vertex would have with so many faces.
    pub(super) fn valence_with(&self, vertex: u32, faces: usize) -> usize {
        match (self.is_boundary(vertex), self.is_seam(vertex)) {
            (false, _) => faces,
            (true, false) => faces + 1,
            // In a corner between seam and boundary there is one neighbour more.
            (true, true) => 2 * faces + usize::from(self.ends_seam(vertex)),
        }
    }

    /// Whether the boundary leaves the seam at a vertex of it.
    fn ends_seam(&self, vertex: u32) -> bool {
        self.is_corner(vertex) && self.along_boundary(vertex).iter().any(|&w| !self.is_seam(w))
    }

    /// The vertices joined to `vertex` by an edge, each once, ascending.
    pub(super) fn neighbours(&self, vertex: u32, into: &mut Vec<u32>) {
        into.clear();
        // Round an interior vertex each neighbour follows it in one face.
        let open = self.is_boundary(vertex);
        for &f in self.star(vertex) {
            let face = self.face(f);
            let k = if face[0] == vertex {
                0
            } else if face[1] == vertex {
                1
            } else {
                2
            };
            into.push(face[(k + 1) % 3]);
            if open {
                into.push(face[(k + 2) % 3]);
            }
        }
        into.sort_unstable();
        if open {
            into.dedup();
        }
    }

    /// How pointed the surface is at a vertex with these neighbours: the length of the mean direction to them, 0 in a
    /// plane, near 1 at the tip of a horn.
    pub(super) fn pointedness(&self, vertex: u32, neighbours: &[u32]) -> f64 {
        let here = self.positions[vertex as usize];
        let way = |&w: &u32| (self.positions[w as usize] - here).normalize_or_zero();
        if self.is_seam(vertex) {
            // With the mirror images, what is across the plane cancels out.
            let (on, off): (Vec<u32>, Vec<u32>) = neighbours.iter().partition(|&&w| self.is_seam(w));
            let sum = on.iter().map(way).sum::<DVec3>() + off.iter().map(way).sum::<DVec3>() * 2.0;
            return sum.with_x(0.0).length() / (on.len() + 2 * off.len()).max(1) as f64;
        }
        neighbours.iter().map(way).sum::<DVec3>().length() / neighbours.len().max(1) as f64
    }

    /// The live faces at an edge: the one that runs from `a` to `b`, and the one that runs back.
    pub(super) fn sides(&self, a: u32, b: u32) -> [Option<u32>; 2] {
        let mut sides = [None; 2];
        for &f in self.star(a) {
            let face = self.face(f);
            if let Some(k) = face.iter().position(|&v| v == a) {
                if face[(k + 1) % 3] == b {
                    sides[0] = Some(f);
                } else if face[(k + 2) % 3] == b {
                    sides[1] = Some(f);
                }
            }
        }
        sides
    }

    /// The neighbours of a boundary vertex along the boundary: before it and after it, in the sense of the faces.
    pub(super) fn along_boundary(&self, vertex: u32) -> [u32; 2] {
        let mut out: Vec<u32> = Vec::with_capacity(8);
        let mut back: Vec<u32> = Vec::with_capacity(8);
        for &f in self.star(vertex) {
            let face = self.face(f);
            let k = face.iter().position(|&v| v == vertex).expect("a star's face holds its vertex");
            out.push(face[(k + 1) % 3]);
            back.push(face[(k + 2) % 3]);
        }
        let after = out.iter().find(|v| !back.contains(v)).expect("a boundary vertex ends a fan");
        let before = back.iter().find(|v| !out.contains(v)).expect("a boundary vertex ends a fan");
        [*before, *after]
    }

    /// Retires faces and adds others; returns the number of the first added.
    pub(super) fn replace(&mut self, retired: &[u32], added: &[[u32; 3]]) -> u32 {
        for &f in retired {
            self.live[f as usize] = false;
            for v in self.faces[f as usize] {
                self.stars[v as usize].retain(|&g| g != f);
            }
        }
        let first = self.faces.len() as u32;
        for (&face, id) in added.iter().zip(first..) {
            face.iter().for_each(|&v| self.stars[v as usize].push(id));
            self.faces.push(face);
            self.live.push(true);
        }
        self.live_count += added.len();
        self.live_count -= retired.len();
        first
    }

    /// Says that a vertex lies on the boundary.
    pub(super) fn mark_boundary(&mut self, vertex: u32) {
        self.boundary[vertex as usize] = true;
    }
}
