//! One-rings and k-discs of `M^j` by arithmetic: no stored connectivity.

use super::layout::site_in;
use super::{Layout, Site, Slot};
use rustc_hash::FxHashSet;

/// The six directions of the lattice, counter-clockwise, in barycentric steps.
pub const DIRECTIONS: [[i32; 3]; 6] =
    [[-1, 1, 0], [-1, 0, 1], [0, -1, 1], [1, -1, 0], [1, 0, -1], [0, 1, -1]];

/// The neighbours of a vertex, counter-clockwise. Of an open ring (a boundary vertex) the first and the last are
/// its boundary neighbours.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ring<V> {
    /// The neighbours.
    pub around: Vec<V>,
    /// Whether the last and the first are neighbours too.
    pub closed: bool,
}

impl<V> Ring<V> {
    /// The number of faces around the vertex.
    pub fn faces(&self) -> usize {
        if self.closed { self.around.len() } else { self.around.len() - 1 }
    }
}

impl Layout {
    /// The one-ring of a vertex. Cost: its valence.
    pub fn ring(&self, site: Site) -> Ring<Site> {
        match site {
            Site::Face { face, i, r } => {
                let b = [self.segments() - i - r, i, r];
                let around = DIRECTIONS
                    .map(|d| self.site_at(face, std::array::from_fn(|c| b[c].wrapping_add_signed(d[c]))));
                Ring { around: around.to_vec(), closed: true }
            }
            Site::Base(v) => self.ring_of_base(v),
            Site::Edge { edge, t } => self.ring_of_edge(edge, t),
        }
    }

    fn ring_of_base(&self, vertex: u32) -> Ring<Site> {
        let base = self.base();
        let fan = base.fan(vertex);
        let one_step = |face: u32, corner: u8, towards: u8| {
            let mut b = [0; 3];
            b[usize::from(corner)] = self.segments() - 1;
            b[usize::from(towards)] = 1;
            self.site_at(face, b)
        };
        let mut around: Vec<Site> = fan.corners.iter().map(|&(f, c)| one_step(f, c, (c + 1) % 3)).collect();
        if !fan.closed {
            let &(f, c) = fan.corners.last().expect("a base vertex has a face");
            around.push(one_step(f, c, (c + 2) % 3));
        }
        Ring { around, closed: fan.closed }
    }

    fn ring_of_edge(&self, edge: u32, t: u32) -> Ring<Site> {
        let [left, right] = self.beside_edge(edge, t);
        let left = left.expect("an edge has a face");
        match right {
            None => Ring { around: left.to_vec(), closed: false },
            Some(right) => {
                Ring { around: vec![left[0], left[1], left[2], left[3], right[1], right[2]], closed: true }
            }
        }
    }

    /// The neighbours of an edge's vertex in the faces to either side, counter-clockwise: looking along the edge in
    /// the side's direction, the one ahead, two inside the face, the one behind.
    fn beside_edge(&self, edge: u32, t: u32) -> [Option<[Site; 4]>; 2] {
        let beside = |side: super::EdgeSide| {
            let (b, k) = (self.on_side(edge, side.face, side.k, t), usize::from(side.k));
            let at = |p: i32, q: i32, o: i32| {
                let mut moved = b;
                moved[k] = moved[k].wrapping_add_signed(p);
                moved[(k + 1) % 3] = moved[(k + 1) % 3].wrapping_add_signed(q);
                moved[(k + 2) % 3] = moved[(k + 2) % 3].wrapping_add_signed(o);
                self.site_at(side.face, moved)
            };
            [at(-1, 1, 0), at(-1, 0, 1), at(0, -1, 1), at(1, -1, 0)]
        };
        let [first, second] = self.base().sides(edge);
        [first.map(beside), second.map(beside)]
    }

    /// Calls back for each neighbour of a vertex, in no particular order. Faster than [`Layout::ring`]: inside a base
    /// face it is six additions.
    pub fn for_each_neighbour(&self, site: Site, mut found: impl FnMut(Site)) {
        match site {
            Site::Face { face, i, r } if i > 1 && r > 1 && i + r + 1 < self.segments() => {
                for [_, di, dr] in DIRECTIONS {
                    let (i, r) = (i.wrapping_add_signed(di), r.wrapping_add_signed(dr));
                    found(Site::Face { face, i, r });
                }
            }
            Site::Face { face, i, r } => {
                for [_, di, dr] in DIRECTIONS {
                    let (i, r) = (i.wrapping_add_signed(di), r.wrapping_add_signed(dr));
                    found(self.site_at(face, [self.segments() - i - r, i, r]));
                }
            }
            Site::Edge { edge, t } => {
                let [left, right] = self.beside_edge(edge, t);
                left.into_iter().flatten().for_each(&mut found);
                right.iter().flat_map(|right| [right[1], right[2]]).for_each(found);
            }
            Site::Base(_) => self.ring(site).around.into_iter().for_each(found),
        }
    }

    /// The k-disc of a set of vertices: everything within `k` edges, each vertex once, nearest first.
    pub fn disc(&self, centres: &[Site], k: u8) -> Vec<Site> {
        let mut seen: FxHashSet<Site> = FxHashSet::default();
        let mut disc: Vec<Site> = centres.iter().copied().filter(|&c| seen.insert(c)).collect();
        let mut from = 0;
        for _ in 0..k {
            let to = disc.len();
            for at in from..to {
                for neighbour in self.ring(disc[at]).around {
                    if seen.insert(neighbour) {
                        disc.push(neighbour);
                    }
                }
            }
            from = to;
        }
        disc
    }

    /// The site, at level j + 1, of the midpoint of the edge between two neighbouring vertices of this level.
    pub fn midpoint(&self, a: Site, b: Site) -> Site {
        match (a, b) {
            (Site::Face { face, .. }, other) | (other, Site::Face { face, .. }) => {
                let first = if matches!(a, Site::Face { .. }) { a } else { b };
                self.halfway(face, first, other)
            }
            (Site::Edge { edge, .. }, other) | (other, Site::Edge { edge, .. }) => {
                if let (Site::Edge { edge: e1, t: t1 }, Site::Edge { edge: e2, t: t2 }) = (a, b)
                    && e1 == e2
                {
                    return Site::Edge { edge, t: t1 + t2 };
                }
                let first = if matches!(a, Site::Edge { .. }) { a } else { b };
                let face = self
                    .base()
                    .sides(edge)
                    .into_iter()
                    .flatten()
                    .map(|side| side.face)
                    .find(|&face| self.in_face(face, other).is_some())
                    .expect("neighbours share a base face");
                self.halfway(face, first, other)
            }
            (Site::Base(v), Site::Base(w)) => {
                let ends = [v.min(w), v.max(w)];
                let edge = self.base().edges().binary_search(&ends).expect("neighbours share an edge");
                Site::Edge { edge: edge as u32, t: 1 }
            }
        }
    }

    fn halfway(&self, face: u32, a: Site, b: Site) -> Site {
        let (p, q) = (self.in_face(face, a), self.in_face(face, b));
        let (p, q) = (p.expect("a vertex of the face"), q.expect("a vertex of the face"));
        // Sums of two points with weights n are points with weights 2n: the midpoint one level finer.
        site_in(self.base(), 2 * self.segments(), face, std::array::from_fn(|c| p[c] + q[c]))
    }

    /// Barycentric coordinates of a site in a given face, if it lies in it.
    pub fn in_face(&self, face: u32, site: Site) -> Option<[u32; 3]> {
        let n = self.segments();
        match site {
            Site::Face { face: own, i, r } => (own == face).then_some([n - i - r, i, r]),
            Site::Edge { edge, t } => {
                let k = self.base().face_edges(face).iter().position(|&e| e == edge)?;
                Some(self.on_side(edge, face, k as u8, t))
            }
            Site::Base(v) => {
                let corner = self.base().faces()[face as usize].iter().position(|&c| c == v)?;
                let mut b = [0; 3];
                b[corner] = n;
                Some(b)
            }
        }
    }

    /// The slots of the one-ring.
    pub fn ring_slots(&self, site: Site) -> impl Iterator<Item = Slot> + '_ {
        self.ring(site).around.into_iter().map(|s| self.slot(s))
    }
}
