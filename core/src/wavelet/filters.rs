//! The filter bank of a hierarchy: for every even vertex of every level, which wavelet coefficients update it.
//!
//! Regular vertices share one constant stencil, addressed by lattice arithmetic. Explicit lists exist only near
//! extraordinary base vertices, boundaries and sharp edges, and at the few coarse levels where neighbourhoods
//! wrap around.

use super::Wavelet;
use super::explicit_rows::{ExplicitRows, Known};
use super::regularity::is_regular;
use super::rows::Stencil;
use super::weights::{LARGEST_DISC, WeightSolver};
use crate::hierarchy::{BaseMesh, Hierarchy, Layout, Level, Odd, Site, Slot};
use crate::mesh::shapes;
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use rustc_hash::FxHashSet;
use thiserror::Error;

/// The neighbourhoods of some vertices are too large for the chosen wavelet.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
#[error(
    "base vertex {vertex} has {valence} neighbours, too many for the {wavelet} wavelet; choose lazy or 0"
)]
pub struct ValenceTooHigh {
    vertex: u32,
    valence: usize,
    wavelet: Wavelet,
}

/// A row of the constant stencil: coefficients at one row offset, with their offsets along it.
#[derive(Debug)]
struct TapRow {
    dr: i32,
    taps: Vec<(i32, i32)>,
}

/// All weights needed to analyse and synthesise surfaces over one hierarchy.
#[derive(Debug)]
pub struct Filters {
    wavelet: Wavelet,
    regular: Vec<TapRow>,
    stencil: Stencil,
    explicit: Vec<ExplicitRows>,
}

impl Filters {
    /// Solves the weights for the levels below J. Cost: the base mesh's neighbourhoods at each level, not their
    /// interiors.
    ///
    /// # Errors
    /// A base vertex has so many neighbours that its weights would take minutes.
    pub fn new(hierarchy: &Hierarchy, wavelet: Wavelet) -> Result<Self, ValenceTooHigh> {
        if let Wavelet::Disc(k) = wavelet
            && k > 0
            && hierarchy.finest() > Level::BASE
        {
            refuse_large_discs(hierarchy.base(), wavelet, k)?;
        }
        let known = Known::new(hierarchy.base(), wavelet);
        let regular = regular_taps(&known.solver, wavelet);
        let layouts = |level: Level| (hierarchy.layout(level), hierarchy.layout(level.finer()));
        let explicit = (0..hierarchy.finest().0)
            .into_par_iter()
            .map(|j| ExplicitRows::new(&known, layouts(Level(j)), wavelet))
            .collect();
        let taps = regular.iter().flat_map(|row| row.taps.iter().map(|&(di, w)| (row.dr, di, w)));
        let stencil = Stencil::new(taps);
        Ok(Self { wavelet, regular, stencil, explicit })
    }

    /// The wavelet these weights belong to.
    pub fn wavelet(&self) -> Wavelet {
        self.wavelet
    }

    /// The constant stencil as the row kernels take it.
    pub(super) fn stencil(&self) -> &Stencil {
        &self.stencil
    }

    /// `Σ_i w_iv d_i` for an even vertex `v` of level j: exact, in any order. Cost: the stencil, 72 taps for the
    /// 2-disc wavelet at a regular vertex.
    pub fn gather<const N: usize>(&self, layout: &Layout, site: Site, d: &[[i32; N]]) -> [i64; N] {
        if let Some(row) = self.explicit_row(layout, site) {
            return explicit_sum(row, d);
        }
        let mut sum = [0i64; N];
        self.for_each_tap(layout, site, |odd, weight| {
            let d = d[odd.index()];
            sum = std::array::from_fn(|c| sum[c] + i64::from(weight) * i64::from(d[c]));
        });
        sum
    }

    /// [`Filters::gather`] for details within [`crate::surface::LIMIT`], of which a class of taps adds within 32 bits.
    pub fn sum_within_limit<const N: usize>(&self, layout: &Layout, site: Site, d: &[[i32; N]]) -> [i64; N] {
        if self.wavelet == Wavelet::Lazy {
            return [0; N];
        }
        if let Some(row) = self.explicit_row(layout, site) {
            return explicit_sum(row, d);
        }
        let reach = self.wavelet.reach() as u32;
        let (face, b) = layout.chart(site);
        let at = [b[1], b[2]];
        if b.iter().all(|&b| 2 * b > reach) {
            self.stencil.sum_inside(layout, face, at, d)
        } else {
            self.stencil.sum_across(layout, face, at, d)
        }
    }

    /// [`Filters::gather`] on a level too coarse for the constant stencil, by slot.
    pub(super) fn sum_on_coarse<const N: usize>(
        &self,
        level: Level,
        slot: usize,
        d: &[[i32; N]],
    ) -> [i64; N] {
        if self.wavelet == Wavelet::Lazy {
            return [0; N];
        }
        explicit_sum(self.explicit[level.index()].row(Slot(slot as u32)), d)
    }

    /// [`Filters::gather`] for all irregular even vertices of a level that is not coarse, by slot.
    pub(super) fn irregular_sums<const N: usize>(
        &self,
        level: Level,
        d: &[[i32; N]],
    ) -> impl IndexedParallelIterator<Item = (Slot, [i64; N])> {
        self.explicit[level.index()].all().map(move |(slot, row)| (slot, explicit_sum(row, d)))
    }

    /// The taps of an irregular even vertex.
    pub(super) fn explicit_row(&self, layout: &Layout, site: Site) -> Option<&[(Odd, i32)]> {
        if is_regular(layout, site, self.wavelet) {
            return None;
        }
        Some(self.explicit[layout.level().index()].row(layout.slot(site)))
    }

    /// Calls back for every coefficient of level j that updates the even vertex, with its weight.
    pub fn for_each_tap(&self, layout: &Layout, site: Site, mut tap: impl FnMut(Odd, i32)) {
        if self.wavelet == Wavelet::Lazy {
            return;
        }
        if let Some(row) = self.explicit_row(layout, site) {
            row.iter().for_each(|&(odd, weight)| tap(odd, weight));
            return;
        }
        let (face, b) = layout.chart(site);
        let doubled = b.map(|x| 2 * x as i32);
        let reach = self.wavelet.reach();
        if doubled.iter().all(|&x| x > reach) {
            let start = layout.odd_face_start(face);
            for row in &self.regular {
                let r = doubled[2] + row.dr;
                let row_start = start + layout.odd_row_start(r as u32);
                // Odd rows hold every vertex, even rows every second.
                let shift = u32::from(r % 2 == 0);
                for &(di, weight) in &row.taps {
                    tap(Odd(row_start + ((doubled[1] + di - 1) as u32 >> shift)), weight);
                }
            }
            return;
        }
        for row in &self.regular {
            for &(di, weight) in &row.taps {
                let at = [doubled[0] - di - row.dr, doubled[1] + di, doubled[2] + row.dr];
                let odd =
                    layout.resolve_odd(face, at).expect("a regular vertex's stencil stays on the surface");
                tap(odd, weight);
            }
        }
    }
}

/// `Σ w d` over the taps of one row.
fn explicit_sum<const N: usize>(row: &[(Odd, i32)], d: &[[i32; N]]) -> [i64; N] {
    // Three channels are read four at a time, which the last detail does not allow. The last comes last.
    let end = row.last().map_or(0, |(odd, _)| 3 * odd.index() + 4);
    if N == 3 && end <= 3 * d.len() {
        let sum = Arch::new().dispatch(FourLanes { row, d: d.as_flattened() });
        return std::array::from_fn(|c| sum[c]);
    }
    let mut sum = [0i64; N];
    for &(odd, weight) in row {
        for (sum, &d) in sum.iter_mut().zip(&d[odd.index()]) {
            *sum += i64::from(weight) * i64::from(d);
        }
    }
    sum
}

/// Three channels and the value after them.
struct FourLanes<'a> {
    row: &'a [(Odd, i32)],
    d: &'a [i32],
}

impl WithSimd for FourLanes<'_> {
    type Output = [i64; 4];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> [i64; 4] {
        let mut sum = [0i64; 4];
        for &(odd, weight) in self.row {
            let at = 3 * odd.index();
            let d: &[i32; 4] = self.d[at..at + 4].try_into().expect("of that length");
            for c in 0..4 {
                sum[c] += i64::from(d[c]) * i64::from(weight);
            }
        }
        sum
    }
}

/// The constant stencil, read off the middle of one finely divided triangle.
fn regular_taps(solver: &WeightSolver, wavelet: Wavelet) -> Vec<TapRow> {
    if wavelet == Wavelet::Lazy {
        return Vec::new();
    }
    let triangle = shapes::triangle();
    let base = BaseMesh::new(3, triangle.faces, &[]).expect("a triangle is a base mesh");
    let layout = Layout::checked(&std::sync::Arc::new(base), Level(6)).expect("a small level");
    let mut rows: std::collections::BTreeMap<i32, Vec<(i32, i32)>> = Default::default();
    // One odd vertex of each direction near the middle: coordinates with sum 2n = 128, one of them even.
    for at in [[42, 43, 43], [43, 42, 43], [43, 43, 42]] {
        let site = Site::Face { face: 0, i: at[1] as u32, r: at[2] as u32 };
        let stencil = solver.stencil(&layout, site, wavelet);
        for (&v, &weight) in stencil.vertices.iter().zip(&stencil.weights) {
            let Site::Face { i, r, .. } = v else { unreachable!("the middle of the triangle") };
            rows.entry(at[2] - 2 * r as i32).or_default().push((at[1] - 2 * i as i32, weight));
        }
    }
    rows.into_iter()
        .map(|(dr, mut taps)| {
            taps.sort_unstable();
            TapRow { dr, taps }
        })
        .collect()
}

/// Refuses base meshes over which some disc has more than [`LARGEST_DISC`] vertices; on finer levels none is larger than on
/// the coarsest. `O(faces)`, and of large neighbourhoods each edge's disc.
fn refuse_large_discs(base: &BaseMesh, wavelet: Wavelet, k: u8) -> Result<(), ValenceTooHigh> {
    let valence = |vertex: u32| base.fan(vertex).corners.len();
    let refused = |vertex| Err(ValenceTooHigh { vertex, valence: valence(vertex), wavelet });
    if let Some(vertex) = (0..base.vertex_count()).find(|&vertex| valence(vertex) > LARGEST_DISC / 4) {
        return refused(vertex);
    }
    // Two edges away lie at most so many vertices.
    let reach: Vec<usize> = (0..base.vertex_count())
        .map(|vertex| {
            base.fan(vertex)
                .corners
                .iter()
                .flat_map(|&(face, _)| base.faces()[face as usize])
                .map(valence)
                .sum()
        })
        .collect();
    for &[u, w] in base.edges() {
        if reach[u as usize] + reach[w as usize] > LARGEST_DISC && disc_is_too_large(base, [u, w], k) {
            return refused(if valence(u) < valence(w) { w } else { u });
        }
    }
    Ok(())
}

/// Whether more than [`LARGEST_DISC`] base vertices lie within `k` edges of the ends of an edge.
fn disc_is_too_large(base: &BaseMesh, ends: [u32; 2], k: u8) -> bool {
    let mut found: FxHashSet<u32> = ends.into_iter().collect();
    let mut rim = ends.to_vec();
    for _ in 0..k {
        let around = rim.iter().flat_map(|&vertex| &base.fan(vertex).corners);
        let near = around.flat_map(|&(face, _)| base.faces()[face as usize]);
        rim = near.filter(|&vertex| found.insert(vertex)).take(LARGEST_DISC).collect();
        if found.len() > LARGEST_DISC {
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    /// A hub of `hubs` triangles, each cut by a chain of `chain` vertices that sees both other corners.
    fn hubs(hubs: u32, chain: u32) -> Hierarchy {
        let mut faces = Vec::new();
        for hub in 0..hubs {
            let (a, b, first) = (1 + hub, 1 + (hub + 1) % hubs, 1 + hubs + hub * chain);
            let along: Vec<u32> = [0].into_iter().chain(first..first + chain).chain([b]).collect();
            for pair in along.windows(2) {
                faces.push([a, pair[0], pair[1]]);
                if pair[1] != b {
                    faces.push([b, pair[1], pair[0]]);
                }
            }
        }
        let base = BaseMesh::new(1 + hubs + hubs * chain, faces, &[]).expect("a disk");
        Hierarchy::new(Arc::new(base), Level(1)).expect("small")
    }

    /// No vertex has very many neighbours, but those of the neighbours are too many.
    #[test]
    fn discs_around_hubs_of_hubs_are_bounded() {
        let large = hubs(40, 60);
        assert!(Filters::new(&large, Wavelet::Disc(2)).is_err());
        assert!(Filters::new(&large, Wavelet::Disc(0)).is_ok());
        assert!(Filters::new(&hubs(6, 6), Wavelet::Disc(2)).is_ok());
    }
}
