//! A sliding window over a strip of a base face's grid, with what lies around it unfolded into it.
//!
//! The grid of level j + 1 falls into four planes, addressed by even vertices `(I, R)`: `E` holds the even vertex at
//! `(2I, 2R)`, and `H`, `V`, `D` the odd ones at `(2I+1, 2R)`, `(2I, 2R+1)` and `(2I+1, 2R+1)`. So the taps of one
//! weight lie at fixed distances, and a run of even vertices reads runs of odd ones.

use super::stencil::{PlacedStencil, Stencil};
use super::update::LARGEST_BLOCK;

/// Steps of level j that a window reaches beyond its strip on every side: the 2-disc stencil reaches 2½, and the
/// parents of what it reads half a step more.
pub(super) const HALO: i32 = 3;

/// Rows a window holds, each in the place of the one so many before it: those that an update reads, and the one being
/// made. A power of two.
const ROWS: usize = 2 * HALO as usize + 2;

/// Even vertices per row of a strip: few enough that a window of 40 kB stays in a first-level cache of 48, enough that the
/// halo does not weigh. On a Xeon 96, 128, 192, 256 took 6.4, 7.0, 6.6, 6.9 ns a vertex for the whole of analysis.
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
#[derive(Debug, Clone, Copy)]
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
}

/// Part of the four planes. Rows are pushed from the top; columns are those of the strip and [`HALO`] to either side.
pub(super) struct Window<const N: usize> {
    /// The first even vertex of the strip.
    first: i32,
    columns: usize,
    evens: Vec<[i32; N]>,
    details: Vec<[i32; N]>,
}

/// One row of the four planes; element 0 of each is column `first − HALO`.
pub(super) struct RowMut<'a, const N: usize> {
    pub(super) e: &'a mut [[i32; N]],
    pub(super) h: &'a mut [[i32; N]],
    pub(super) v: &'a mut [[i32; N]],
    pub(super) d: &'a mut [[i32; N]],
}

impl<const N: usize> Window<N> {
    /// A window for strips of at most `columns` even vertices.
    pub(super) fn new(columns: u32) -> Self {
        let columns = columns as usize + 2 * HALO as usize + 1;
        // Blocks may read past the last column, of the last row past the end.
        let slack = LARGEST_BLOCK.div_ceil(N);
        Self {
            first: 0,
            columns,
            evens: vec![[0; N]; ROWS * columns],
            details: vec![[0; N]; 3 * ROWS * columns + slack],
        }
    }

    /// Begins a strip at an even vertex. What an earlier strip left stays where nothing is read over it, and no regular
    /// vertex reads it.
    pub(super) fn start(&mut self, first: u32) {
        self.first = first as i32;
    }

    #[inline]
    fn row_start(&self, r: i32) -> usize {
        row_place(r) * self.columns
    }

    /// Columns of a row, halo included.
    pub(super) fn row_len(&self) -> usize {
        self.columns
    }

    /// The columns of row `r` of a face with `n` segments that are in use; beyond them nothing is read.
    pub(super) fn used(&self, n: i32, r: i32) -> usize {
        (n - r + 2 * HALO + 1 - self.first).clamp(2, self.columns as i32) as usize
    }

    /// The column of even vertex `I`.
    pub(super) fn column(&self, i: i32) -> usize {
        (i - self.first + HALO) as usize
    }

    /// Row `r` of all planes.
    #[inline]
    pub(super) fn row(&mut self, r: i32) -> RowMut<'_, N> {
        let at = self.row_start(r);
        let (h, rest) = self.details.split_at_mut(ROWS * self.columns);
        let (v, d) = rest.split_at_mut(ROWS * self.columns);
        let one = at..at + self.columns;
        RowMut {
            e: &mut self.evens[one.clone()],
            h: &mut h[one.clone()],
            v: &mut v[one.clone()],
            d: &mut d[one],
        }
    }

    /// The even vertices of rows `r` and `r + 1`, and row `r` of the two planes between them.
    #[inline]
    pub(super) fn between(&mut self, r: i32) -> (&[[i32; N]], &[[i32; N]], RowMut<'_, N>) {
        let (at, below) = (self.row_start(r), self.row_start(r + 1));
        let (h, rest) = self.details.split_at_mut(ROWS * self.columns);
        let (v, d) = rest.split_at_mut(ROWS * self.columns);
        let one = at..at + self.columns;
        let (upper, lower) = (&self.evens[one.clone()], &self.evens[below..below + self.columns]);
        (upper, lower, RowMut { e: &mut [], h: &mut h[one.clone()], v: &mut v[one.clone()], d: &mut d[one] })
    }

    /// All details, and row `r` of even vertices.
    pub(super) fn for_update(&mut self, r: i32) -> (&[i32], &mut [[i32; N]]) {
        let at = self.row_start(r);
        (self.details.as_flattened(), &mut self.evens[at..at + self.columns])
    }

    /// A stencil in the details, by the place of the even vertex's row in the window. Taps are counted from as many columns
    /// as the even vertex has, less the halo.
    pub(super) fn place(&self, stencil: &Stencil) -> [PlacedStencil; ROWS] {
        std::array::from_fn(|own| {
            stencil.placed(|place| {
                let (plane, [i, r]) = place.in_plane();
                let row = plane as usize * ROWS + row_place(own as i32 + r);
                ((row * self.columns) as i32 + i + HALO) as u32 * N as u32
            })
        })
    }
}

/// Where a window keeps a row.
#[inline]
pub(super) fn row_place(r: i32) -> usize {
    r.rem_euclid(ROWS as i32) as usize
}
