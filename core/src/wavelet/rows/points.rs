//! What a level stores at the points of the grid of level j + 1, line by line.

use crate::hierarchy::{Layout, Site};

/// Values at points of level j + 1: of all of them, or of the odd ones alone with zeros between.
#[derive(Clone, Copy)]
pub(super) struct Points<'a, const N: usize> {
    coarse: &'a Layout,
    fine: &'a Layout,
    values: &'a [[i32; N]],
    odd_only: bool,
}

/// Values along a line: a base edge from its low end, or a row of a face, counted from 1.
#[derive(Clone, Copy)]
pub(super) struct Line<'a, const N: usize> {
    values: &'a [[i32; N]],
    /// Whether only every second is stored, the first included; the others are zero.
    halved: bool,
}

impl<'a, const N: usize> Line<'a, N> {
    /// What is stored of the first places, at most so many.
    pub(super) fn first(&self, count: usize) -> &'a [[i32; N]] {
        &self.values[..count.min(self.values.len())]
    }

    /// What is stored of the last places, at most so many.
    pub(super) fn last(&self, count: usize) -> &'a [[i32; N]] {
        &self.values[self.values.len().saturating_sub(count)..]
    }

    /// The value at a place.
    #[inline(always)]
    pub(super) fn at(&self, place: i32) -> [i32; N] {
        let before = place as usize - 1;
        match self.halved {
            false => self.values[before],
            true if before.is_multiple_of(2) => self.values[before / 2],
            true => [0; N],
        }
    }
}

impl<'a, const N: usize> Points<'a, N> {
    /// `c^{j+1}`.
    pub(super) fn all(coarse: &'a Layout, fine: &'a Layout, finer: &'a [[i32; N]]) -> Self {
        Self { coarse, fine, values: finer, odd_only: false }
    }

    /// `d^j`.
    pub(super) fn odd(coarse: &'a Layout, fine: &'a Layout, details: &'a [[i32; N]]) -> Self {
        Self { coarse, fine, values: details, odd_only: true }
    }

    /// The inside of a base edge.
    pub(super) fn edge(&self, edge: u32) -> Line<'a, N> {
        let n = self.fine.segments() as usize;
        let (first, len) = if self.odd_only {
            (edge as usize * (n / 2), n / 2)
        } else {
            (self.fine.slot(Site::Edge { edge, t: 1 }).index(), n - 1)
        };
        Line { values: &self.values[first..first + len], halved: self.odd_only }
    }

    /// The inside of row `r ≥ 1` of a face, which holds `n − r − 1` points.
    #[inline]
    pub(super) fn row(&self, face: u32, r: u32) -> Line<'a, N> {
        let len = (self.fine.segments() - r - 1) as usize;
        let halved = self.odd_only && r.is_multiple_of(2);
        let (first, len) = if self.odd_only {
            let first = self.coarse.odd_face_start(face) + self.coarse.odd_row_start(r);
            (first as usize, if halved { len.div_ceil(2) } else { len })
        } else {
            (self.fine.row(face, r).index(), len)
        };
        Line { values: &self.values[first..first + len], halved }
    }

    /// The value at a site of level j + 1.
    pub(super) fn value(&self, site: Site) -> [i32; N] {
        let even = match site {
            Site::Base(_) => true,
            Site::Edge { t, .. } => t.is_multiple_of(2),
            Site::Face { i, r, .. } => i.is_multiple_of(2) && r.is_multiple_of(2),
        };
        match self.odd_only {
            false => self.values[self.fine.slot(site).index()],
            true if even => [0; N],
            true => self.values[self.coarse.odd_at(site).index()],
        }
    }
}
