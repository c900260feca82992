//! The base mesh as a walk over its faces (docs/FORMAT.md, "Base connectivity").
//!
//! Faces are told in the order in which a walk through open edges meets them; a face costs one of a few likely answers,
//! and a vertex its number only where that is not the lowest one unused.

use super::range_coder::{Coder, Decoder, Encoder, Model};
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::VecDeque;

/// A base mesh's faces, from their lowest vertex, sorted; and the ends of its sharp edges, sorted.
pub(in crate::file) type Base = (Vec<[u32; 3]>, Vec<[u32; 2]>);

/// The base mesh as bytes.
pub(in crate::file) fn encode_base(vertices: u32, faces: &[[u32; 3]], sharp: &[[u32; 2]]) -> Vec<u8> {
    let mut encoder = Encoder::default();
    let told = Walk::new(vertices).faces(&mut encoder, faces.len(), faces).expect("a base mesh");
    debug_assert_eq!(told.len(), faces.len());
    sharp_edges(&mut encoder, faces, sharp);
    encoder.finish()
}

/// Reads a base mesh of so many vertices and faces. Memory in proportion to what the bytes hold.
pub(in crate::file) fn decode_base(bytes: &[u8], vertices: u32, faces: usize) -> Result<Base, &'static str> {
    let mut decoder = Decoder::new(bytes);
    let mut told = Walk::new(vertices).faces(&mut decoder, faces, &[])?;
    for face in &mut told {
        let lowest = (0..3).min_by_key(|&k| face[k]).unwrap_or(0);
        face.rotate_left(lowest);
    }
    told.sort_unstable();
    let sharp = sharp_edges(&mut decoder, &told, &[]);
    if decoder.is_exhausted() {
        return Err("the base mesh is too short");
    }
    Ok((told, sharp))
}

/// The marks of the edges in their order: whether there are any, then one bit each.
fn sharp_edges<C: Coder>(coder: &mut C, faces: &[[u32; 3]], sharp: &[[u32; 2]]) -> Vec<[u32; 2]> {
    if coder.raw(1, u32::from(!sharp.is_empty())) == 0 {
        return Vec::new();
    }
    let mut edges: Vec<[u32; 2]> = faces
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]].map(|[v, w]| [v.min(w), v.max(w)]))
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let mut model = Model::EVEN;
    edges.retain(|edge| coder.bit(&mut model, C::WRITES && sharp.binary_search(edge).is_ok()));
    edges
}

/// Where a walk stands.
struct Walk {
    vertices: u32,
    used: Vec<bool>,
    /// No vertex below is unused.
    lowest: u32,
    /// Directed edges that a face yet to come may hold, in the order they opened.
    open: VecDeque<[u32; 2]>,
    /// Of the open edges, the ends by start and the starts by end, in the order they opened. Those that are open no more are
    /// taken out when they are the last.
    from: FxHashMap<u32, Vec<u32>>,
    to: FxHashMap<u32, Vec<u32>>,
    /// Directed edges of faces that were told.
    covered: FxHashSet<[u32; 2]>,
    /// Directed edges at which the walk has been.
    passed: FxHashSet<[u32; 2]>,
    models: WalkModels,
}

struct WalkModels {
    face: Model,
    answers: [[Model; 3]; 4],
    lowest: Model,
}

const WRONG: &str = "the base mesh is not one";

impl Walk {
    fn new(vertices: u32) -> Self {
        Self {
            vertices,
            used: Vec::new(),
            lowest: 0,
            open: VecDeque::new(),
            from: FxHashMap::default(),
            to: FxHashMap::default(),
            covered: FxHashSet::default(),
            passed: FxHashSet::default(),
            models: WalkModels {
                face: Model::new(65000, 4),
                answers: [[Model::EVEN; 3]; 4],
                lowest: Model::EVEN,
            },
        }
    }

    /// Tells `count` faces; `known` are they when writing.
    fn faces<C: Coder>(
        &mut self,
        coder: &mut C,
        count: usize,
        known: &[[u32; 3]],
    ) -> Result<Vec<[u32; 3]>, &'static str> {
        // Every directed edge with the vertex opposite it.
        let mut opposite: FxHashMap<[u32; 2], u32> = FxHashMap::default();
        for &[a, b, c] in known {
            opposite.extend([([a, b], c), ([b, c], a), ([c, a], b)]);
        }
        let mut seeds = known.iter();
        let mut told = Vec::new();
        while told.len() < count {
            let Some([a, b]) = self.open.pop_front() else {
                let seed = seeds.find(|f| !self.covered.contains(&[f[0], f[1]])).copied().unwrap_or_default();
                let face = [0, 1, 2].map(|k| self.any_vertex(coder, seed[k]));
                told.push(self.tell(coder, face)?);
                continue;
            };
            if self.covered.contains(&[a, b]) {
                continue;
            }
            self.passed.insert([a, b]);
            let third = opposite.get(&[a, b]).copied();
            if coder.bit(&mut self.models.face, third.is_some()) {
                let third = self.third(coder, [a, b], third.unwrap_or_default());
                told.push(self.tell(coder, [a, b, third])?);
            } else if coder.is_exhausted() {
                return Err("the base mesh is too short");
            }
        }
        Ok(told)
    }

    /// The third corner at an open edge: an unused vertex, the end of the last open edge that leaves b, the start of the
    /// last one that reaches a, or another.
    fn third<C: Coder>(&mut self, coder: &mut C, [a, b]: [u32; 2], third: u32) -> u32 {
        let Self { from, to, covered, passed, .. } = self;
        let is_open = |edge| !covered.contains(&edge) && !passed.contains(&edge);
        let after = last_open(from, b, |end| is_open([b, end]));
        let before = last_open(to, a, |start| is_open([start, a]));
        let context = match (after, before) {
            (None, None) => 0,
            (Some(x), Some(y)) if x == y => 3,
            (Some(_), Some(_)) => 2,
            _ => 1,
        };
        let unused = C::WRITES && !self.is_used(third);
        if coder.bit(&mut self.models.answers[context][0], unused) {
            return self.unused_vertex(coder, third);
        }
        if let Some(after) = after
            && coder.bit(&mut self.models.answers[context][1], third == after)
        {
            return after;
        }
        if let Some(before) = before.filter(|&before| Some(before) != after)
            && coder.bit(&mut self.models.answers[context][2], third == before)
        {
            return before;
        }
        self.number(coder, third)
    }

    fn any_vertex<C: Coder>(&mut self, coder: &mut C, vertex: u32) -> u32 {
        let unused = C::WRITES && !self.is_used(vertex);
        if coder.bit(&mut self.models.answers[0][0], unused) {
            self.unused_vertex(coder, vertex)
        } else {
            self.number(coder, vertex)
        }
    }

    fn unused_vertex<C: Coder>(&mut self, coder: &mut C, vertex: u32) -> u32 {
        while self.is_used(self.lowest) {
            self.lowest += 1;
        }
        let vertex = if coder.bit(&mut self.models.lowest, vertex == self.lowest) {
            self.lowest
        } else {
            self.number(coder, vertex)
        };
        if vertex < self.vertices {
            let at = vertex as usize;
            if self.used.len() <= at {
                self.used.resize(at + 1, false);
            }
            self.used[at] = true;
        }
        vertex
    }

    fn number<C: Coder>(&self, coder: &mut C, vertex: u32) -> u32 {
        coder.long_raw(32 - self.vertices.saturating_sub(1).leading_zeros(), vertex)
    }

    fn is_used(&self, vertex: u32) -> bool {
        self.used.get(vertex as usize).copied().unwrap_or(false)
    }

    /// Takes a face in, refusing one that cannot stand beside those before it.
    fn tell<C: Coder>(&mut self, coder: &C, face: [u32; 3]) -> Result<[u32; 3], &'static str> {
        if coder.is_exhausted() {
            return Err("the base mesh is too short");
        }
        let [a, b, c] = face;
        if a == b || b == c || c == a || face.iter().any(|&v| v >= self.vertices) {
            return Err(WRONG);
        }
        for [v, w] in [[a, b], [b, c], [c, a]] {
            if !self.covered.insert([v, w]) {
                return Err(WRONG);
            }
            if !self.covered.contains(&[w, v]) {
                self.open.push_back([w, v]);
                self.from.entry(w).or_default().push(v);
                self.to.entry(v).or_default().push(w);
            }
        }
        Ok(face)
    }
}

/// The other end of the last edge at a vertex that is still open. However many there are, each is taken out once.
fn last_open(ends: &mut FxHashMap<u32, Vec<u32>>, of: u32, is_open: impl Fn(u32) -> bool) -> Option<u32> {
    let list = ends.get_mut(&of)?;
    while list.pop_if(|end| !is_open(*end)).is_some() {}
    list.last().copied()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use proptest::prelude::*;

    fn canonical(faces: &[[u32; 3]]) -> Vec<[u32; 3]> {
        let mut faces = faces.to_vec();
        for face in &mut faces {
            let lowest = (0..3).min_by_key(|&k| face[k]).expect("three");
            face.rotate_left(lowest);
        }
        faces.sort_unstable();
        faces
    }

    #[test]
    fn every_awkward_base_is_read_as_written() {
        for (name, mesh) in shapes::awkward() {
            let faces = canonical(&mesh.faces);
            let vertices = mesh.positions.len() as u32;
            let mut sharp: Vec<[u32; 2]> =
                faces.iter().step_by(2).map(|f| [f[0].min(f[1]), f[0].max(f[1])]).collect();
            sharp.sort_unstable();
            sharp.dedup();
            for sharp in [Vec::new(), sharp] {
                let bytes = encode_base(vertices, &faces, &sharp);
                let read =
                    decode_base(&bytes, vertices, faces.len()).unwrap_or_else(|e| panic!("{name}: {e}"));
                assert_eq!(read, (faces.clone(), sharp), "{name}");
                // A shorter stream is never taken for the whole.
                assert!(decode_base(&bytes[..bytes.len() / 2], vertices, faces.len()).is_err(), "{name}");
            }
        }
    }

    /// A reader would follow a writer that takes closed edges for open: their bytes are what files have held from the beginning.
    #[test]
    fn bases_are_told_in_the_same_bytes_for_ever() {
        let bytes: Vec<u8> = shapes::awkward()
            .into_iter()
            .flat_map(|(_, mesh)| encode_base(mesh.positions.len() as u32, &canonical(&mesh.faces), &[]))
            .collect();
        assert_eq!((bytes.len(), crc32fast::hash(&bytes)), (282, 0x54c6_b12b));
    }

    /// Where a walk's front is long and every other edge of it leads to one vertex, a hundred thousand edges there are open at
    /// once. To search through them would take time by its square.
    #[test]
    fn many_open_edges_at_a_vertex_are_not_searched() {
        let (mut faces, mut front, mut next) = (vec![[0, 1, 2]], vec![[1, 0], [2, 1], [0, 2]], 3);
        for _ in 0..16 {
            let grown = front.iter().flat_map(|&[a, b]| {
                next += 1;
                faces.push([a, b, next - 1]);
                [[a, next - 1], [next - 1, b]]
            });
            front = grown.collect();
        }
        faces.extend(front.iter().step_by(2).map(|&[a, b]| [a, b, next]));
        let faces = canonical(&faces);
        let bytes = encode_base(next + 1, &faces, &[]);
        assert!(decode_base(&bytes, next + 1, faces.len()) == Ok((faces, Vec::new())));
    }

    proptest! {
        #[test]
        fn any_bytes_are_read(
            bytes in prop::collection::vec(any::<u8>(), 0..200), vertices in 0u32..5000, faces in 0usize..100_000,
        ) {
            drop(decode_base(&bytes, vertices, faces));
        }
    }
}
