//! Rows of a strip: reading them from a level's storage into a window and writing them back.

use super::border::Border;
use super::chart::Chart;
use super::face_blocks::FaceBlock;
use super::pairs;
use super::window::HALO;
use pulp::Arch;
use std::ops::Range;

/// A strip of a face: some columns of even vertices.
#[derive(Debug, Clone, Copy)]
pub(super) struct Strip {
    /// The first even vertex of a row.
    pub(super) first: i32,
    /// The last.
    pub(super) last: i32,
    /// What its rows are moved with.
    pub(super) arch: Arch,
}

impl Strip {
    /// The strip's share of even vertices `from..=to` of a row.
    pub(super) fn part(self, from: i32, to: i32) -> Range<i32> {
        let from = self.first.max(from);
        from..(self.last.min(to) + 1).max(from)
    }

    /// Reads row `ρ` of the unfolded fine grid into two planes. `stored` is the part of it that lies inside the face,
    /// as [`pairs`] has it.
    #[inline(always)]
    pub(super) fn read_row<const N: usize>(
        self,
        chart: &Chart,
        border: &Border<N>,
        rho: i32,
        stored: &[[i32; N]],
        [a, b]: [&mut [[i32; N]]; 2],
    ) {
        let left = self.first - HALO;
        let right = left + a.len() as i32 - 1;
        // Columns whose pair lies inside the face.
        let (from, to) = (left.max(1), right.min((stored.len() as i32 - 1).div_euclid(2)));
        match border.sides(rho) {
            Some([before, after]) if from <= to => {
                if self.first == 0 {
                    let (pairs, on_edge) = before.as_chunks::<2>();
                    for ((pair, a), b) in pairs.iter().zip(&mut *a).zip(&mut *b) {
                        (*a, *b) = (pair[0], pair[1]);
                    }
                    (a[pairs.len()], b[pairs.len()]) = (on_edge[0], stored[0]);
                }
                let column = (to + 1 - left) as usize;
                put_right_side(stored, after, [&mut a[column..], &mut b[column..]]);
            }
            _ => self.read_around(chart, border, rho, stored, [from, to], [&mut *a, &mut *b]),
        }
        if from <= to {
            let columns = (from - left) as usize..(to - left + 1) as usize;
            let stored = &stored[(2 * from - 1) as usize..(2 * to + 1) as usize];
            pairs::split(self.arch, stored, &mut a[columns.clone()], &mut b[columns]);
        }
    }

    /// What of a row lies in no pair inside the face, which are those of columns `from..=to`; anywhere.
    #[inline(never)]
    fn read_around<const N: usize>(
        self,
        chart: &Chart,
        border: &Border<N>,
        rho: i32,
        stored: &[[i32; N]],
        [from, to]: [i32; 2],
        [a, b]: [&mut [[i32; N]]; 2],
    ) {
        let left = self.first - HALO;
        let right = left + a.len() as i32 - 1;
        let (low, high) = chart.reach(rho);
        let (low, high) = (low.max(2 * left), high.min(2 * right + 1));
        let around =
            if from > to { [[low, high], [0, -1]] } else { [[low, 2 * from - 1], [2 * to + 2, high]] };
        for columns in around {
            border.row(
                rho,
                columns,
                |i| stored[i as usize - 1],
                |i, value| {
                    let plane = if i & 1 == 0 { &mut *a } else { &mut *b };
                    plane[((i >> 1) - left) as usize] = value;
                },
            );
        }
    }

    /// Writes the strip's share of a row `ρ` of the face's fine grid from two planes: its inside to `stored`, border
    /// points to `border`. Corners of the face are left out.
    #[inline(always)]
    pub(super) fn write_row<const N: usize>(
        self,
        chart: &Chart,
        rho: i32,
        stored: &mut [[i32; N]],
        mut border: impl FnMut(i32, [i32; N]),
        [a, b]: [&[[i32; N]]; 2],
    ) {
        let n = 2 * chart.n();
        let left = self.first - HALO;
        let value = |i: i32| {
            let plane = if i % 2 == 0 { a } else { b };
            plane[(i / 2 - left) as usize]
        };
        let (low, high) = (2 * self.first, (2 * self.last + 1).min(n - rho));
        if rho == 0 {
            (low..=high).for_each(|i| border(i, value(i)));
            return;
        }
        for i in [0, n - rho] {
            if (low..=high).contains(&i) {
                border(i, value(i));
            }
        }
        let inside = stored.len() as i32;
        let (from, to) = (self.first.max(1), self.last.min((inside - 1).div_euclid(2)));
        if from <= to {
            let columns = (from - left) as usize..(to - left + 1) as usize;
            let stored = &mut stored[(2 * from - 1) as usize..(2 * to + 1) as usize];
            pairs::merge(self.arch, &a[columns.clone()], &b[columns], stored);
        }
        // What is inside but in no whole pair.
        for i in [1, inside] {
            if (low..=high).contains(&i) && (1..=inside).contains(&i) {
                stored[i as usize - 1] = value(i);
            }
        }
    }
}

/// What follows the last whole pair of a row inside a face, from there on in two planes: perhaps one value more inside, what
/// stands on and beyond the edge, and zeros.
#[inline(always)]
fn put_right_side<const N: usize>(
    stored: &[[i32; N]],
    after: &[[i32; N]; 2 * HALO as usize + 1],
    [a, b]: [&mut [[i32; N]]; 2],
) {
    // One more at the front, or a zero at the end.
    let shift = usize::from(stored.len().is_multiple_of(2));
    let value = |place: usize| match place.checked_sub(shift) {
        Some(beyond) => after.get(beyond).copied().unwrap_or([0; N]),
        None => stored[stored.len() - 1],
    };
    for (pair, (a, b)) in a.iter_mut().zip(b).enumerate() {
        (*a, *b) = (value(2 * pair), value(2 * pair + 1));
    }
}

impl<T: Copy> FaceBlock<'_, T> {
    /// Writes a border point of a grid with `n` segments, if this face is the one to write it. `index` is its place in
    /// the edge's part of the storage.
    pub(super) fn put_on_edge(
        &mut self,
        chart: &Chart,
        n: i32,
        [i, r]: [i32; 2],
        value: T,
        index: impl Fn(u32) -> u32,
    ) {
        if let Some(place) = chart.on_edge(n, i, r)
            && let Some(edge) = &mut self.edges[place.k]
        {
            edge[index(place.t) as usize] = value;
        }
    }
}
