//! `M^0`: the base mesh, its edges, fans and sharp marks. A simplicial 2-manifold of any genus, with or without
//! boundary, of one or several components.

use crate::mesh::connectivity::{self, Connectivity, NONE, NotManifold};
use rustc_hash::FxHashMap;
use thiserror::Error;

/// A face of the base mesh at one of its edges. Edge `k` of a face runs from corner `k` to corner `k + 1`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EdgeSide {
    /// The face.
    pub face: u32,
    /// Which of its edges, 0 to 2.
    pub k: u8,
}

/// The faces around a base vertex, counter-clockwise.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fan {
    /// Face and the corner of it that is the vertex.
    pub corners: Vec<(u32, u8)>,
    /// Whether the last face meets the first; otherwise the vertex is on the boundary.
    pub closed: bool,
}

/// Why a triangle list cannot be a base mesh.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
pub enum NotABaseMesh {
    /// There are no faces.
    #[error("there are no faces")]
    Empty,
    /// Not an orientable manifold.
    #[error(transparent)]
    NotManifold(#[from] NotManifold),
    /// Two faces have the same three corners.
    #[error("faces {a} and {b} have the same three corners")]
    DoubledFace {
        /// One of them.
        a: u32,
        /// The other.
        b: u32,
    },
    /// A vertex belongs to no face.
    #[error("vertex {vertex} belongs to no face")]
    Unreferenced {
        /// The vertex.
        vertex: u32,
    },
    /// A sharp mark names an edge that does not exist.
    #[error("the sharp edge between vertices {a} and {b} does not exist")]
    MissingEdge {
        /// One end.
        a: u32,
        /// The other end.
        b: u32,
    },
}

/// The base mesh `M^0`.
///
/// Faces start at their lowest vertex and are sorted; edges are (low, high) pairs in lexicographic order. Both
/// orders are part of the public numbering.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BaseMesh {
    faces: Vec<[u32; 3]>,
    edges: Vec<[u32; 2]>,
    face_edges: Vec<[u32; 3]>,
    sides: Vec<[Option<EdgeSide>; 2]>,
    across: Vec<[Option<EdgeSide>; 3]>,
    fans: Vec<Fan>,
    sharp: Vec<bool>,
    sharp_valence: Vec<u32>,
    components: u32,
    genus: u32,
    boundary_loops: u32,
}

impl BaseMesh {
    /// Builds the tables. Faces are rotated to start at their lowest vertex and sorted; orientation is made
    /// consistent. `sharp` lists marked edges by their ends. `O(F log F)`.
    ///
    /// # Errors
    /// See [`NotABaseMesh`].
    pub fn new(vertex_count: u32, faces: Vec<[u32; 3]>, sharp: &[[u32; 2]]) -> Result<Self, NotABaseMesh> {
        if faces.is_empty() {
            return Err(NotABaseMesh::Empty);
        }
        let oriented = Connectivity::build(vertex_count, faces)?;
        let mut faces: Vec<[u32; 3]> = oriented.faces().iter().map(|&f| lowest_first(f)).collect();
        faces.sort_unstable();
        check_simplicial(&faces)?;
        let connectivity = Connectivity::build(vertex_count, faces)?;
        let faces = connectivity.faces().to_vec();
        if let Some(vertex) = (0..vertex_count).find(|&v| connectivity.outgoing(v) == NONE) {
            return Err(NotABaseMesh::Unreferenced { vertex });
        }

        let mut edges: Vec<[u32; 2]> = (0..3 * faces.len() as u32)
            .filter(|&h| connectivity.twin(h) == NONE || h < connectivity.twin(h))
            .map(|h| sorted_pair(connectivity.origin(h), connectivity.target(h)))
            .collect();
        edges.sort_unstable();
        let edge_of: FxHashMap<[u32; 2], u32> = edges.iter().zip(0..).map(|(&ends, e)| (ends, e)).collect();
        let face_edges: Vec<[u32; 3]> = faces
            .iter()
            .map(|f| std::array::from_fn(|k| edge_of[&sorted_pair(f[k], f[(k + 1) % 3])]))
            .collect();
        let mut sides = vec![[None; 2]; edges.len()];
        for (face, edges_of_face) in face_edges.iter().enumerate() {
            for (k, &e) in edges_of_face.iter().enumerate() {
                let side = Some(EdgeSide { face: face as u32, k: k as u8 });
                let pair = &mut sides[e as usize];
                pair[usize::from(pair[0].is_some())] = side;
            }
        }
        let across = face_edges
            .iter()
            .zip(0..)
            .map(|(edges_of_face, face)| {
                edges_of_face.map(|e| {
                    sides[e as usize].into_iter().flatten().find(|side: &EdgeSide| side.face != face)
                })
            })
            .collect();
        let fans = (0..vertex_count)
            .map(|v| Fan {
                corners: connectivity.fan(v).map(|h| (h / 3, (h % 3) as u8)).collect(),
                closed: !connectivity.is_boundary(v),
            })
            .collect();

        let mut marks = vec![false; edges.len()];
        let mut sharp_valence = vec![0; vertex_count as usize];
        for &[a, b] in sharp {
            let e = *edge_of.get(&sorted_pair(a, b)).ok_or(NotABaseMesh::MissingEdge { a, b })?;
            if !std::mem::replace(&mut marks[e as usize], true) {
                sharp_valence[a as usize] += 1;
                sharp_valence[b as usize] += 1;
            }
        }
        Ok(Self {
            components: connectivity.components(),
            genus: connectivity.genus(),
            boundary_loops: connectivity.boundary_loops(),
            faces,
            edges,
            face_edges,
            sides,
            across,
            fans,
            sharp: marks,
            sharp_valence,
        })
    }

    /// Number of vertices, `V0`.
    #[inline]
    pub fn vertex_count(&self) -> u32 {
        self.fans.len() as u32
    }

    /// Faces, lowest vertex first, sorted, consistently oriented.
    #[inline]
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// Edges as (low, high), sorted.
    #[inline]
    pub fn edges(&self) -> &[[u32; 2]] {
        &self.edges
    }

    /// The edges of each face: entry `k` joins corners `k` and `k + 1`.
    #[inline]
    pub fn face_edges(&self, face: u32) -> [u32; 3] {
        self.face_edges[face as usize]
    }

    /// The one or two faces at an edge.
    pub fn sides(&self, edge: u32) -> [Option<EdgeSide>; 2] {
        self.sides[edge as usize]
    }

    /// The face across edge `k` of a face.
    #[inline]
    pub fn across(&self, face: u32, k: u8) -> Option<EdgeSide> {
        self.across[face as usize][usize::from(k)]
    }

    /// The faces around a vertex.
    pub fn fan(&self, vertex: u32) -> &Fan {
        &self.fans[vertex as usize]
    }

    /// Whether an edge has one face only.
    pub fn is_boundary_edge(&self, edge: u32) -> bool {
        self.sides[edge as usize][1].is_none()
    }

    /// Whether an edge is marked sharp.
    pub fn is_sharp(&self, edge: u32) -> bool {
        self.sharp[edge as usize]
    }

    /// The number of sharp edges at a vertex.
    pub fn sharp_valence(&self, vertex: u32) -> u32 {
        self.sharp_valence[vertex as usize]
    }

    /// The sharp edges by their ends, in edge order.
    pub fn sharp_edges(&self) -> Vec<[u32; 2]> {
        self.edges.iter().zip(&self.sharp).filter(|(_, sharp)| **sharp).map(|(ends, _)| *ends).collect()
    }

    /// Whether the neighbourhood of a vertex is that of the regular lattice at every level: interior, six faces,
    /// no sharp edge.
    pub fn is_regular(&self, vertex: u32) -> bool {
        let fan = self.fan(vertex);
        fan.closed && fan.corners.len() == 6 && self.sharp_valence(vertex) == 0
    }

    /// Number of connected components.
    pub fn components(&self) -> u32 {
        self.components
    }

    /// Genus, summed over components.
    pub fn genus(&self) -> u32 {
        self.genus
    }

    /// Number of boundary loops.
    pub fn boundary_loops(&self) -> u32 {
        self.boundary_loops
    }
}

/// The face rotated, not turned, so that its lowest corner comes first.
fn lowest_first(face: [u32; 3]) -> [u32; 3] {
    let [a, b, c] = face;
    if a < b && a < c {
        [a, b, c]
    } else if b < c {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

fn sorted_pair(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// An edge-manifold list is a simplicial complex if no two faces have the same corners.
fn check_simplicial(faces: &[[u32; 3]]) -> Result<(), NotABaseMesh> {
    let mut seen = FxHashMap::default();
    for (f, &face) in faces.iter().enumerate() {
        let mut key = face;
        key.sort_unstable();
        if let Some(a) = seen.insert(key, f as u32) {
            return Err(NotABaseMesh::DoubledFace { a, b: f as u32 });
        }
    }
    Ok(())
}

/// Whether the list is a simplicial manifold; used by detection before it accepts a coarser mesh. Two faces with the same
/// corners are each other's neighbours at every edge.
pub(crate) fn is_simplicial(connectivity: &connectivity::Connectivity) -> bool {
    let third = |h: u32| connectivity.origin(connectivity::previous(h));
    (0..connectivity.faces().len() as u32).all(|f| {
        let twin = connectivity.twin(3 * f);
        twin == NONE || third(twin) != third(3 * f)
    })
}
