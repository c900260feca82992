//! Splitting a level's storage into what each base face writes: its interior, and the edges it is the first side of.

use crate::hierarchy::BaseMesh;

/// What one face writes of a level.
pub(super) struct FaceBlock<'a, T> {
    /// The face's interior.
    pub(super) interior: &'a mut [T],
    /// By edge of the face: the edge's interior from its low end, if this face is the one to write it.
    pub(super) edges: [Option<&'a mut [T]>; 3],
}

/// Splits `[edge interiors | face interiors]` into blocks by face.
pub(super) fn split_by_face<'a, T>(
    base: &BaseMesh,
    values: &'a mut [T],
    per_edge: usize,
    per_face: usize,
) -> Vec<FaceBlock<'a, T>> {
    let (on_edges, in_faces) = values.split_at_mut(base.edges().len() * per_edge);
    let mut edges = split(on_edges, per_edge, base.edges().len());
    let interiors = split(in_faces, per_face, base.faces().len());
    let mut blocks: Vec<FaceBlock<T>> =
        interiors.into_iter().map(|interior| FaceBlock { interior, edges: [None, None, None] }).collect();
    for edge in (0..base.edges().len()).rev() {
        let side = base.sides(edge as u32)[0].expect("an edge has a face");
        blocks[side.face as usize].edges[usize::from(side.k)] = edges.pop();
    }
    blocks
}

/// `count` parts of the same length, which may be none.
fn split<T>(values: &mut [T], length: usize, count: usize) -> Vec<&mut [T]> {
    let mut rest = values;
    (0..count)
        .map(|_| {
            let (part, after) = std::mem::take(&mut rest).split_at_mut(length);
            rest = after;
            part
        })
        .collect()
}
