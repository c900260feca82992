//! The transform that a stream is written in: the surface's own, or one that codes better.
//!
//! Which one is chosen changes nothing of the surface: all are integer lifting of the same finest positions, exact both
//! ways. Based on: Schröder, Sweldens, "Spherical Wavelets", SIGGRAPH 1995, for lifting the butterfly scheme. With bends
//! the detail of an odd vertex is what [`super::butterfly`] leaves of it, beyond the mean of its parents.

use super::butterfly::{Curves, by_rows};
use crate::hierarchy::{Hierarchy, Layout, Level};
use crate::memory::Buffer;
use crate::surface::{Surface, Vector};
use crate::wavelet::lifting::{minus, plus};
use crate::wavelet::{Filters, ValenceTooHigh, Wavelet, rows};
use rayon::prelude::*;

/// Transforms are compared by what coefficients have above this many bits of the surface's half extent: about the detail
/// of 75 dB.
const SEEN_BITS: u8 = 12;

/// Which transform.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::file) enum Coding {
    /// The surface's own.
    Own,
    /// The butterfly scheme with the update of a wavelet.
    Butterfly(Wavelet),
}

impl Coding {
    /// The number that stands for it in files: 0, or the wavelet's code and 1.
    pub(in crate::file) fn code(self) -> u8 {
        match self {
            Coding::Own => 0,
            Coding::Butterfly(wavelet) => wavelet.code() + 1,
        }
    }

    /// The transform with a given code.
    pub(in crate::file) fn from_code(code: u8) -> Option<Self> {
        match code {
            0 => Some(Coding::Own),
            code => Wavelet::from_code(code - 1).map(Coding::Butterfly),
        }
    }

    /// The wavelet whose update the butterfly scheme has in a stream of a surface with a given one.
    pub(super) fn smooth_update(own: Wavelet) -> Wavelet {
        if own == Wavelet::Lazy { Wavelet::Disc(0) } else { own }
    }

    /// The weights of its update; `None` if they are those of the surface's wavelet.
    ///
    /// # Errors
    /// A base vertex has too high a valence.
    pub(in crate::file) fn filters(
        self,
        hierarchy: &Hierarchy,
        own: Wavelet,
    ) -> Result<Option<Filters>, ValenceTooHigh> {
        match self {
            Coding::Butterfly(wavelet) if wavelet != own => Filters::new(hierarchy, wavelet).map(Some),
            _ => Ok(None),
        }
    }
}

/// A surface in the transform that is best for it.
pub(super) struct Coded {
    pub(super) coding: Coding,
    /// The weights of its update; `None` for the surface's.
    pub(super) filters: Option<Filters>,
    /// `c^0`.
    pub(super) base: Buffer<Vector>,
    /// Each `d^j`.
    pub(super) details: Vec<Buffer<Vector>>,
}

impl Coded {
    /// The butterfly scheme with the surface's own update, or with the 0-disc one where that is lazy; the surface's own
    /// transform where its coefficients have fewer bits, as those of flat faces without marked edges. `O(n_J)`.
    pub(super) fn best(surface: &Surface) -> Self {
        let hierarchy = surface.hierarchy();
        let coding = Coding::Butterfly(Coding::smooth_update(surface.form().wavelet));
        let others =
            coding.filters(hierarchy, surface.form().wavelet).expect("small systems, or solved before");
        let filters = others.as_ref().unwrap_or_else(|| surface.filters());
        let (base, details) =
            Transform { coding, hierarchy, filters }.analyse(surface.scaling(surface.finest()));
        let unseen = u32::from(surface.form().precision.saturating_sub(SEEN_BITS));
        let bits = |details: &[Vector]| -> u64 {
            let of = |x: &i32| u64::from(32 - (x.unsigned_abs() >> unseen).leading_zeros());
            details.par_iter().map(|d| d.iter().map(of).sum::<u64>()).sum()
        };
        let smooth: u64 = details.iter().map(|details| bits(details)).sum();
        let own = (0..surface.finest().0).map(|j| surface.wavelets(Level(j)));
        if own.clone().map(bits).sum::<u64>() >= smooth {
            return Self { coding, filters: others, base, details };
        }
        let base = surface.scaling(Level::BASE).into();
        Self { coding: Coding::Own, filters: None, base, details: own.map(Into::into).collect() }
    }
}

/// A transform over a hierarchy.
#[derive(Debug, Clone, Copy)]
pub(super) struct Transform<'a> {
    pub(super) coding: Coding,
    pub(super) hierarchy: &'a Hierarchy,
    pub(super) filters: &'a Filters,
}

impl Transform<'_> {
    /// Whether details are what a smooth prediction leaves.
    pub(super) fn bends(self) -> bool {
        self.coding != Coding::Own
    }

    /// One level of analysis: `c^{j+1}` to `d^j` and `c^j`. `O(n_{j+1})`.
    pub(super) fn analyse_level(self, level: Level, finer: &[Vector]) -> (Buffer<Vector>, Buffer<Vector>) {
        if !self.bends() {
            return rows::analyse_level(self.hierarchy, self.filters, level, finer);
        }
        let mut straight = Buffer::from(finer);
        self.add_bends(level, (&self.evens(level, finer), &mut straight), minus);
        rows::analyse_level(self.hierarchy, self.filters, level, &straight)
    }

    /// One level of synthesis without details: the bits that details of zero give. `O(n_{j+1})`.
    pub(super) fn subdivide(self, level: Level, coarser: &[Vector]) -> Buffer<Vector> {
        let mut finer = rows::subdivide(self.hierarchy, level, coarser);
        if self.bends() {
            // The even vertices are those of the coarser level.
            self.add_bends(level, (coarser, &mut finer), plus);
        }
        finer
    }

    /// One level of synthesis: `c^j` and `d^j` to `c^{j+1}`. `O(n_{j+1})`.
    pub(super) fn synthesise_level(
        self,
        level: Level,
        coarser: &[Vector],
        details: Buffer<Vector>,
    ) -> Buffer<Vector> {
        let mut finer = rows::synthesise_level(self.hierarchy, self.filters, level, coarser, &details);
        // Before there are bends, which are as large.
        drop(details);
        if self.bends() {
            let evens = self.evens(level, &finer);
            self.add_bends(level, (&evens, &mut finer), plus);
        }
        finer
    }

    /// All levels of analysis: `c^J` to `c^0` and each `d^j`. `O(n_J)`.
    pub(super) fn analyse(self, finest: &[Vector]) -> (Buffer<Vector>, Vec<Buffer<Vector>>) {
        let (mut positions, mut details) = (None::<Buffer<Vector>>, Vec::new());
        for j in (0..self.hierarchy.finest().0).rev() {
            let (d, coarser) = self.analyse_level(Level(j), positions.as_deref().unwrap_or(finest));
            details.push(d);
            positions = Some(coarser);
        }
        details.reverse();
        (positions.unwrap_or_else(|| finest.into()), details)
    }

    /// The even vertices of `M^{j+1}`, by slot of `M^j`.
    fn evens(self, level: Level, finer: &[Vector]) -> Buffer<Vector> {
        evens(self.hierarchy.layout(level), self.hierarchy.layout(level.finer()), finer)
    }

    /// Adds the bends, or takes them off, of the odd vertices of `M^{j+1}`, from the even ones, which are given by slot of `M^j`.
    fn add_bends(
        self,
        level: Level,
        (evens, finer): (&[Vector], &mut [Vector]),
        add: impl Fn(Vector, Vector) -> Vector + Sync,
    ) {
        let coarse = self.hierarchy.layout(level);
        let (edges, faces) = (coarse.base().edges().len(), coarse.base().faces().len());
        let n = coarse.segments() as usize;
        let (_, rest) = finer.split_at_mut(coarse.base().vertex_count() as usize);
        let (fine_edges, mut inside) = rest.split_at_mut((2 * n - 1) * edges);
        let per_face = inside.len() / faces;
        let faces =
            (0..faces).map(|_| inside.split_off_mut(..per_face).expect("every face has as many")).collect();
        let in_row = |left: &mut &mut [Vector], r: usize, bends: &[Vector]| {
            let row = left.split_off_mut(..2 * n - r - 1).expect("as many rows");
            let odds = row.iter_mut().step_by(2 - r % 2);
            odds.zip(bends).for_each(|(odd, &bend)| *odd = add(*odd, bend));
        };
        let on_edges = by_rows(self.hierarchy, level, (evens, Curves::Kept), faces, in_row);
        for (edge, bends) in fine_edges.chunks_mut(2 * n - 1).zip(on_edges.chunks(n)) {
            edge.iter_mut().step_by(2).zip(bends).for_each(|(odd, &bend)| *odd = add(*odd, bend));
        }
    }
}

/// The even vertices of `M^{j+1}`, by slot of `M^j`.
fn evens(coarse: &Layout, fine: &Layout, finer: &[Vector]) -> Buffer<Vector> {
    let (base, n) = (coarse.base(), coarse.segments());
    let mut evens = Buffer::zeroed(coarse.len() as usize);
    let corners = base.vertex_count() as usize;
    evens[..corners].copy_from_slice(&finer[..corners]);
    if n == 1 {
        return evens;
    }
    let (n, edges) = (n as usize, base.edges().len());
    let (on_edges, inside) = evens[corners..].split_at_mut((n - 1) * edges);
    let fine_edges = finer[corners..].chunks(2 * n - 1);
    for (edge, fine_edge) in on_edges.chunks_mut(n - 1).zip(fine_edges) {
        edge.iter_mut().zip(fine_edge.iter().skip(1).step_by(2)).for_each(|(even, &value)| *even = value);
    }
    if inside.is_empty() {
        return evens;
    }
    let per_face = inside.len() / base.faces().len();
    inside.par_chunks_mut(per_face).enumerate().with_min_len(1024 / (n * n) + 1).for_each(
        |(face, inside)| {
            let mut inside = inside.iter_mut();
            for r in 1..n - 1 {
                let start = fine.row(face as u32, 2 * r as u32).index();
                let row = finer[start + 1..].iter().step_by(2);
                inside.by_ref().take(n - r - 1).zip(row).for_each(|(even, &value)| *even = value);
            }
        },
    );
    evens
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::{BaseMesh, Slot};
    use crate::mesh::shapes;
    use crate::surface::FormOptions;
    use std::sync::Arc;

    fn numbers(count: u32, bits: u32, seed: u32) -> Vec<Vector> {
        let number = |k: u32| {
            let mixed = k.wrapping_add(seed).wrapping_mul(0x9e37_79b9) ^ k.rotate_left(13);
            (mixed.wrapping_mul(0x85eb_ca6b) as i32) >> (32 - bits)
        };
        (0..count).map(|v| [3 * v, 3 * v + 1, 3 * v + 2].map(number)).collect()
    }

    /// Exact both ways whatever the numbers, those beyond every limit included.
    #[test]
    fn transforms_are_undone_exactly() {
        for (name, mesh) in shapes::awkward() {
            for sharp in [0, 3] {
                let marks: Vec<[u32; 2]> = mesh.faces.iter().take(sharp).map(|f| [f[0], f[1]]).collect();
                let base =
                    BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &marks).expect(name);
                let hierarchy = Hierarchy::new(Arc::new(base), Level(4)).expect("small");
                let own = Filters::new(&hierarchy, Wavelet::Disc(1)).expect("small valences");
                for coding in (0..5).map(|code| Coding::from_code(code).expect("known")) {
                    let others = coding.filters(&hierarchy, Wavelet::Disc(1)).expect("small valences");
                    let filters = others.as_ref().unwrap_or(&own);
                    let transform = Transform { coding, hierarchy: &hierarchy, filters };
                    for (j, bits) in (0..4u8).flat_map(|j| [(j, 24), (j, 32)]) {
                        let count = hierarchy.layout(Level(j + 1)).len();
                        let finer = numbers(count, bits, 7);
                        let (details, coarser) = transform.analyse_level(Level(j), &finer);
                        let again = transform.synthesise_level(Level(j), &coarser, details.clone());
                        assert!(again[..] == finer, "{name}, {coding:?}, level {j}, {bits} bits");
                    }
                }
            }
        }
    }

    /// Even vertices are those that the coarser level has.
    #[test]
    fn evens_are_the_coarser_vertices() {
        for (name, mesh) in shapes::awkward() {
            let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &[]).expect(name);
            let hierarchy = Hierarchy::new(Arc::new(base), Level(4)).expect("small");
            for j in 0..4 {
                let (coarse, fine) = (hierarchy.layout(Level(j)), hierarchy.layout(Level(j + 1)));
                let finer = numbers(fine.len(), 30, 1);
                let wanted: Vec<Vector> = (0..coarse.len())
                    .map(|v| finer[fine.slot(Layout::refine(coarse.site(Slot(v)))).index()])
                    .collect();
                assert!(evens(coarse, fine, &finer)[..] == wanted, "{name}, level {j}");
            }
        }
    }

    /// A flat octahedron whose edges are not marked is written in its own transform, a ball is not.
    #[test]
    fn flat_faces_keep_their_own_transform() {
        let chosen = |of: fn([f64; 3]) -> [f64; 3]| {
            let mesh = shapes::octahedron();
            let base = BaseMesh::new(6, mesh.faces.clone(), &[]).expect("a base mesh");
            let hierarchy = Hierarchy::new(Arc::new(base), Level(5)).expect("small");
            let layout = hierarchy.layout(Level(5));
            let place = |slot: u32| {
                let (face, b) = layout.chart(layout.site(Slot(slot)));
                let corners = hierarchy.base().faces()[face as usize].map(|v| mesh.positions[v as usize]);
                of([0, 1, 2].map(|c| (0..3).map(|k| f64::from(b[k]) * corners[k][c]).sum::<f64>()))
            };
            let positions: Vec<[f64; 3]> = (0..layout.len()).map(place).collect();
            let form = FormOptions { wavelet: Wavelet::Disc(1), ..FormOptions::default() };
            Coded::best(&Surface::from_positions(hierarchy, &positions, &form).expect("small valences"))
                .coding
        };
        assert_eq!(chosen(|p| p), Coding::Own);
        let ball = |p: [f64; 3]| {
            let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
            p.map(|x| x / length)
        };
        assert_eq!(chosen(ball), Coding::Butterfly(Wavelet::Disc(1)));
    }

    /// Of a smooth surface the butterfly scheme leaves less than the mean of parents does.
    #[test]
    fn smooth_surfaces_have_small_details() {
        let mesh = shapes::octahedron();
        let base = BaseMesh::new(6, mesh.faces.clone(), &[]).expect("a base mesh");
        let hierarchy = Hierarchy::new(Arc::new(base), Level(6)).expect("small");
        let layout = hierarchy.layout(Level(6));
        let finest: Vec<Vector> = (0..layout.len())
            .map(|slot| {
                let (face, b) = layout.chart(layout.site(Slot(slot)));
                let corners = hierarchy.base().faces()[face as usize].map(|v| mesh.positions[v as usize]);
                let p = [0, 1, 2].map(|c| (0..3).map(|k| f64::from(b[k]) * corners[k][c]).sum::<f64>());
                let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
                p.map(|x| (x / length * f64::from(1 << 20)).round() as i32)
            })
            .collect();
        let filters = Filters::new(&hierarchy, Wavelet::Disc(0)).expect("small valences");
        let size = |coding: Coding| {
            let (_, details) =
                Transform { coding, hierarchy: &hierarchy, filters: &filters }.analyse(&finest);
            let last = details.last().expect("six levels");
            last.iter().flatten().map(|x| f64::from(x.abs())).sum::<f64>()
        };
        let (linear, butterfly) = (size(Coding::Own), size(Coding::Butterfly(Wavelet::Disc(0))));
        assert!(3.0 * butterfly < linear, "{butterfly} of {linear}");
    }
}
