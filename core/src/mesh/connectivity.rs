//! Half-edge connectivity of a triangle list.
//!
//! Half-edge `3f + k` runs from corner `k` of face `f` to corner `k + 1`; its twin runs the other way in the
//! neighbouring face. Building it proves that the list is an orientable 2-manifold, with or without boundary.
//! It does **not** prove that the list is a simplicial complex: two faces may have the same three corners.

use super::Abandoned;
use rayon::prelude::*;
use std::borrow::Cow;
use std::collections::VecDeque;
use thiserror::Error;

/// Stands for "no half-edge": the other side of a boundary edge.
pub const NONE: u32 = u32::MAX;

/// Why a triangle list is not an orientable 2-manifold. Indices are those of the list, counted from 0.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
pub enum NotManifold {
    /// A face names a vertex that does not exist.
    #[error("face {face} refers to vertex {vertex}, which does not exist")]
    MissingVertex {
        /// The face.
        face: u32,
        /// The vertex it names.
        vertex: u32,
    },
    /// A face has the same corner twice.
    #[error("face {face} has vertex {vertex} twice")]
    Degenerate {
        /// The face.
        face: u32,
        /// The repeated corner.
        vertex: u32,
    },
    /// More than two faces share an edge.
    #[error("the edge between vertices {a} and {b} belongs to more than two faces")]
    Edge {
        /// One end.
        a: u32,
        /// The other end.
        b: u32,
    },
    /// The faces around a vertex do not form one fan.
    #[error("the faces around vertex {vertex} do not form one fan")]
    Vertex {
        /// The vertex.
        vertex: u32,
    },
    /// No choice of orientations is consistent (a Möbius band, a Klein bottle).
    #[error(
        "the faces at the edge between vertices {a} and {b} cannot be oriented alike: the surface is one-sided"
    )]
    NotOrientable {
        /// One end.
        a: u32,
        /// The other end.
        b: u32,
    },
}

/// Why relations were not built.
enum Stop {
    NotManifold(NotManifold),
    Abandoned,
}

impl From<NotManifold> for Stop {
    fn from(why: NotManifold) -> Self {
        Self::NotManifold(why)
    }
}

/// Faces that are gone through between two questions whether to go on.
const STRIDE: usize = 1 << 17;

/// Neighbour relations of an oriented triangle list.
#[derive(Debug, Clone)]
pub struct Connectivity<'f> {
    /// Those it was built of, as long as they agree.
    faces: Cow<'f, [[u32; 3]]>,
    twins: Vec<u32>,
    outgoing: Vec<u32>,
    /// Empty if there is one component.
    component_of_face: Vec<u32>,
    components: u32,
}

impl<'f> Connectivity<'f> {
    /// Builds the relations, turning faces round where that makes neighbours agree; the first face of each
    /// component keeps its orientation. Borrowed faces are copied only then. Time and memory linear in the faces.
    ///
    /// # Errors
    /// The first obstacle found; see [`NotManifold`].
    pub fn build(vertex_count: u32, faces: impl Into<Cow<'f, [[u32; 3]]>>) -> Result<Self, NotManifold> {
        Self::build_asking(vertex_count, faces.into(), &|| Ok(())).map_err(|stop| match stop {
            Stop::NotManifold(why) => why,
            Stop::Abandoned => unreachable!("nobody asked to stop"),
        })
    }

    /// [`build`](Self::build), asking now and then, after some hundredths of a second, whether to go on.
    ///
    /// # Errors
    /// The answer was no.
    pub fn build_while(
        vertex_count: u32,
        faces: impl Into<Cow<'f, [[u32; 3]]>>,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Result<Self, NotManifold>, Abandoned> {
        let ask = || if go_on() { Ok(()) } else { Err(Stop::Abandoned) };
        match Self::build_asking(vertex_count, faces.into(), &ask) {
            Ok(built) => Ok(Ok(built)),
            Err(Stop::NotManifold(why)) => Ok(Err(why)),
            Err(Stop::Abandoned) => Err(Abandoned),
        }
    }

    fn build_asking(
        vertex_count: u32,
        mut faces: Cow<'f, [[u32; 3]]>,
        ask: &dyn Fn() -> Result<(), Stop>,
    ) -> Result<Self, Stop> {
        for (f, face) in faces.iter().enumerate() {
            let face_index = f as u32;
            for k in 0..3 {
                if face[k] >= vertex_count {
                    return Err(NotManifold::MissingVertex { face: face_index, vertex: face[k] }.into());
                }
                if face[k] == face[(k + 1) % 3] {
                    return Err(NotManifold::Degenerate { face: face_index, vertex: face[k] }.into());
                }
            }
        }
        let mut twins = edge_pairs(vertex_count, &faces, ask)?;
        ask()?;
        let Components { of_face, count: components, turned } = orient(&mut faces, &twins, ask)?;
        let component_of_face = if components > 1 { of_face } else { Vec::new() };
        if turned {
            // Turning a face renumbers its half-edges, so the pairs are found once more.
            drop(twins);
            twins = edge_pairs(vertex_count, &faces, ask)?;
        }
        ask()?;
        let outgoing = fans(vertex_count, &faces, &twins, ask)?;
        Ok(Self { faces, twins, outgoing, component_of_face, components })
    }

    /// The faces, consistently oriented.
    pub fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The faces alone: [`Connectivity::build`] makes the rest of them again.
    pub fn into_faces(self) -> Cow<'f, [[u32; 3]]> {
        self.faces
    }

    /// The number of connected components that have faces.
    pub fn components(&self) -> u32 {
        self.components
    }

    /// The component of each face, numbered by lowest face.
    pub fn component_of_face(&self, face: u32) -> u32 {
        self.component_of_face.get(face as usize).copied().unwrap_or(0)
    }

    /// The number of vertex slots, used or not.
    pub fn vertex_count(&self) -> u32 {
        self.outgoing.len() as u32
    }

    /// A half-edge that leaves the vertex; on the boundary the clockwise-most, whose twin is [`NONE`]. [`NONE`]
    /// for a vertex of no face.
    pub fn outgoing(&self, vertex: u32) -> u32 {
        self.outgoing[vertex as usize]
    }

    /// The same edge seen from the other face, or [`NONE`].
    pub fn twin(&self, half_edge: u32) -> u32 {
        self.twins[half_edge as usize]
    }

    /// The vertex a half-edge leaves.
    pub fn origin(&self, half_edge: u32) -> u32 {
        self.faces[(half_edge / 3) as usize][(half_edge % 3) as usize]
    }

    /// The vertex a half-edge reaches.
    pub fn target(&self, half_edge: u32) -> u32 {
        self.origin(next(half_edge))
    }

    /// The next half-edge out of the same vertex, counter-clockwise; [`NONE`] past the last face of an open fan.
    pub fn rotate(&self, half_edge: u32) -> u32 {
        self.twin(previous(half_edge))
    }

    /// Whether the vertex lies on the boundary.
    pub fn is_boundary(&self, vertex: u32) -> bool {
        let h = self.outgoing(vertex);
        h != NONE && self.twin(h) == NONE
    }

    /// The half-edges that leave a vertex, counter-clockwise.
    pub fn fan(&self, vertex: u32) -> impl Iterator<Item = u32> + '_ {
        let first = self.outgoing(vertex);
        let mut at = first;
        std::iter::from_fn(move || {
            if at == NONE {
                return None;
            }
            let here = at;
            let following = self.rotate(here);
            at = if following == first { NONE } else { following };
            Some(here)
        })
    }

    /// The number of faces around a vertex.
    pub fn face_valence(&self, vertex: u32) -> u32 {
        self.fan(vertex).count() as u32
    }

    /// The number of boundary loops.
    pub fn boundary_loops(&self) -> u32 {
        let mut seen = vec![false; self.twins.len()];
        let mut loops = 0;
        for start in 0..self.twins.len() as u32 {
            if self.twins[start as usize] != NONE || seen[start as usize] {
                continue;
            }
            loops += 1;
            let mut at = start;
            while !seen[at as usize] {
                seen[at as usize] = true;
                at = self.outgoing(self.target(at));
            }
        }
        loops
    }

    /// Vertices − edges + faces, over vertices that faces use.
    pub fn euler_characteristic(&self) -> i64 {
        let used = self.outgoing.iter().filter(|&&h| h != NONE).count() as i64;
        let edges =
            self.twins.iter().enumerate().filter(|&(h, &t)| t == NONE || (h as u32) < t).count() as i64;
        used - edges + self.faces.len() as i64
    }

    /// The genus summed over components: `Σ (2 − χ − boundary loops) / 2`.
    pub fn genus(&self) -> u32 {
        let doubled =
            2 * i64::from(self.components) - self.euler_characteristic() - i64::from(self.boundary_loops());
        (doubled / 2).max(0) as u32
    }
}

/// The half-edge after this one in its face.
pub fn next(half_edge: u32) -> u32 {
    if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 }
}

/// The half-edge before this one in its face.
pub fn previous(half_edge: u32) -> u32 {
    if half_edge.is_multiple_of(3) { half_edge + 2 } else { half_edge - 1 }
}

/// Edges that are paired at a time: enough that the passes over all faces do not weigh, few enough for memory.
const AT_ONCE: usize = 1 << 22;

/// For every half-edge the half-edge of the other face at the same undirected edge, or [`NONE`]. Edges are sorted, those of
/// some vertices at a time: a table of all of them would take twice the memory of the faces.
fn edge_pairs(
    vertex_count: u32,
    faces: &[[u32; 3]],
    ask: &dyn Fn() -> Result<(), Stop>,
) -> Result<Vec<u32>, Stop> {
    let mut pairs = vec![NONE; faces.len() * 3];
    let passes = pairs.len().div_ceil(AT_ONCE).max(1) as u32;
    let vertices = vertex_count.div_ceil(passes).max(1);
    // The first half-edge that is one too many at its edge.
    let mut obstacle: Option<[u32; 3]> = None;
    let mut edges: Vec<[u32; 3]> = Vec::new();
    for first in (0..vertex_count).step_by(vertices as usize) {
        edges.clear();
        for (f, face) in faces.iter().enumerate() {
            if f % AT_ONCE == AT_ONCE - 1 {
                ask()?;
            }
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                if a.min(b).wrapping_sub(first) < vertices {
                    edges.push([a.min(b), a.max(b), (3 * f + k) as u32]);
                }
            }
        }
        ask()?;
        edges.par_sort_unstable();
        ask()?;
        for of_edge in edges.chunk_by(|a, b| a[..2] == b[..2]) {
            match *of_edge {
                [_] => {}
                [[.., one], [.., other]] => {
                    pairs[one as usize] = other;
                    pairs[other as usize] = one;
                }
                _ if obstacle.is_none_or(|earlier| of_edge[2][2] < earlier[2]) => obstacle = Some(of_edge[2]),
                _ => {}
            }
        }
    }
    match obstacle {
        Some([a, b, _]) => Err(NotManifold::Edge { a, b }.into()),
        None => Ok(pairs),
    }
}

/// The connected components of the faces.
struct Components {
    of_face: Vec<u32>,
    count: u32,
    /// Whether some face was turned round.
    turned: bool,
}

/// Turns faces so that neighbours agree.
fn orient(
    faces: &mut Cow<'_, [[u32; 3]]>,
    pairs: &[u32],
    ask: &dyn Fn() -> Result<(), Stop>,
) -> Result<Components, Stop> {
    const UNSEEN: u32 = u32::MAX;
    let original = &**faces;
    let ends = |h: u32| {
        let face = original[(h / 3) as usize];
        let k = (h % 3) as usize;
        (face[k], face[(k + 1) % 3])
    };
    let mut component = vec![UNSEEN; faces.len()];
    let mut flipped = vec![false; faces.len()];
    let mut components = 0;
    // First in, first out: the rim of a disc, where last in, first out would hold most of the mesh.
    let mut waiting = VecDeque::new();
    let mut seen = 0usize;
    for seed in 0..faces.len() as u32 {
        if component[seed as usize] != UNSEEN {
            continue;
        }
        component[seed as usize] = components;
        waiting.push_back(seed);
        while let Some(face) = waiting.pop_front() {
            seen += 1;
            if seen.is_multiple_of(STRIDE) {
                ask()?;
            }
            for h in 3 * face..3 * face + 3 {
                let other = pairs[h as usize];
                if other == NONE {
                    continue;
                }
                let neighbour = other / 3;
                let same_direction = ends(h) == ends(other);
                let wanted = flipped[face as usize] ^ same_direction;
                if component[neighbour as usize] == UNSEEN {
                    component[neighbour as usize] = components;
                    flipped[neighbour as usize] = wanted;
                    waiting.push_back(neighbour);
                } else if flipped[neighbour as usize] != wanted {
                    let (a, b) = ends(h);
                    return Err(NotManifold::NotOrientable { a, b }.into());
                }
            }
        }
        components += 1;
    }
    let turned = flipped.contains(&true);
    if turned {
        for (face, _) in faces.to_mut().iter_mut().zip(&flipped).filter(|(_, turned)| **turned) {
            face.swap(1, 2);
        }
    }
    Ok(Components { of_face: component, count: components, turned })
}

/// One outgoing half-edge per vertex, after checking that each vertex has a single fan.
fn fans(
    vertex_count: u32,
    faces: &[[u32; 3]],
    twins: &[u32],
    ask: &dyn Fn() -> Result<(), Stop>,
) -> Result<Vec<u32>, Stop> {
    let mut outgoing = vec![NONE; vertex_count as usize];
    let mut count = vec![0u32; vertex_count as usize];
    for (f, face) in faces.iter().enumerate() {
        if f % STRIDE == STRIDE - 1 {
            ask()?;
        }
        for (k, &v) in face.iter().enumerate() {
            let here = (3 * f + k) as u32;
            count[v as usize] += 1;
            if outgoing[v as usize] == NONE || twins[here as usize] == NONE {
                outgoing[v as usize] = here;
            }
        }
    }
    for (v, &first) in outgoing.iter().enumerate() {
        if v % STRIDE == STRIDE - 1 {
            ask()?;
        }
        if first == NONE {
            continue;
        }
        let mut reached = 0;
        let mut at = first;
        loop {
            reached += 1;
            at = twins[previous(at) as usize];
            if at == NONE || at == first || reached > count[v] {
                break;
            }
        }
        if reached != count[v] {
            return Err(NotManifold::Vertex { vertex: v as u32 }.into());
        }
    }
    Ok(outgoing)
}
