//! The grid of one base face at level j + 1 and its neighbours unfolded around it: where each point is stored.

use super::window::HALO;
use crate::hierarchy::{Layout, Site};
use std::ops::Range;

/// A base face and two levels over it.
pub(super) struct Chart<'a> {
    pub(super) face: u32,
    /// Level j.
    pub(super) coarse: &'a Layout,
    /// Level j + 1.
    pub(super) fine: &'a Layout,
    /// By edge of the face: the edge, and whether its low end is the edge's start.
    edges: [(u32, bool); 3],
    /// By edge of the face: the face across it and which of that face's edges it is.
    across: [Option<(u32, u8)>; 3],
    /// By corner of the face: whether the grid goes on around it as the regular lattice does.
    regular: [bool; 3],
}

/// On which edge of the face a point lies, and how far from that edge's low end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OnEdge {
    /// Which of the face's edges.
    pub(super) k: usize,
    /// Segments from its low end.
    pub(super) t: u32,
}

impl<'a> Chart<'a> {
    pub(super) fn new(coarse: &'a Layout, fine: &'a Layout, face: u32) -> Self {
        let base = coarse.base();
        let corners = base.faces()[face as usize];
        let edges = base.face_edges(face);
        Self {
            face,
            coarse,
            fine,
            edges: std::array::from_fn(|k| (edges[k], base.edges()[edges[k] as usize][0] == corners[k])),
            across: std::array::from_fn(|k| base.across(face, k as u8).map(|side| (side.face, side.k))),
            regular: corners.map(|v| base.is_regular(v)),
        }
    }

    /// `n` of level j.
    pub(super) fn n(&self) -> i32 {
        self.coarse.segments() as i32
    }

    /// The columns of row `r` of level j + 1 that any stencil in this face reads.
    pub(super) fn reach(&self, r: i32) -> (i32, i32) {
        let (n, halo) = (2 * self.n(), 2 * HALO);
        ((-halo).max(-halo - r), (n - r + halo).min(n + halo))
    }

    /// Calls back for points of row `r` of the unfolded grid of level j + 1, most of them outside the face, with their
    /// sites; `None` beyond the boundary and around extraordinary corners, over which no stencil reaches.
    #[inline(always)]
    pub(super) fn outside(&self, r: i32, from: i32, to: i32, mut found: impl FnMut(i32, Option<Site>)) {
        // The left and the right side each have a face beside them.
        let middle = ((2 * self.n() - r) / 2).clamp(from - 1, to);
        if r >= 0 {
            self.on_one_side(r, from, middle, &mut found);
        }
        self.on_one_side(r, if r >= 0 { middle + 1 } else { from }, to, &mut found);
    }

    /// [`Chart::outside`] for points that do not lie on both sides of the face.
    fn on_one_side(&self, r: i32, from: i32, to: i32, found: &mut impl FnMut(i32, Option<Site>)) {
        let n = 2 * self.n();
        // Points inside a face that shares an edge with this one are nearly all.
        let (k, beside) = match r {
            ..0 => (0, 1 - r..n),
            _ if from < 0 => (2, (1 - r).min(0)..0),
            _ => (1, n - r + 1..n),
        };
        let (first, last) = (beside.start.clamp(from, to + 1), beside.end.clamp(from, to + 1));
        let between = if r >= n { from..from } else { first..last.max(first) };
        self.beside(k, r, between.clone(), found);
        for i in (from..between.start).chain(between.end..to + 1) {
            found(i, self.elsewhere(i, r));
        }
    }

    /// The points of a row that lie inside the face across edge `k`.
    #[inline(always)]
    fn beside(&self, k: usize, r: i32, points: Range<i32>, found: &mut impl FnMut(i32, Option<Site>)) {
        let n = 2 * self.n();
        // As the neighbour sees a point: `h` from the edge, along it `p` and `q` from its two ends.
        let seen = |i: i32| {
            let (p, q, h) = match k {
                0 => (n - i, i + r, -r),
                1 => (n - r, n - i, i + r - n),
                _ => (r + i, n - r, -i),
            };
            self.across[k].map(|(_, own)| [[p, h], [q, p], [h, q]][usize::from(own)])
        };
        let (Some(start), Some(next)) = (seen(points.start), seen(points.start + 1)) else {
            points.for_each(|i| found(i, None));
            return;
        };
        let face = self.across[k].expect("seen from there").0;
        let [mut along, mut row] = start;
        for i in points {
            found(i, Some(Site::Face { face, i: along as u32, r: row as u32 }));
            along += next[0] - start[0];
            row += next[1] - start[1];
        }
    }

    /// The site of a point that is not beside the face.
    #[cold]
    fn elsewhere(&self, i: i32, r: i32) -> Option<Site> {
        let b = [2 * self.n() - i - r, i, r];
        if let Some(OnEdge { k, t }) = self.on_edge(2 * self.n(), i, r) {
            return Some(Site::Edge { edge: self.edges[k].0, t });
        }
        let corner = if b[0] >= b[1] && b[0] >= b[2] { 0 } else { 1 + usize::from(b[2] > b[1]) };
        let beyond = b.iter().any(|&x| x < 0);
        if beyond && !self.regular[corner] { None } else { self.fine.resolve(self.face, b) }
    }

    /// Where a point of a grid with `n` segments lies on the face's border, corners left out.
    #[inline]
    pub(super) fn on_edge(&self, n: i32, i: i32, r: i32) -> Option<OnEdge> {
        let b0 = n - i - r;
        let (k, along) = match (b0 == 0, i == 0, r == 0) {
            (false, false, true) => (0, i),
            (true, false, false) => (1, r),
            (false, true, false) => (2, b0),
            _ => return None,
        };
        if !(0..n).contains(&along) {
            return None;
        }
        let t = if self.edges[k].1 { along } else { n - along };
        Some(OnEdge { k, t: t as u32 })
    }

    /// The vertex of level j at `(I, R)` of the face's own grid.
    pub(super) fn even(&self, i: u32, r: u32) -> Site {
        self.coarse.site_at(self.face, [self.coarse.segments() - i - r, i, r])
    }
}
