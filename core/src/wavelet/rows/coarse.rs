//! Levels too coarse for the constant stencil, and subdivision alone. On such levels every even vertex has its own weights, kept in
//! the order of slots, so that nothing is looked for. The same bits as [`crate::wavelet::lifting`].

use crate::hierarchy::{Layout, row_slots};
use crate::wavelet::Filters;
use crate::wavelet::lifting::{minus, plus, predicted, rounded};
use rayon::prelude::*;

/// Vertices that a task has at least.
const TASK: usize = 1024;

/// `c^{j+1}` to `d^j` and `c^j` on a coarse level.
pub(super) fn analyse<const N: usize>(
    filters: &Filters,
    coarse: &Layout,
    finer: &[[i32; N]],
    (details, coarser): (&mut [[i32; N]], &mut [[i32; N]]),
) {
    let Blocks { n, vertices, edges } = Blocks::of(coarse);
    let (corners, rest) = coarser.split_at_mut(vertices);
    let (on_edges, inside) = rest.split_at_mut((n - 1) * edges);
    corners.copy_from_slice(&finer[..vertices]);
    let (fine_edges, fine_faces) = finer[vertices..].split_at((2 * n - 1) * edges);
    for (evens, fine_edge) in on_edges.chunks_mut((n - 1).max(1)).zip(fine_edges.chunks(2 * n - 1)) {
        evens.iter_mut().zip(fine_edge.iter().skip(1).step_by(2)).for_each(|(even, &value)| *even = value);
    }
    let per_face = interior(2 * n).max(1);
    for (evens, mut fine_face) in inside.chunks_mut(interior(n).max(1)).zip(fine_faces.chunks(per_face)) {
        let mut evens = evens.iter_mut();
        for r in 1..2 * n - 1 {
            let row = fine_face.split_off(..2 * n - r - 1).expect("whole rows");
            if r % 2 == 0 {
                let row = row.iter().skip(1).step_by(2);
                evens.by_ref().take(n - r / 2 - 1).zip(row).for_each(|(even, &value)| *even = value);
            }
        }
    }
    let evens = &*coarser;
    let (on_edges, inside) = details.split_at_mut(n * edges);
    for (edge, (odds, fine_edge)) in on_edges.chunks_mut(n).zip(fine_edges.chunks(2 * n - 1)).enumerate() {
        for (s, (odd, &value)) in odds.iter_mut().zip(fine_edge.iter().step_by(2)).enumerate() {
            *odd = minus(value, on_edge(coarse, evens, edge, s));
        }
    }
    let faces = inside.par_chunks_mut(odd_interior(n).max(1)).zip(fine_faces.par_chunks(per_face));
    faces.enumerate().with_min_len(TASK / per_face + 1).for_each_init(
        Beside::default,
        |beside, (face, (odds, mut fine_face))| {
            let mut odds = odds.iter_mut();
            for r in 1..2 * n - 1 {
                let row = fine_face.split_off(..2 * n - r - 1).expect("whole rows");
                beside.go_to(coarse, face as u32, r, evens);
                for (at, &value) in row.iter().enumerate().step_by(2 - r % 2) {
                    *odds.next().expect("as many as odd vertices") = minus(value, beside.predicted(r, at));
                }
            }
        },
    );
    let details = &*details;
    coarser.par_iter_mut().enumerate().with_min_len(TASK).for_each(|(slot, even)| {
        *even = plus(*even, rounded(filters.sum_on_coarse(coarse.level(), slot, details)));
    });
}

/// `c^j` and `d^j` to `c^{j+1}` on a coarse level.
pub(super) fn synthesise<const N: usize>(
    filters: &Filters,
    coarse: &Layout,
    (coarser, details): (&[[i32; N]], &[[i32; N]]),
    finer: &mut [[i32; N]],
) {
    let updated = |(slot, &even): (usize, &[i32; N])| {
        minus(even, rounded(filters.sum_on_coarse(coarse.level(), slot, details)))
    };
    let evens: Vec<[i32; N]> = coarser.par_iter().enumerate().with_min_len(TASK).map(updated).collect();
    subdivide(coarse, &evens, finer);
    onto_odds(coarse, finer, details, plus);
}

/// `c^j` to `c^{j+1}` without details, on any level: even vertices stay, odd ones are in the middle. `O(n_{j+1})`.
pub(super) fn subdivide<const N: usize>(coarse: &Layout, evens: &[[i32; N]], finer: &mut [[i32; N]]) {
    let Blocks { n, vertices, edges } = Blocks::of(coarse);
    let (corners, rest) = finer.split_at_mut(vertices);
    corners.copy_from_slice(&evens[..vertices]);
    let (fine_edges, fine_faces) = rest.split_at_mut((2 * n - 1) * edges);
    for (edge, fine_edge) in fine_edges.chunks_mut(2 * n - 1).enumerate() {
        let stay = &evens[vertices + edge * (n - 1)..][..n - 1];
        fine_edge.iter_mut().skip(1).step_by(2).zip(stay).for_each(|(value, &even)| *value = even);
        for (s, value) in fine_edge.iter_mut().step_by(2).enumerate() {
            *value = on_edge(coarse, evens, edge, s);
        }
    }
    let per_face = interior(2 * n).max(1);
    let faces = fine_faces.par_chunks_mut(per_face).enumerate();
    faces.with_min_len(TASK / per_face + 1).for_each_init(
        Beside::default,
        |beside, (face, mut fine_face)| {
            for r in 1..2 * n - 1 {
                let row = fine_face.split_off_mut(..2 * n - r - 1).expect("whole rows");
                beside.go_to(coarse, face as u32, r, evens);
                for (at, value) in row.iter_mut().enumerate() {
                    *value = match (r % 2, at % 2) {
                        (0, 1) => beside.after[at.div_ceil(2)],
                        _ => beside.predicted(r, at),
                    };
                }
            }
        },
    );
}

/// Changes each odd vertex of `M^{j+1}` by what there is for it. `O(n_{j+1})`, in parallel over base faces.
fn onto_odds<const N: usize>(
    coarse: &Layout,
    finer: &mut [[i32; N]],
    values: &[[i32; N]],
    change: impl Fn([i32; N], [i32; N]) -> [i32; N] + Sync,
) {
    let Blocks { n, vertices, edges } = Blocks::of(coarse);
    let (on_edges, inside) = values.split_at(n * edges);
    let (fine_edges, fine_faces) = finer[vertices..].split_at_mut((2 * n - 1) * edges);
    for (fine_edge, values) in fine_edges.chunks_mut(2 * n - 1).zip(on_edges.chunks(n)) {
        fine_edge.iter_mut().step_by(2).zip(values).for_each(|(odd, &value)| *odd = change(*odd, value));
    }
    let per_face = interior(2 * n).max(1);
    let faces = fine_faces.par_chunks_mut(per_face).zip(inside.par_chunks(odd_interior(n).max(1)));
    faces.with_min_len(TASK / per_face + 1).for_each(|(mut fine_face, mut values)| {
        for r in 1..2 * n - 1 {
            let row = fine_face.split_off_mut(..2 * n - r - 1).expect("whole rows");
            let step = 2 - r % 2;
            let own = values.split_off(..row.len().div_ceil(step)).expect("as many as odd vertices");
            let odds = row.iter_mut().step_by(step);
            odds.zip(own).for_each(|(odd, &value)| *odd = change(*odd, value));
        }
    });
}

/// How large the blocks of a level's storage are.
struct Blocks {
    n: usize,
    vertices: usize,
    edges: usize,
}

impl Blocks {
    fn of(coarse: &Layout) -> Self {
        let base = coarse.base();
        Self {
            n: coarse.segments() as usize,
            vertices: base.vertex_count() as usize,
            edges: base.edges().len(),
        }
    }
}

/// Vertices inside a face of `n` segments a side.
fn interior(n: usize) -> usize {
    (n - 1) * n.saturating_sub(2) / 2
}

/// Odd vertices inside a face of `M^j`.
fn odd_interior(n: usize) -> usize {
    3 * n * (n - 1) / 2
}

/// The middle of the edge after `s` edges of `M^j` along a base edge.
fn on_edge<const N: usize>(coarse: &Layout, evens: &[[i32; N]], edge: usize, s: usize) -> [i32; N] {
    let end = |t: usize| evens[coarse.slot(coarse.along_edge(edge as u32, t as u32)).index()];
    predicted(end(s), end(s + 1))
}

/// The rows of `M^j` beside a row of `M^{j+1}` in a face, borders included.
struct Beside<const N: usize> {
    slots: Vec<u32>,
    before: Vec<[i32; N]>,
    /// The row after it, or the row itself where `M^j` has it.
    after: Vec<[i32; N]>,
}

impl<const N: usize> Default for Beside<N> {
    fn default() -> Self {
        Self { slots: Vec::new(), before: Vec::new(), after: Vec::new() }
    }
}

impl<const N: usize> Beside<N> {
    /// On to row `r` from the row before it.
    fn go_to(&mut self, coarse: &Layout, face: u32, r: usize, evens: &[[i32; N]]) {
        let Self { slots, before, after } = self;
        let mut read = |r: usize, row: &mut Vec<[i32; N]>| {
            row_slots(coarse, face, r as u32, slots);
            row.clear();
            row.extend(slots.iter().map(|&slot| evens[slot as usize]));
        };
        if r == 1 {
            read(0, after);
        }
        if r % 2 == 1 {
            std::mem::swap(before, after);
            read(r / 2 + 1, after);
        }
    }

    /// What its parents predict for the vertex at a place of row `r`, the first inside the face at 0.
    #[inline(always)]
    fn predicted(&self, r: usize, at: usize) -> [i32; N] {
        let (half, after) = (at / 2, &self.after);
        match (r % 2, at % 2) {
            (1, 0) => predicted(self.before[half + 1], after[half]),
            (1, _) => predicted(self.before[half + 1], after[half + 1]),
            _ => predicted(after[half], after[half + 1]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::{BaseMesh, Hierarchy, Level};
    use crate::mesh::shapes;
    use crate::wavelet::{Wavelet, lifting};
    use std::sync::Arc;

    /// Details of zero need neither be stored nor looked at.
    #[test]
    fn subdivision_is_synthesis_without_details() {
        for (name, mesh) in shapes::awkward() {
            let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &[]).expect(name);
            let meshes = Hierarchy::new(Arc::new(base), Level(4)).expect("small");
            let filters = Filters::new(&meshes, Wavelet::Disc(1)).expect("small valences");
            for level in (0..4).map(Level) {
                let (coarse, fine) = (meshes.layout(level), meshes.layout(level.finer()));
                let number = |k: u32| (k.wrapping_mul(0x9e37_79b9) >> 6) as i32 - (1 << 25);
                let evens: Vec<[i32; 3]> =
                    (0..coarse.len()).map(|v| [3 * v, 3 * v + 1, 3 * v + 2].map(number)).collect();
                let details = vec![[0; 3]; coarse.odd_len() as usize];
                let mut finer = vec![[7; 3]; fine.len() as usize];
                subdivide(coarse, &evens, &mut finer);
                let wanted = lifting::synthesise_level(&meshes, &filters, level, &evens, &details);
                assert!(finer == wanted, "{name}, level {}", level.0);
            }
        }
    }
}
