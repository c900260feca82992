//! The predict step on rows, all channels of a vertex side by side.

use super::SUMMABLE_BITS;
use pulp::{Simd, WithSimd};

/// `⌊(u + w) / 2⌋` without overflow.
#[inline(always)]
pub(super) fn mean(u: i32, w: i32) -> i32 {
    (u & w).wrapping_add((u ^ w) >> 1)
}

/// Makes details of odd vertices, `odd − mean`, all slices of one length; whether class sums of them cannot overflow.
pub(super) struct Difference<'a> {
    pub(super) odd: &'a [i32],
    pub(super) parents: [&'a [i32]; 2],
    pub(super) detail: &'a mut [i32],
}

impl WithSimd for Difference<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let mut bits = 0;
        let [u, w] = self.parents;
        for (((detail, &odd), &u), &w) in self.detail.iter_mut().zip(self.odd).zip(u).zip(w) {
            let made = odd.wrapping_sub(mean(u, w));
            *detail = made;
            bits |= magnitude(made);
        }
        bits >> SUMMABLE_BITS == 0
    }
}

/// Makes odd vertices of details, `detail + mean`, all slices of one length; whether class sums of the details cannot overflow.
pub(super) struct Sum<'a> {
    pub(super) odd: &'a mut [i32],
    pub(super) parents: [&'a [i32]; 2],
    pub(super) detail: &'a [i32],
}

impl WithSimd for Sum<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let mut bits = 0;
        let [u, w] = self.parents;
        for (((odd, &detail), &u), &w) in self.odd.iter_mut().zip(self.detail).zip(u).zip(w) {
            *odd = detail.wrapping_add(mean(u, w));
            bits |= magnitude(detail);
        }
        bits >> SUMMABLE_BITS == 0
    }
}

/// A detail's magnitude, or one less.
#[inline(always)]
fn magnitude(detail: i32) -> i32 {
    detail ^ (detail >> 31)
}
