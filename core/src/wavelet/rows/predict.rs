//! The predict step on rows, all channels of a vertex side by side.

use super::SUMMABLE_BITS;
use pulp::{Simd, WithSimd};

/// `⌊(u + w) / 2⌋` without overflow.
#[inline(always)]
pub(super) fn mean(u: i32, w: i32) -> i32 {
    (u & w).wrapping_add((u ^ w) >> 1)
}

/// Makes details of odd vertices: `odd − mean`; whether class sums of them cannot overflow.
pub(super) struct Difference<'a> {
    pub(super) odd: &'a mut [i32],
    pub(super) u: &'a [i32],
    pub(super) w: &'a [i32],
}

impl WithSimd for Difference<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let mut beyond = 0;
        for ((odd, &u), &w) in self.odd.iter_mut().zip(self.u).zip(self.w) {
            *odd = odd.wrapping_sub(mean(u, w));
            beyond |= *odd ^ (*odd >> 31);
        }
        beyond >> SUMMABLE_BITS == 0
    }
}

/// Makes odd vertices of details: `detail + mean`; whether class sums of the details cannot overflow.
pub(super) struct Sum<'a> {
    pub(super) odd: &'a mut [i32],
    pub(super) detail: &'a [i32],
    pub(super) u: &'a [i32],
    pub(super) w: &'a [i32],
}

impl WithSimd for Sum<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let mut beyond = 0;
        let parents = self.u.iter().zip(self.w);
        for ((odd, &detail), (&u, &w)) in self.odd.iter_mut().zip(self.detail).zip(parents) {
            *odd = detail.wrapping_add(mean(u, w));
            beyond |= detail ^ (detail >> 31);
        }
        beyond >> SUMMABLE_BITS == 0
    }
}
