//! A sliding window over a strip of a base face's grid, with what lies around it unfolded into it.
//!
//! The grid of level j + 1 falls into four planes, addressed by even vertices `(I, R)`: `E` holds the even vertex at
//! `(2I, 2R)`, and `H`, `V`, `D` the odd ones at `(2I+1, 2R)`, `(2I, 2R+1)` and `(2I+1, 2R+1)`. So the taps of one
//! weight lie at fixed distances, and a run of even vertices reads runs of odd ones.

use super::prefetch::Ahead;
use super::stencil::{PlacedStencil, Stencil};
use super::update::{Direction, LANES, LARGEST_BLOCK, Update};
use pulp::Arch;
use std::ops::Range;

/// Steps of level j that a window reaches beyond its strip on every side: the 2-disc stencil reaches 2½, and the
/// parents of what it reads half a step more.
pub(super) const HALO: i32 = 3;

/// Rows a window holds, each in the place of the one so many before it: those that an update reads, and the one being
/// made. A power of two.
const ROWS: usize = 2 * HALO as usize + 2;

/// Even vertices per row of a strip: few enough that what a step touches of a window, 40 of its 56 kB, stays in a first-level cache of
/// 48, enough that the halo does not weigh. Before rows were folded 96, 128, 192, 256 took 6.4, 7.0, 6.6, 6.9 ns a vertex on a Xeon,
/// for the whole of analysis.
pub(super) const STRIP: u32 = 96;

/// A plane of odd vertices.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Plane {
    /// `(2I+1, 2R)`: on edges along the row.
    H,
    /// `(2I, 2R+1)`: on edges to the next row.
    V,
    /// `(2I+1, 2R+1)`: on the slanted edges between the two rows.
    D,
}

/// An odd vertex relative to an even one: the row at level j + 1, and how many stored odd vertices along it, for of an even row
/// every second is odd.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub(super) row: i32,
    pub(super) along: i32,
}

impl Place {
    /// From steps of level j + 1; the place must be odd.
    pub(super) fn of_odd(dr: i32, di: i32) -> Self {
        Self { row: dr, along: if dr % 2 == 0 { di.div_euclid(2) } else { di } }
    }

    /// `(dr, di)` in steps of level j + 1.
    #[inline(always)]
    pub(super) fn steps(self) -> [i32; 2] {
        [self.row, if self.row % 2 == 0 { 2 * self.along + 1 } else { self.along }]
    }

    /// The plane, and where in it, relative to the even vertex: column and row.
    fn in_plane(self) -> (Plane, [i32; 2]) {
        let [dr, di] = self.steps();
        let plane = match (dr.rem_euclid(2), di.rem_euclid(2)) {
            (0, _) => Plane::H,
            (_, 0) => Plane::V,
            _ => Plane::D,
        };
        (plane, [di.div_euclid(2), dr.div_euclid(2)])
    }

    /// The column of its plane, relative to the even vertex.
    pub(super) fn column(self) -> i32 {
        self.in_plane().1[0]
    }

    /// The place of the same row and plane in the even vertex's own column.
    pub(super) fn in_own_column(self) -> Self {
        let [dr, di] = self.steps();
        Self::of_odd(dr, di.rem_euclid(2))
    }

    /// The mirror image across the even vertex's row.
    pub(super) fn mirrored(self) -> Self {
        let [dr, di] = self.steps();
        Self::of_odd(-dr, di + dr)
    }
}

/// Part of the four planes. Rows are pushed from the top; columns are those of the strip and [`HALO`] to either side.
pub(super) struct Window<const N: usize> {
    /// The first even vertex of the strip.
    first: i32,
    /// Columns that are ever in use.
    columns: usize,
    /// Columns from one row to the next: rows are worked on to the end of a register, and the parents one column on; and each begins
    /// at a line of the cache.
    stride: usize,
    evens: Aligned<N>,
    /// One row of each plane of odd vertices themselves: what details are made of, or what is made of them.
    odds: [Aligned<N>; 3],
    /// The three planes of details, and from [`planes`] on rows of sums of them.
    details: Aligned<N>,
    /// The stencil in the details, by the place of the even vertex's row.
    stencils: [PlacedStencil; ROWS],
}

/// What the planes of details take, with what a folded row may reach beyond the last.
fn planes(stride: usize) -> usize {
    (3 * ROWS + 1) * stride
}

/// One row of the planes; element 0 of each is column `first − HALO`.
pub(super) struct RowMut<'a, const N: usize> {
    /// Even vertices.
    pub(super) e: &'a mut [[i32; N]],
    /// Details, by [`Plane`].
    pub(super) details: [&'a mut [[i32; N]]; 3],
    /// Odd vertices by [`Plane`], those read or made last: the same storage whatever the row.
    pub(super) odds: [&'a mut [[i32; N]]; 3],
}

/// Two rows of even vertices, each one column longer than the other slices, and the odd ones of the first and between them.
pub(super) struct Between<'a, const N: usize> {
    pub(super) upper: &'a [i32],
    pub(super) lower: &'a [i32],
    pub(super) details: [&'a mut [i32]; 3],
    pub(super) odds: [&'a mut [i32]; 3],
}

impl<const N: usize> Window<N> {
    /// A window for strips of at most `columns` even vertices, to be updated by a stencil.
    pub(super) fn new(columns: u32, stencil: &Stencil) -> Self {
        let columns = columns as usize + 2 * HALO as usize + 1;
        let stride = (columns + 1 + LANES.div_ceil(N)).next_multiple_of(LANES);
        // Blocks may read past the last column, of the last row past the end.
        let slack = LARGEST_BLOCK.div_ceil(N);
        // Taps are counted from as many columns as the even vertex has, less the halo.
        let at = |row: usize, i: i32| ((row * stride) as i32 + i + HALO) as u32 * N as u32;
        let stencils = std::array::from_fn(|own| {
            let in_planes = |place: Place| {
                let (plane, [i, r]) = place.in_plane();
                at(plane as usize * ROWS + row_place(own as i32 + r), i)
            };
            stencil.placed(in_planes, |row, i| (planes(stride) * N) as u32 + at(row, i))
        });
        Self {
            first: 0,
            columns,
            stride,
            evens: Aligned::zeroed(ROWS * stride),
            odds: [(); 3].map(|()| Aligned::zeroed(stride)),
            details: Aligned::zeroed(planes(stride) + stencil.folded() * stride + slack),
            stencils,
        }
    }

    /// Begins a strip at an even vertex. What an earlier strip left stays where nothing is read over it, and no regular
    /// vertex reads it.
    pub(super) fn start(&mut self, first: u32) {
        self.first = first as i32;
    }

    #[inline]
    fn row_range(&self, r: i32) -> Range<usize> {
        let start = row_place(r) * self.stride;
        start..start + self.stride
    }

    /// The columns of row `r` of a face with `n` segments that are in use; beyond them nothing is kept.
    pub(super) fn used(&self, n: i32, r: i32) -> usize {
        (n - r + 2 * HALO + 1 - self.first).clamp(2, self.columns as i32) as usize
    }

    /// The values of those columns, and as many more as fill the last register. What stands there is an earlier row's; at worst it
    /// makes details look so large that the level is given to the reference, which is slower and as right.
    pub(super) fn worked(&self, n: i32, r: i32) -> usize {
        (self.used(n, r) * N).next_multiple_of(LANES)
    }

    /// The column of even vertex `I`.
    pub(super) fn column(&self, i: i32) -> usize {
        (i - self.first + HALO) as usize
    }

    /// Row `r` of all planes.
    #[inline]
    pub(super) fn row(&mut self, r: i32) -> RowMut<'_, N> {
        let row = self.row_range(r);
        RowMut {
            details: plane_rows(self.details.values_mut(), ROWS * self.stride, &row),
            e: &mut self.evens.values_mut()[row],
            odds: self.odds.each_mut().map(Aligned::values_mut),
        }
    }

    /// What is predicted of row `r` of the planes, so many values of each.
    #[inline]
    pub(super) fn between(&mut self, r: i32, count: usize) -> Between<'_, N> {
        let (row, below) = (self.row_range(r), self.row_range(r + 1));
        let details = plane_rows(self.details.values_mut(), ROWS * self.stride, &row);
        let [upper, lower] =
            [row, below].map(|row| &self.evens.values().as_flattened()[row.start * N..][..count + N]);
        Between {
            upper,
            lower,
            details: details.map(|row| &mut row.as_flattened_mut()[..count]),
            odds: self.odds.each_mut().map(|row| &mut row.values_mut().as_flattened_mut()[..count]),
        }
    }

    /// Updates a run of even vertices of row `r` by the details around them, and has what is ahead fetched meanwhile.
    pub(super) fn update(
        &mut self,
        arch: Arch,
        direction: Direction,
        r: i32,
        run: Range<i32>,
        ahead: &mut Ahead,
    ) {
        let (column, len) = (self.column(run.start), run.len() * N);
        let at = self.row_range(r).start + column;
        let update = Update {
            stencil: &self.stencils[row_place(r)],
            direction,
            details: self.details.values_mut().as_flattened_mut(),
            planes: planes(self.stride) * N,
            at: (column - HALO as usize) * N,
            reach: HALO as usize * N,
            evens: &mut self.evens.values_mut()[at..].as_flattened_mut()[..len],
        };
        update.run(arch, ahead);
    }
}

/// Values of which the first lies at the beginning of a cache line.
struct Aligned<const N: usize>(Vec<CacheLine>);

/// What a line of the cache holds.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C, align(64))]
struct CacheLine([i32; LANES]);

impl<const N: usize> Aligned<N> {
    /// At least so many values.
    fn zeroed(count: usize) -> Self {
        Self(vec![CacheLine([0; LANES]); (count * N).div_ceil(LANES)])
    }

    #[inline]
    fn values(&self) -> &[[i32; N]] {
        bytemuck::cast_slice::<CacheLine, i32>(&self.0).as_chunks().0
    }

    #[inline]
    fn values_mut(&mut self) -> &mut [[i32; N]] {
        bytemuck::cast_slice_mut::<CacheLine, i32>(&mut self.0).as_chunks_mut().0
    }
}

/// A row of each of three planes.
#[inline]
fn plane_rows<'a, T>(planes: &'a mut [T], len: usize, row: &Range<usize>) -> [&'a mut [T]; 3] {
    let (h, rest) = planes.split_at_mut(len);
    let (v, d) = rest.split_at_mut(len);
    [h, v, d].map(|plane| &mut plane[row.clone()])
}

/// Where a window keeps a row.
#[inline]
fn row_place(r: i32) -> usize {
    r.rem_euclid(ROWS as i32) as usize
}
