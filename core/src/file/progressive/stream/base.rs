//! The base positions: they come first, down to a plane, and a plane or more between the blocks of the levels.

use super::{MOST_PLANES, State, Truth, bound};
use crate::file::progressive::range_coder::{Coder, Model};
use crate::hierarchy::{Layout, Level};
use crate::surface::Vector;

/// Base positions as far as they are known.
pub(super) struct Known<'a> {
    pub(super) positions: &'a [Vector],
    pub(super) plane: u32,
    /// The first that is still at another plane, and that plane.
    pub(super) cut: Option<(usize, u32)>,
}

impl Known<'_> {
    /// The middles of what they may be.
    pub(super) fn middles(&self) -> Vec<Vector> {
        let middle = |at: usize, x: i32| {
            let plane = match self.cut {
                Some((first, above)) if at >= first => above,
                _ => self.plane,
            };
            if plane == 0 { x } else { x.wrapping_add(1 << (plane - 1)) }
        };
        self.positions.iter().enumerate().map(|(at, c)| c.map(|x| middle(at, x))).collect()
    }
}

impl State<'_> {
    /// A plane more of the base positions.
    pub(super) fn base_block<C: Coder>(&mut self, coder: &mut C, to: u32, truth: &[Vector]) -> bool {
        let count = self.base_plane - to;
        self.changed(None);
        for at in 0..self.base.len() {
            let truth = if C::WRITES { truth[at] } else { [0; 3] };
            let more = truth.map(|x| {
                let low = (x >> to) as u32 & ((1u64 << count) - 1) as u32;
                (coder.long_raw(count, low) << to) as i32
            });
            if coder.is_exhausted() {
                self.base_cut = Some((at, self.base_plane));
                self.base_plane = to;
                return false;
            }
            self.base[at] = [0, 1, 2].map(|c| self.base[at][c] | more[c]);
        }
        self.base_plane = to;
        true
    }

    /// What comes before the first block: the base positions down to a plane, and every level's highest planes. Whether
    /// it was all there.
    pub(super) fn beginning<C: Coder>(&mut self, coder: &mut C, truth: &Truth) -> bool {
        self.base_plane = coder.raw(5, self.base_plane).min(MOST_PLANES);
        let (plane, neighbours) = (self.base_plane, lower_neighbours(self.hierarchy.layout(Level::BASE)));
        for (at, around) in neighbours.iter().enumerate() {
            let expected = |c: usize| match around.len() {
                0 => self.base[at.saturating_sub(1)][c] >> plane,
                count => {
                    let sum: i64 = around.iter().map(|&v| i64::from(self.base[v as usize][c] >> plane)).sum();
                    sum.div_euclid(count as i64) as i32
                }
            };
            let truth = if C::WRITES { truth.base[at] } else { [0; 3] };
            self.base[at] = [0, 1, 2].map(|c| {
                let expected = expected(c);
                let off =
                    signed(coder, &mut self.order.positions[c], (truth[c] >> plane).wrapping_sub(expected));
                expected.wrapping_add(off) << plane
            });
            if coder.is_exhausted() {
                return false;
            }
        }
        for j in 0..self.levels.len() {
            let most = if C::WRITES { bound(&truth.local[j]) } else { 0 };
            self.levels[j].planes = [coder.raw(5, most).min(MOST_PLANES); 2];
        }
        !coder.is_exhausted()
    }
}

/// A signed number: zero or not, sign, and the magnitude less one by its length.
fn signed<C: Coder>(coder: &mut C, models: &mut [Model; 33], x: i32) -> i32 {
    let folded = if C::WRITES { ((x << 1) ^ (x >> 31)) as u32 } else { 0 };
    let bits = 32 - folded.leading_zeros();
    let mut length = 0;
    while length < 32 && coder.bit(&mut models[length as usize], bits > length) {
        length += 1;
    }
    if length == 0 {
        return 0;
    }
    let low = coder.long_raw(length - 1, folded & ((1u64 << (length - 1)) - 1) as u32);
    let folded = low | (1u64 << (length - 1)) as u32;
    (folded >> 1) as i32 ^ -((folded & 1) as i32)
}

/// Of every base vertex the neighbours with lower numbers.
fn lower_neighbours(layout: &Layout) -> Vec<Vec<u32>> {
    let mut lower = vec![Vec::new(); layout.len() as usize];
    for &[low, high] in layout.base().edges() {
        lower[high as usize].push(low);
    }
    lower
}
