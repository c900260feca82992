//! The grid of one base face at level j + 1 and its neighbours unfolded around it: where each point is stored.

use super::window::HALO;
use crate::hierarchy::{EdgeSide, Layout, Site};

/// A base face and two levels over it.
pub(super) struct Chart<'a> {
    pub(super) face: u32,
    /// Level j.
    pub(super) coarse: &'a Layout,
    /// Level j + 1.
    pub(super) fine: &'a Layout,
    /// By edge of the face: the edge, and whether its low end is the edge's start.
    pub(super) edges: [(u32, bool); 3],
    /// By edge of the face: the face across it.
    pub(super) across: [Option<EdgeSide>; 3],
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
            across: [0, 1, 2].map(|k| base.across(face, k)),
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
