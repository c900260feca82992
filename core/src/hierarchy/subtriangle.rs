//! The triangles that a base face falls into, level by level: each is split into four, so they are a quadtree.

use super::{Layout, Level, Site, Slot};
use std::ops::Range;

/// A triangle of `M^l` inside a base face, by its lattice place.
///
/// An upward one has the corners `(i, r)`, `(i+1, r)`, `(i, r+1)`; a downward one `(i+1, r)`, `(i+1, r+1)`,
/// `(i, r+1)`, with `i` along the face's first edge and `r` the row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Subtriangle {
    /// The base face.
    pub face: u32,
    /// Place along the row.
    pub i: u32,
    /// The row.
    pub r: u32,
    /// Whether it points the other way from the face.
    pub down: bool,
}

impl Subtriangle {
    /// The whole base face.
    pub fn whole(face: u32) -> Self {
        Self { face, i: 0, r: 0, down: false }
    }

    /// Its number among the `n²` triangles a face has at a level with `n` segments, faces one after another.
    pub fn index(self, n: u32) -> usize {
        let within = self.r * (2 * n - self.r) + 2 * self.i + u32::from(self.down);
        self.face as usize * (n as usize * n as usize) + within as usize
    }

    /// The one with a number.
    pub fn numbered(index: usize, n: u32) -> Self {
        let (per_face, n) = (n as usize * n as usize, n as usize);
        let within = index % per_face;
        // From row r on there are (n − r)² of a face's triangles.
        let left = (per_face - within - 1).isqrt() + 1;
        let r = n - left;
        let along = within - r * (2 * n - r);
        Self {
            face: (index / per_face) as u32,
            i: (along / 2) as u32,
            r: r as u32,
            down: !along.is_multiple_of(2),
        }
    }

    /// Its corners as lattice places `(i, r)`.
    pub fn corners(self) -> [[u32; 2]; 3] {
        let (i, r) = (self.i, self.r);
        if self.down { [[i + 1, r], [i + 1, r + 1], [i, r + 1]] } else { [[i, r], [i + 1, r], [i, r + 1]] }
    }

    /// The four triangles of the next level that make it up.
    pub fn children(self) -> [Self; 4] {
        let at =
            |i: u32, r: u32, down: bool| Self { face: self.face, i: 2 * self.i + i, r: 2 * self.r + r, down };
        if self.down {
            [at(1, 0, true), at(1, 1, true), at(0, 1, true), at(1, 1, false)]
        } else {
            [at(0, 0, false), at(1, 0, false), at(0, 1, false), at(0, 0, true)]
        }
    }

    /// The triangle of the level before that holds it.
    pub fn parent(self) -> Self {
        let both_odd = self.i % 2 == 1 && self.r % 2 == 1;
        let both_even = self.i.is_multiple_of(2) && self.r.is_multiple_of(2);
        let down = if self.down { !both_even } else { both_odd };
        Self { face: self.face, i: self.i / 2, r: self.r / 2, down }
    }

    /// All triangles of a face at a level with `n` segments.
    pub fn all_in_face(face: u32, n: u32) -> impl Iterator<Item = Self> {
        (0..n).flat_map(move |r| {
            (0..n - r).flat_map(move |i| {
                let up = Self { face, i, r, down: false };
                let down = (i + r + 1 < n).then_some(Self { down: true, ..up });
                std::iter::once(up).chain(down)
            })
        })
    }

    /// The triangles of a level that meet at one of its vertices.
    pub fn incident(layout: &Layout, site: Site) -> Vec<Self> {
        let base = layout.base();
        let faces: Vec<u32> = match site {
            Site::Face { face, .. } => vec![face],
            Site::Edge { edge, .. } => base.sides(edge).into_iter().flatten().map(|side| side.face).collect(),
            Site::Base(v) => base.fan(v).corners.iter().map(|&(face, _)| face).collect(),
        };
        let in_face = |face| {
            let [_, i, r] = layout.in_face(face, site).expect("the face contains the vertex");
            Self::around(face, i, r, layout.segments())
        };
        faces.into_iter().flat_map(in_face).collect()
    }

    /// The triangles of a coarser level that hold all those around some runs of a level's slots, each once, in no order.
    /// `seen` has room for a bit per triangle of the coarser level, and is clear before and after. Cost: the runs by rows
    /// and coarse triangles; on base edges by vertices.
    pub fn holding(
        layout: &Layout,
        runs: impl Iterator<Item = Range<u32>>,
        coarse: Level,
        seen: &mut [u64],
    ) -> Vec<Self> {
        let (n, depth) = (coarse.segments(), layout.level().0 - coarse.0);
        let mut held: Vec<Self> = Vec::new();
        let mut hold = |triangle: Self| {
            let at = triangle.index(n);
            let (word, bit) = (&mut seen[at / 64], 1 << (at % 64));
            if *word & bit == 0 {
                *word |= bit;
                held.push(triangle);
            }
        };
        for mut run in runs {
            while !run.is_empty() {
                let site = layout.site(Slot(run.start));
                let Site::Face { face, i, r } = site else {
                    for triangle in Self::incident(layout, site) {
                        hold((0..depth).fold(triangle, |t, _| t.parent()));
                    }
                    run.start += 1;
                    continue;
                };
                // A run may go on over several rows. The cells below and above a row hold all its triangles.
                let columns = (run.len() as u32).min(layout.segments() - r - i);
                run.start += columns;
                for r in (r - 1) >> depth..=r >> depth {
                    for i in (i - 1) >> depth..=(i + columns - 1) >> depth {
                        let both = [false, true].map(|down| Self { face, i, r, down });
                        both.into_iter().filter(|t| i + r + u32::from(t.down) < n).for_each(&mut hold);
                    }
                }
            }
        }
        held.iter().for_each(|t| seen[t.index(n) / 64] = 0);
        held
    }

    /// The up to six triangles of a face, at a level with `n` segments, that meet at the lattice place `(i, r)`.
    pub fn around(face: u32, i: u32, r: u32, n: u32) -> impl Iterator<Item = Self> {
        let (i, r, n) = (i64::from(i), i64::from(r), i64::from(n));
        let places = [
            (i, r, false),
            (i - 1, r, false),
            (i, r - 1, false),
            (i - 1, r, true),
            (i - 1, r - 1, true),
            (i, r - 1, true),
        ];
        places.into_iter().filter_map(move |(i, r, down)| {
            let inside = i >= 0 && r >= 0 && i + r + i64::from(down) < n;
            inside.then_some(Self { face, i: i as u32, r: r as u32, down })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::Subtriangle;

    #[test]
    fn numbers_are_a_bijection_and_parents_invert_children() {
        let mut level = vec![Subtriangle::whole(0), Subtriangle::whole(1)];
        for n in [1u32, 2, 4, 8] {
            let mut seen = vec![false; level.len()];
            for triangle in &level {
                assert!(!std::mem::replace(&mut seen[triangle.index(n)], true), "{triangle:?} at {n}");
                assert_eq!(Subtriangle::numbered(triangle.index(n), n), *triangle);
                for child in triangle.children() {
                    assert_eq!(child.parent(), *triangle);
                }
            }
            level = level.into_iter().flat_map(Subtriangle::children).collect();
        }
    }

    #[test]
    fn triangles_around_a_place_have_it_as_a_corner() {
        let n = 8;
        for r in 0..=n {
            for i in 0..=n - r {
                let count = Subtriangle::around(3, i, r, n).filter(|t| t.corners().contains(&[i, r])).count();
                let corner = [i == 0 && r == 0, i == n, r == n].contains(&true);
                let border = i == 0 || r == 0 || i + r == n;
                assert_eq!(
                    count,
                    if corner {
                        1
                    } else if border {
                        3
                    } else {
                        6
                    },
                    "({i}, {r})"
                );
            }
        }
    }
}
