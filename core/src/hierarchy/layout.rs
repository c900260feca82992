//! Where the vertices of `M^j` are stored, by arithmetic alone.
//!
//! Every base face carries a triangular grid of `n = 2^j` segments a side. A point of it has barycentric
//! coordinates `[b0, b1, b2]`, non-negative integers with sum `n`. Vertices on base edges and base vertices are
//! stored once. Level j's storage is three blocks:
//!
//! * base vertices, in the base mesh's order;
//! * edge interiors, `n − 1` per base edge, from its low end;
//! * face interiors, `(n−1)(n−2)/2` per base face, by row `r = b2` (rows are parallel to the face's first edge,
//!   corner 0 → corner 1) and along it by `i = b1`.
//!
//! The odd vertices of level j (new in `M^{j+1}`) are stored in public order, the same two kinds of blocks
//! without the vertices that level j already has.

use super::{BaseMesh, Level, Odd, PublicId, Slot};
use std::sync::Arc;

/// The most vertices that a surface may have, finest level: 2^26, about 2 GB in memory.
pub const MOST_VERTICES: u32 = 1 << 26;

/// The finest level the numbering allows; counts stay within `u32` by [`Layout::checked`].
pub const FINEST_LEVEL: u8 = 15;

/// A vertex of some level by where it lies on the base mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Site {
    /// A base vertex.
    Base(u32),
    /// Inside a base edge, `t` of `n` segments from its low end, `0 < t < n`.
    Edge {
        /// The base edge.
        edge: u32,
        /// Position along it.
        t: u32,
    },
    /// Inside a base face: `b1 = i`, `b2 = r`, `b0 = n − i − r`, all positive.
    Face {
        /// The base face.
        face: u32,
        /// Position along the row.
        i: u32,
        /// The row.
        r: u32,
    },
}

/// The arithmetic of one level over one base mesh. Cheap to copy around; operations are `O(1)`, or `O(j)` where said.
#[derive(Debug, Clone)]
pub struct Layout {
    base: Arc<BaseMesh>,
    level: Level,
    n: u32,
    edges_at: u32,
    faces_at: u32,
    per_face: u32,
    len: u32,
}

impl Layout {
    /// The layout of a level, or `None` if `M^{level}` would have more than `2^31` vertices.
    pub fn checked(base: &Arc<BaseMesh>, level: Level) -> Option<Self> {
        if level.0 > FINEST_LEVEL {
            return None;
        }
        let n = u64::from(level.segments());
        let (v, e, f) =
            (u64::from(base.vertex_count()), base.edges().len() as u64, base.faces().len() as u64);
        let per_face = (n - 1) * n.saturating_sub(2) / 2;
        let len = v + e * (n - 1) + f * per_face;
        (len < 1 << 31).then(|| Self {
            base: base.clone(),
            level,
            n: n as u32,
            edges_at: v as u32,
            faces_at: (v + e * (n - 1)) as u32,
            per_face: per_face as u32,
            len: len as u32,
        })
    }

    /// The base mesh.
    #[inline]
    pub fn base(&self) -> &Arc<BaseMesh> {
        &self.base
    }

    /// The level j.
    #[inline]
    pub fn level(&self) -> Level {
        self.level
    }

    /// `n = 2^j`.
    #[inline]
    pub fn segments(&self) -> u32 {
        self.n
    }

    /// The number of vertices `n_j` of `M^j`.
    #[inline]
    pub fn len(&self) -> u32 {
        self.len
    }

    /// Never: a base mesh has vertices.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The number of odd vertices of this level: `n_{j+1} − n_j`.
    pub fn odd_len(&self) -> u32 {
        let n = self.n;
        self.base.edges().len() as u32 * n + self.base.faces().len() as u32 * (3 * n * (n - 1) / 2)
    }

    /// The slot of a site.
    #[inline]
    pub fn slot(&self, site: Site) -> Slot {
        Slot(match site {
            Site::Base(v) => v,
            Site::Edge { edge, t } => self.edges_at + edge * (self.n - 1) + t - 1,
            Site::Face { face, i, r } => self.faces_at + face * self.per_face + self.row_start(r) + i - 1,
        })
    }

    /// The site of a slot. Bisects the rows for face interiors.
    pub fn site(&self, slot: Slot) -> Site {
        let s = slot.0;
        if s < self.edges_at {
            return Site::Base(s);
        }
        if s < self.faces_at {
            let s = s - self.edges_at;
            return Site::Edge { edge: s / (self.n - 1), t: s % (self.n - 1) + 1 };
        }
        let s = s - self.faces_at;
        let (face, within) = (s / self.per_face, s % self.per_face);
        let r = row_containing(within, self.n - 2, |r| self.row_start(r));
        Site::Face { face, i: within - self.row_start(r) + 1, r }
    }

    /// Slots of row `r` of a face before it: rows 1 to r − 1 hold `n − s − 1` each.
    #[inline]
    fn row_start(&self, r: u32) -> u32 {
        (r - 1) * (self.n - 1) - r * (r - 1) / 2
    }

    /// The first slot of row `r` (from 1 to `n − 2`) of a face's interior; the row holds `n − r − 1` slots, `i`
    /// from 1.
    #[inline]
    pub fn row(&self, face: u32, r: u32) -> Slot {
        Slot(self.faces_at + face * self.per_face + self.row_start(r))
    }

    /// The site of a point given by non-negative barycentric coordinates with sum `n` in a face.
    #[inline]
    pub fn site_at(&self, face: u32, b: [u32; 3]) -> Site {
        site_in(&self.base, self.n, face, b)
    }

    fn corner(&self, face: u32, k: u8) -> u32 {
        self.base.faces()[face as usize][usize::from(k)]
    }

    /// A face that contains the site, and the site's barycentric coordinates in it. For a base vertex the first
    /// face of its fan, for an edge its first side.
    pub fn chart(&self, site: Site) -> (u32, [u32; 3]) {
        let mut b = [0; 3];
        match site {
            Site::Base(v) => {
                let (face, corner) = self.base.fan(v).corners[0];
                b[usize::from(corner)] = self.n;
                (face, b)
            }
            Site::Edge { edge, t } => {
                let side = self.base.sides(edge)[0].expect("an edge has a face");
                (side.face, self.on_side(edge, side.face, side.k, t))
            }
            Site::Face { face, i, r } => (face, [self.n - i - r, i, r]),
        }
    }

    /// Barycentric coordinates, in the face at side `k` of an edge, of the point `t` segments from its low end.
    pub fn on_side(&self, edge: u32, face: u32, k: u8, t: u32) -> [u32; 3] {
        let from_low = self.base.edges()[edge as usize][0] == self.corner(face, k);
        let along = if from_low { t } else { self.n - t };
        let k = usize::from(k);
        let mut b = [0; 3];
        b[k] = self.n - along;
        b[(k + 1) % 3] = along;
        b
    }

    /// A point, in units of any level, given in the frame of one face, in the frame of the face that holds it: each negative
    /// coordinate unfolds the face across that edge. Unambiguous wherever the faces passed over lie flat like the regular
    /// lattice. `None` beyond the boundary. Cost: one step per edge crossed.
    fn unfold(&self, face: u32, b: [i32; 3]) -> Option<(u32, [u32; 3])> {
        let (mut face, mut b) = (face, b);
        while let Some(c) = b.iter().position(|&x| x < 0) {
            // Edge k is opposite corner c; P = corner k, Q = corner k + 1 of this face.
            let k = (c + 1) % 3;
            let side = self.base.across(face, k as u8)?;
            let (p, q) = (b[k] + b[c], b[(k + 1) % 3] + b[c]);
            // The neighbour runs along the edge the other way: its corner k' is Q.
            let k2 = usize::from(side.k);
            let mut across = [0; 3];
            across[k2] = q;
            across[(k2 + 1) % 3] = p;
            across[(k2 + 2) % 3] = -b[c];
            face = side.face;
            b = across;
        }
        Some((face, b.map(|x| x as u32)))
    }

    /// The odd vertex at barycentric coordinates of level j + 1 (sum `2n`), which may be negative: each that is unfolds the face
    /// across that edge. `None` beyond the boundary.
    #[inline]
    pub fn resolve_odd(&self, face: u32, b: [i32; 3]) -> Option<Odd> {
        // Nearly all are asked for inside the face or one that shares an edge with it.
        let site = match self.within_or_beside(face, b) {
            Some(site) => site,
            None => {
                let (face, b) = self.unfold(face, b)?;
                site_in(&self.base, 2 * self.n, face, b)
            }
        };
        Some(self.odd_at(site))
    }

    /// The site of barycentric coordinates of any level inside a face, inside one of its edges or inside a face across one.
    #[inline(always)]
    pub(crate) fn within_or_beside(&self, face: u32, b: [i32; 3]) -> Option<Site> {
        let [b0, i, r] = b;
        // Seen from across an edge: `h` from it, along it `p` and `q` from its ends.
        let (k, p, q, h) = match (b0 > 0, i > 0, r > 0) {
            (true, true, true) => return Some(Site::Face { face, i: i as u32, r: r as u32 }),
            (true, true, false) => (0, b0 + r, i + r, -r),
            (false, true, true) => (1, i + b0, r + b0, -b0),
            (true, false, true) => (2, r + i, b0 + i, -i),
            _ => return None,
        };
        if p <= 0 || q <= 0 {
            return None;
        }
        if h == 0 {
            let edge = self.base.face_edges(face)[usize::from(k)];
            let from_low = self.base.edges()[edge as usize][0] == self.corner(face, k);
            return Some(Site::Edge { edge, t: if from_low { q } else { p } as u32 });
        }
        let side = self.base.across(face, k)?;
        let (i, r) = match side.k {
            0 => (p, h),
            1 => (q, p),
            _ => (h, q),
        };
        Some(Site::Face { face: side.face, i: i as u32, r: r as u32 })
    }

    // ---- odd vertices -------------------------------------------------------------------------------------

    /// The site, at level j + 1, of an odd vertex of this level.
    pub fn odd_site(&self, odd: Odd) -> Site {
        let n = self.n;
        let on_edges = self.base.edges().len() as u32 * n;
        if odd.0 < on_edges {
            return Site::Edge { edge: odd.0 / n, t: 2 * (odd.0 % n) + 1 };
        }
        let per_face = 3 * n * (n - 1) / 2;
        let (face, within) = ((odd.0 - on_edges) / per_face, (odd.0 - on_edges) % per_face);
        let r = row_containing(within, 2 * n - 2, |r| self.odd_row_start(r));
        let along = within - self.odd_row_start(r);
        Site::Face { face, i: if r % 2 == 1 { along + 1 } else { 2 * along + 1 }, r }
    }

    /// The odd vertex of this level at a site of level j + 1; the site must be odd.
    #[inline]
    pub fn odd_at(&self, site: Site) -> Odd {
        let n = self.n;
        Odd(match site {
            Site::Base(_) => unreachable!("base vertices are even at every level"),
            Site::Edge { edge, t } => edge * n + (t - 1) / 2,
            Site::Face { face, i, r } => {
                let along = if r % 2 == 1 { i - 1 } else { (i - 1) / 2 };
                self.odd_face_start(face) + self.odd_row_start(r) + along
            }
        })
    }

    /// The first odd vertex inside a face.
    #[inline]
    pub fn odd_face_start(&self, face: u32) -> u32 {
        self.base.edges().len() as u32 * self.n + face * (3 * self.n * (self.n - 1) / 2)
    }

    /// Odd vertices in rows 1 to r − 1 of a face's grid at level j + 1: all of an odd row, every second of an even.
    #[inline]
    pub fn odd_row_start(&self, r: u32) -> u32 {
        let (m, fine) = (r - 1, 2 * self.n);
        let (odd_rows, even_rows) = (m.div_ceil(2), m / 2);
        odd_rows * (fine - 1) - odd_rows * odd_rows + (even_rows * fine - even_rows * (even_rows + 1)) / 2
    }

    /// The ends, as sites of this level, of the edge that an odd vertex (a site of level j + 1) halves.
    pub fn parents(&self, odd: Site) -> [Site; 2] {
        match odd {
            Site::Base(_) => unreachable!("base vertices are even at every level"),
            Site::Edge { edge, t } => {
                [self.along_edge(edge, (t - 1) / 2), self.along_edge(edge, t.div_ceil(2))]
            }
            Site::Face { face, i, r } => {
                let at = |i: u32, r: u32| {
                    let (i, r) = (i / 2, r / 2);
                    self.site_at(face, [self.n - i - r, i, r])
                };
                // Two of the three coordinates are odd; the edge runs between them.
                match (i % 2, r % 2) {
                    (1, 0) => [at(i - 1, r), at(i + 1, r)],
                    (0, 1) => [at(i, r - 1), at(i, r + 1)],
                    _ => [at(i + 1, r - 1), at(i - 1, r + 1)],
                }
            }
        }
    }

    /// The point `t` of `0..=n` along a base edge, ends included.
    pub fn along_edge(&self, edge: u32, t: u32) -> Site {
        let ends = self.base.edges()[edge as usize];
        match t {
            0 => Site::Base(ends[0]),
            t if t == self.n => Site::Base(ends[1]),
            t => Site::Edge { edge, t },
        }
    }

    /// The edges of this level that a base edge consists of, from its low end on.
    pub fn edges_along(&self, edge: u32) -> impl Iterator<Item = [Slot; 2]> + '_ {
        (0..self.n).map(move |t| [t, t + 1].map(|t| self.slot(self.along_edge(edge, t))))
    }

    /// The edges of this level that lie on sharp edges of the base mesh.
    pub fn sharp_edges(&self) -> impl Iterator<Item = [Slot; 2]> + '_ {
        let sharp = (0..self.base.edges().len() as u32).filter(|&edge| self.base.is_sharp(edge));
        sharp.flat_map(|edge| self.edges_along(edge))
    }

    /// The same vertex seen from one level finer.
    #[inline]
    pub fn refine(site: Site) -> Site {
        match site {
            Site::Base(v) => Site::Base(v),
            Site::Edge { edge, t } => Site::Edge { edge, t: 2 * t },
            Site::Face { face, i, r } => Site::Face { face, i: 2 * i, r: 2 * r },
        }
    }

    /// The site one level coarser, if the vertex exists there.
    #[inline]
    pub fn coarsen(site: Site) -> Option<Site> {
        Some(match site {
            Site::Base(v) => Site::Base(v),
            Site::Edge { edge, t } if t % 2 == 0 => Site::Edge { edge, t: t / 2 },
            Site::Face { face, i, r } if i % 2 == 0 && r % 2 == 0 => Site::Face { face, i: i / 2, r: r / 2 },
            _ => return None,
        })
    }

    /// `n_j` of any level over the same base mesh, needed by the numbering.
    fn count_at(&self, level: u8) -> u32 {
        let n = 1u32 << level;
        let interior = (n - 1) * n.saturating_sub(2) / 2;
        self.base.vertex_count()
            + self.base.edges().len() as u32 * (n - 1)
            + self.base.faces().len() as u32 * interior
    }

    /// The public id of a site of this level.
    pub fn public_id(&self, site: Site) -> PublicId {
        let (mut site, mut level) = (site, self.level.0);
        while level > 0 {
            match Self::coarsen(site) {
                Some(coarser) => site = coarser,
                None => {
                    let owner = self.at_level(level - 1);
                    return PublicId(self.count_at(level - 1) + owner.odd_at(site).0);
                }
            }
            level -= 1;
        }
        let Site::Base(v) = site else { unreachable!("level 0 has base vertices only") };
        PublicId(v)
    }

    /// The site, at this level, of a public id below [`Layout::len`].
    pub fn site_of(&self, id: PublicId) -> Site {
        if id.0 < self.base.vertex_count() {
            return Site::Base(id.0);
        }
        let owner = (0..self.level.0).rev().find(|&l| id.0 >= self.count_at(l)).expect("level 0 begins at 0");
        let mut site = self.at_level(owner).odd_site(Odd(id.0 - self.count_at(owner)));
        for _ in owner + 1..self.level.0 {
            site = Self::refine(site);
        }
        site
    }

    /// The layout of a coarser level over the same base mesh.
    fn at_level(&self, level: u8) -> Layout {
        Layout::checked(&self.base, Level(level)).expect("a coarser level is smaller")
    }
}

/// The site, at the level with `n` segments, of barycentric coordinates with sum `n`.
#[inline]
pub(super) fn site_in(base: &BaseMesh, n: u32, face: u32, b: [u32; 3]) -> Site {
    debug_assert_eq!(b[0] + b[1] + b[2], n);
    let corner = |k: usize| base.faces()[face as usize][k];
    let on_edge = |k: usize, along: u32| {
        let edge = base.face_edges(face)[k];
        let from_low = base.edges()[edge as usize][0] == corner(k);
        Site::Edge { edge, t: if from_low { along } else { n - along } }
    };
    match (b[0] == 0, b[1] == 0, b[2] == 0) {
        (false, false, false) => Site::Face { face, i: b[1], r: b[2] },
        (true, true, _) => Site::Base(corner(2)),
        (true, _, true) => Site::Base(corner(1)),
        (_, true, true) => Site::Base(corner(0)),
        (_, _, true) => on_edge(0, b[1]),
        (true, _, _) => on_edge(1, b[2]),
        (_, true, _) => on_edge(2, b[0]),
    }
}

/// The row `r` in `1..=last` with `start(r) ≤ within < start(r + 1)`, by bisection.
fn row_containing(within: u32, last: u32, start: impl Fn(u32) -> u32) -> u32 {
    let (mut low, mut high) = (1, last);
    while low < high {
        let middle = (low + high).div_ceil(2);
        if start(middle) <= within {
            low = middle;
        } else {
            high = middle - 1;
        }
    }
    low
}
