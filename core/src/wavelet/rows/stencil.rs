//! The constant stencil, its taps ordered by weight.

use super::window::Place;
use crate::hierarchy::Layout;
use std::collections::BTreeMap;

/// How far the largest stencil reaches, in steps of level j + 1.
const REACH: usize = 5;

/// So many taps of a row make folding pay: it costs reading the row and its mirror image and writing their sum, and saves one
/// reading a tap.
const WORTH_FOLDING: usize = 4;

/// The taps of the constant stencil by weight, in groups of six and twelve: the orbits of the lattice's symmetries.
#[derive(Debug)]
pub struct Stencil {
    sixes: Vec<(i32, [Place; 6])>,
    twelves: Vec<(i32, [Place; 12])>,
    /// Rows that row kernels fold, in the even vertex's own column.
    folded: Vec<Place>,
    /// Weights, with how many of `taps` each has.
    classes: Vec<(i32, usize)>,
    /// What row kernels read, by weight.
    taps: Vec<Tap>,
}

/// What a row kernel reads.
#[derive(Debug, Clone, Copy)]
enum Tap {
    /// A row of odd vertices.
    Single(Place),
    /// The sum of a row and its mirror image, by its number, from a column on.
    Folded(usize, i32),
}

impl Stencil {
    /// From taps `(dr, di, weight)` in steps of level j + 1, relative to the even vertex.
    pub(crate) fn new(taps: impl Iterator<Item = (i32, i32, i32)>) -> Self {
        let mut orbits: BTreeMap<i32, Vec<Place>> = BTreeMap::new();
        for (dr, di, weight) in taps {
            orbits.entry(weight).or_default().push(Place::of_odd(dr, di));
        }
        let (mut sixes, mut twelves) = (Vec::new(), Vec::new());
        for (weight, places) in orbits {
            let (pairs, rest) = places.as_chunks::<12>();
            twelves.extend(pairs.iter().map(|&group| (weight, group)));
            let (single, none) = rest.as_chunks::<6>();
            sixes.extend(single.iter().map(|&group| (weight, group)));
            assert!(none.is_empty(), "orbits have six or twelve members");
        }
        let by_weight = sixes.iter().map(|(weight, taps)| (*weight, taps.as_slice()));
        let by_weight = by_weight.chain(twelves.iter().map(|(weight, taps)| (*weight, taps.as_slice())));
        let by_weight: Vec<(i32, &[Place])> = by_weight.collect();
        let folded = worth_folding(by_weight.iter().flat_map(|(_, taps)| *taps).copied());
        let number = |place: Place| folded.iter().position(|&row| row == place.in_own_column());
        let (mut classes, mut taps) = (Vec::new(), Vec::new());
        for (weight, places) in by_weight {
            assert!(
                places.iter().all(|place| places.contains(&place.mirrored())),
                "orbits are their own mirror images"
            );
            let before = taps.len();
            taps.extend(places.iter().filter_map(|&place| match number(place) {
                Some(row) => Some(Tap::Folded(row, place.column())),
                None => number(place.mirrored()).is_none().then_some(Tap::Single(place)),
            }));
            classes.push((weight, taps.len() - before));
        }
        Self { sixes, twelves, folded, classes, taps }
    }

    /// `Σ_i w_iv d_i` for the even vertex at column `i` of row `r`, deep inside a base face. Classes add in 32 bits.
    pub(crate) fn sum_inside<const N: usize>(
        &self,
        layout: &Layout,
        face: u32,
        [i, r]: [u32; 2],
        d: &[[i32; N]],
    ) -> [i64; N] {
        let rows = rows_inside(layout, face, [i, r]);
        self.sum(d, |tap| rows[(tap.row + REACH as i32) as usize].wrapping_add_signed(tap.along))
    }

    /// [`Stencil::sum_inside`] for any even vertex around which the grid goes on as the regular lattice does.
    pub(crate) fn sum_across<const N: usize>(
        &self,
        layout: &Layout,
        face: u32,
        [i, r]: [u32; 2],
        d: &[[i32; N]],
    ) -> [i64; N] {
        let rows = rows_inside(layout, face, [i, r]);
        let n = 2 * layout.segments() as i32;
        self.sum(d, |tap| {
            let [dr, di] = tap.steps();
            let (i, r) = (2 * i as i32 + di, 2 * r as i32 + dr);
            if i > 0 && r > 0 && i + r < n {
                return rows[(tap.row + REACH as i32) as usize].wrapping_add_signed(tap.along);
            }
            let odd = layout.resolve_odd(face, [n - i - r, i, r]);
            odd.expect("a regular vertex's stencil stays on the surface").0
        })
    }

    /// `Σ w d` over taps that are found somehow.
    #[inline(always)]
    fn sum<const N: usize>(&self, d: &[[i32; N]], odd: impl Fn(Place) -> u32) -> [i64; N] {
        if N == 3 {
            // Three channels are read four values at a time, as one register.
            let total = self.sum_of_fours(d.as_flattened(), odd);
            return std::array::from_fn(|c| total[c]);
        }
        let mut total = [0i64; N];
        for (weight, taps) in &self.sixes {
            add_class(&mut total, *weight, taps, |tap| d[odd(tap) as usize]);
        }
        for (weight, taps) in &self.twelves {
            add_class(&mut total, *weight, taps, |tap| d[odd(tap) as usize]);
        }
        total
    }

    #[inline(always)]
    fn sum_of_fours(&self, d: &[i32], odd: impl Fn(Place) -> u32) -> [i64; 4] {
        let four = |tap| {
            let at = 3 * odd(tap) as usize;
            match d.get(at..at + 4) {
                Some(values) => values.try_into().expect("of that length"),
                None => [d[at], d[at + 1], d[at + 2], 0],
            }
        };
        let mut total = [0i64; 4];
        for (weight, taps) in &self.sixes {
            add_class(&mut total, *weight, taps, four);
        }
        for (weight, taps) in &self.twelves {
            add_class(&mut total, *weight, taps, four);
        }
        total
    }

    /// The taps as distances within an array, from the place of the even vertex in it; so are the folded rows', by their number
    /// and the column.
    pub(super) fn placed(
        &self,
        offset: impl Fn(Place) -> u32,
        folded_offset: impl Fn(usize, i32) -> u32,
    ) -> PlacedStencil {
        let tap = |tap: &Tap| match *tap {
            Tap::Single(place) => offset(place),
            Tap::Folded(row, column) => folded_offset(row, column),
        };
        let folds = self.folded.iter().enumerate().map(|(number, place)| Fold {
            rows: [*place, place.mirrored()].map(&offset),
            to: folded_offset(number, 0),
        });
        PlacedStencil {
            folds: folds.collect(),
            classes: self.classes.clone(),
            taps: self.taps.iter().map(tap).collect(),
        }
    }

    /// How many rows are folded.
    pub(super) fn folded(&self) -> usize {
        self.folded.len()
    }
}

/// Rows of odd vertices below the even vertices' that have so many taps that folding them pays, in the even vertex's own column.
fn worth_folding(taps: impl Iterator<Item = Place>) -> Vec<Place> {
    let mut counts: BTreeMap<(i32, i32), usize> = BTreeMap::new();
    for place in taps.filter(|place| place.row > 0) {
        let first = place.in_own_column();
        *counts.entry((first.row, first.along)).or_default() += 1;
    }
    let worth = counts.into_iter().filter(|&(_, count)| count >= WORTH_FOLDING);
    worth.map(|((row, along), _)| Place { row, along }).collect()
}

/// Where the taps of each row are counted from, for an even vertex of a face: of an odd row all vertices are odd ones, of an
/// even every second. Of no use for taps outside the face.
fn rows_inside(layout: &Layout, face: u32, [i, r]: [u32; 2]) -> [u32; 2 * REACH + 1] {
    let start = layout.odd_face_start(face);
    let mut rows = [0; 2 * REACH + 1];
    for (dr, row) in (0..).zip(&mut rows) {
        let r = (2 * r + dr).wrapping_sub(REACH as u32);
        if r.wrapping_sub(1) < 2 * layout.segments() {
            let first = if r % 2 == 1 { 2 * i } else { i + 1 };
            *row = (start + layout.odd_row_start(r) + first).wrapping_sub(1);
        }
    }
    rows
}

#[inline(always)]
fn add_class<const N: usize>(
    total: &mut [i64; N],
    weight: i32,
    taps: &[Place],
    detail: impl Fn(Place) -> [i32; N],
) {
    let mut sum = [0i32; N];
    for &tap in taps {
        let d = detail(tap);
        for c in 0..N {
            sum[c] = sum[c].wrapping_add(d[c]);
        }
    }
    for c in 0..N {
        total[c] += i64::from(sum[c]) * i64::from(weight);
    }
}

/// A [`Stencil`] addressed within one array of details and of sums of them.
#[derive(Debug)]
pub(super) struct PlacedStencil {
    /// The sums that are made first.
    pub(super) folds: Vec<Fold>,
    /// Weights, and how many taps each has.
    pub(super) classes: Vec<(i32, usize)>,
    pub(super) taps: Vec<u32>,
}

/// The sum of two rows of odd vertices, one the other's mirror image: taps at both have one weight.
#[derive(Debug)]
pub(super) struct Fold {
    pub(super) rows: [u32; 2],
    pub(super) to: u32,
}

#[cfg(test)]
mod tests {
    use crate::hierarchy::{BaseMesh, Hierarchy, Level};
    use crate::mesh::shapes;
    use crate::wavelet::{Filters, Wavelet};
    use std::sync::Arc;

    /// A 2-disc stencil has 72 taps; six rows of four or five taps on either side of the even vertices' are folded.
    #[test]
    fn rows_of_many_taps_are_folded() {
        let base = BaseMesh::new(6, shapes::octahedron().faces, &[]).expect("a base mesh");
        let meshes = Hierarchy::new(Arc::new(base), Level(3)).expect("small");
        let counts = |wavelet| {
            let filters = Filters::new(&meshes, wavelet).expect("small valences");
            let stencil = filters.stencil();
            (stencil.folded(), stencil.taps.len())
        };
        assert_eq!(counts(Wavelet::Disc(2)), (6, 72 - 27));
        assert_eq!(counts(Wavelet::Disc(1)), (0, 30));
        assert_eq!(counts(Wavelet::Disc(0)), (0, 6));
    }
}
