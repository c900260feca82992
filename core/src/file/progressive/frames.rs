//! Local frames: what part of a wavelet coefficient lies along the surface's normal, and what part in the surface.
//!
//! A frame is read off positions that the reader has when a level begins, and turns a coefficient by two lifting steps,
//! so it is undone exactly: with `a` the axis nearest to the normal `n`, `ν = d·n / |n_a|` and the two other components
//! less their share of `ν n`. An error of `ν` moves a vertex along the normal, one of the others in the surface.

use super::visit::of_odds;
use crate::hierarchy::{Hierarchy, Level};
use crate::surface::Vector;

/// Bits of a slope's fraction.
const BITS: u32 = 14;

/// The frame of one odd vertex.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Frame {
    /// `n_b / n_a` and `n_c / n_a`, where b and c follow a.
    slopes: [i16; 2],
    /// `n_a n_b` and `n_a n_c` for the unit normal.
    shares: [i16; 2],
    axis: u8,
    reversed: bool,
}

impl Frame {
    /// The frame about a normal of any length.
    fn about(normal: [i64; 3]) -> Self {
        let size = normal.map(i64::unsigned_abs);
        let axis = (1..3).fold(0, |axis, c| if size[c] > size[axis] { c } else { axis });
        if size[axis] == 0 {
            return Self::default();
        }
        let shift = (64 - size[axis].leading_zeros()).saturating_sub(31);
        let [a, b, c] = [0, 1, 2].map(|k| normal[(axis + k) % 3] >> shift);
        let slopes = [b, c].map(|x| quotient(x << BITS, a));
        let square = (1 << (2 * BITS)) + slopes[0] * slopes[0] + slopes[1] * slopes[1];
        let shares = slopes.map(|x| quotient(x << (2 * BITS), square));
        Self {
            slopes: slopes.map(|x| x as i16),
            shares: shares.map(|x| x as i16),
            axis: axis as u8,
            reversed: a < 0,
        }
    }

    #[inline]
    fn along(self, b: i32, c: i32) -> i32 {
        let [p, q] = self.slopes.map(i64::from);
        ((p * i64::from(b) + q * i64::from(c) + (1 << (BITS - 1))) >> BITS) as i32
    }

    #[inline]
    fn share(self, k: usize, normal: i32) -> i32 {
        ((i64::from(self.shares[k]) * i64::from(normal) + (1 << (BITS - 1))) >> BITS) as i32
    }

    /// A coefficient as normal part and two tangential parts.
    #[inline]
    pub(super) fn turn(self, d: Vector) -> Vector {
        let [a, b, c] = [0, 1, 2].map(|k| d[(usize::from(self.axis) + k) % 3]);
        let normal = a.wrapping_add(self.along(b, c));
        let tangential = [b.wrapping_sub(self.share(0, normal)), c.wrapping_sub(self.share(1, normal))];
        [if self.reversed { normal.wrapping_neg() } else { normal }, tangential[0], tangential[1]]
    }

    /// The way back, exactly.
    #[inline]
    pub(super) fn turn_back(self, local: Vector) -> Vector {
        let normal = if self.reversed { local[0].wrapping_neg() } else { local[0] };
        let b = local[1].wrapping_add(self.share(0, normal));
        let c = local[2].wrapping_add(self.share(1, normal));
        let mut d = [0; 3];
        for (k, x) in [normal.wrapping_sub(self.along(b, c)), b, c].into_iter().enumerate() {
            d[(usize::from(self.axis) + k) % 3] = x;
        }
        d
    }
}

/// `x / y` towards zero for `|x| < 2^46`, `|y| < 2^32` and a result of some 2^14: several times faster than dividing integers,
/// and the same. Both are exact as `f64`, the quotient is rounded by less than 2^−37, and one that is no integer is 2^−32 or
/// more from the next.
#[inline(always)]
fn quotient(x: i64, y: i64) -> i64 {
    (x as f64 / y as f64) as i64
}

/// The frames of the odd vertices of a level, from positions of its vertices by slot: each about the sum of its parents'
/// normals. A vertex's normal is the sum of `(b − a) × (c − a)` over its faces, modulo 2^64. `O(n_j)`.
pub(super) fn frames(hierarchy: &Hierarchy, level: Level, positions: &[Vector]) -> Vec<Frame> {
    let normals = normals(hierarchy, level, positions);
    of_odds(hierarchy.layout(level), hierarchy.layout(level.finer()), |_, _, parents| {
        let [u, w] = parents.map(|slot| normals[slot as usize]);
        Frame::about([0, 1, 2].map(|c| u[c].wrapping_add(w[c])))
    })
}

fn normals(hierarchy: &Hierarchy, level: Level, positions: &[Vector]) -> Vec<[i64; 3]> {
    let mut normals = vec![[0i64; 3]; positions.len()];
    hierarchy.for_each_triangle(level, |corners| {
        let [a, b, c] = corners.map(|slot| positions[slot as usize].map(i64::from));
        let [p, q] = [b, c].map(|x| [0, 1, 2].map(|k| x[k] - a[k]));
        let cross = [0, 1, 2].map(|k| {
            let (l, m) = ((k + 1) % 3, (k + 2) % 3);
            p[l].wrapping_mul(q[m]).wrapping_sub(p[m].wrapping_mul(q[l]))
        });
        for slot in corners {
            let normal = &mut normals[slot as usize];
            *normal = [0, 1, 2].map(|k| normal[k].wrapping_add(cross[k]));
        }
    });
    normals
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Turning is undone to the bit, whatever the normal and the coefficient.
        #[test]
        fn turning_back_undoes_turning(normal: [i64; 3], shift in 0u32..64, d: Vector) {
            let frame = Frame::about(normal.map(|x| x >> shift));
            prop_assert_eq!(frame.turn_back(frame.turn(d)), d);
            prop_assert_eq!(frame.turn(frame.turn_back(d)), d);
        }

        /// The quotients of frames are those of integers, for sizes that just divide too.
        #[test]
        fn quotients_are_exact(y in 1i64..1 << 31, share in -16_400i64..=16_400, off in -2i64..=2, down: bool) {
            for y in [y, (1 << 31) - (y >> 20), 1 << 30] {
                let (x, y) = (share * y + off, if down { -y } else { y });
                prop_assert_eq!(quotient(x, y), x / y);
            }
        }

        /// A coefficient along the normal has a normal part alone, and it points outwards.
        #[test]
        fn a_normal_coefficient_is_normal(normal: [i16; 3], size in 1i32..1000) {
            prop_assume!(normal != [0; 3]);
            let frame = Frame::about(normal.map(i64::from));
            let d = normal.map(|x| i32::from(x) * size);
            let local = frame.turn(d);
            let largest = d.iter().map(|x| x.abs()).max().expect("three");
            prop_assert!(local[0] > 0 && local[0] >= largest);
            let little = 2 + (largest >> 10);
            prop_assert!(local[1].abs() <= little && local[2].abs() <= little, "{:?}", local);
        }
    }
}
