//! The update with AVX2, eight values a register, and with AVX-512, sixteen: products of even and of odd lanes apart.

use super::{Ahead, LARGEST_BLOCK, PlacedStencil, Update};
use pulp::bytemuck::Pod;
use pulp::x86::{V3, V4};
use pulp::{Simd, WithSimd};
use std::arch::x86_64::{__m256i, __m512i};

/// What the update needs of a set of instructions.
pub(super) trait Registers: Copy {
    /// Values beside each other.
    type Register: Copy + Pod;

    /// The same in all 64-bit lanes.
    fn repeated(self, value: i64) -> Self::Register;
    /// `a + b` in 32-bit lanes.
    fn sum(self, a: Self::Register, b: Self::Register) -> Self::Register;
    /// `total + a · weight` in 64-bit lanes, of the lower half of each lane of `a`.
    fn with_product(self, total: Self::Register, a: Self::Register, weight: Self::Register)
    -> Self::Register;
    /// The upper halves of 64-bit lanes as the lower ones.
    fn upper_halves(self, a: Self::Register) -> Self::Register;
    /// Bits 20 to 51 of every sum, those of even and of odd lanes put back beside each other.
    fn rounded(self, even: Self::Register, odd: Self::Register) -> Self::Register;
}

impl Registers for V3 {
    type Register = __m256i;

    #[inline(always)]
    fn repeated(self, value: i64) -> __m256i {
        self.avx._mm256_set1_epi64x(value)
    }

    #[inline(always)]
    fn sum(self, a: __m256i, b: __m256i) -> __m256i {
        self.avx2._mm256_add_epi32(a, b)
    }

    #[inline(always)]
    fn with_product(self, total: __m256i, a: __m256i, weight: __m256i) -> __m256i {
        self.avx2._mm256_add_epi64(total, self.avx2._mm256_mul_epi32(a, weight))
    }

    #[inline(always)]
    fn upper_halves(self, a: __m256i) -> __m256i {
        self.avx2._mm256_srli_epi64::<32>(a)
    }

    #[inline(always)]
    fn rounded(self, even: __m256i, odd: __m256i) -> __m256i {
        let (even, odd) = (self.avx2._mm256_srli_epi64::<20>(even), self.avx2._mm256_slli_epi64::<12>(odd));
        self.avx2._mm256_blend_epi32::<0b1010_1010>(even, odd)
    }
}

impl Registers for V4 {
    type Register = __m512i;

    #[inline(always)]
    fn repeated(self, value: i64) -> __m512i {
        self.avx512f._mm512_set1_epi64(value)
    }

    #[inline(always)]
    fn sum(self, a: __m512i, b: __m512i) -> __m512i {
        self.avx512f._mm512_add_epi32(a, b)
    }

    #[inline(always)]
    fn with_product(self, total: __m512i, a: __m512i, weight: __m512i) -> __m512i {
        self.avx512f._mm512_add_epi64(total, self.avx512f._mm512_mul_epi32(a, weight))
    }

    #[inline(always)]
    fn upper_halves(self, a: __m512i) -> __m512i {
        self.avx512f._mm512_srli_epi64::<32>(a)
    }

    #[inline(always)]
    fn rounded(self, even: __m512i, odd: __m512i) -> __m512i {
        let avx = self.avx512f;
        let (even, odd) = (avx._mm512_srli_epi64::<20>(even), avx._mm512_slli_epi64::<12>(odd));
        avx._mm512_mask_blend_epi32(0b1010_1010_1010_1010, even, odd)
    }
}

/// Updates with such registers: four a block with AVX2 (on Zen 3 1, 2, 3, 4 take 4.7, 2.6, 2.3, 2.4 ns per finest vertex),
/// three with AVX-512, which divide a strip evenly (before rows were folded 1, 2, 3, 4 took 8.5, 7.0, 6.6, 6.6 ns on a Xeon, for the
/// whole of analysis).
pub(super) struct With<'a, R> {
    pub(super) registers: R,
    pub(super) update: Update<'a>,
    pub(super) ahead: &'a mut Ahead,
}

impl WithSimd for With<'_, V3> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { registers, update, ahead } = self;
        update.by_blocks::<32>(ahead, |stencil, details, ahead| {
            pulp::cast(sums::<_, 32, 4>(registers, stencil, details, ahead))
        });
    }
}

impl WithSimd for With<'_, V4> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { registers, update, ahead } = self;
        update.by_blocks::<LARGEST_BLOCK>(ahead, |stencil, details, ahead| {
            pulp::cast(sums::<_, LARGEST_BLOCK, 3>(registers, stencil, details, ahead))
        });
    }
}

#[inline(always)]
fn sums<R: Registers, const L: usize, const K: usize>(
    registers: R,
    stencil: &PlacedStencil,
    details: &[i32],
    ahead: &mut Ahead,
) -> [R::Register; K]
where
    [R::Register; K]: Pod,
    [i32; L]: Pod,
{
    let half = registers.repeated(1 << 19);
    let mut total = Total { even: [half; K], odd: [half; K] };
    let mut taps = stencil.taps.as_slice();
    for &(weight, count) in &stencil.classes {
        ahead.step();
        let taps = taps.split_off(..count).expect("taps of the class");
        total.add::<_, L>(registers, weight, details, taps);
    }
    std::array::from_fn(|k| registers.rounded(total.even[k], total.odd[k]))
}

/// 64-bit sums of the even and of the odd lanes.
struct Total<T, const K: usize> {
    even: [T; K],
    odd: [T; K],
}

impl<T: Copy, const K: usize> Total<T, K>
where
    [T; K]: Pod,
{
    #[inline(always)]
    fn add<R: Registers<Register = T>, const L: usize>(
        &mut self,
        registers: R,
        weight: i32,
        details: &[i32],
        taps: &[u32],
    ) where
        [i32; L]: Pod,
    {
        let Some((&first, taps)) = taps.split_first() else { return };
        let mut sum: [T; K] = load::<_, L>(details, first);
        for &tap in taps {
            let values: [T; K] = load::<_, L>(details, tap);
            for (sum, values) in sum.iter_mut().zip(values) {
                *sum = registers.sum(*sum, values);
            }
        }
        let weight = registers.repeated(i64::from(weight));
        for (k, sum) in sum.into_iter().enumerate() {
            self.even[k] = registers.with_product(self.even[k], sum, weight);
            self.odd[k] = registers.with_product(self.odd[k], registers.upper_halves(sum), weight);
        }
    }
}

#[inline(always)]
fn load<V: Pod, const L: usize>(details: &[i32], tap: u32) -> V
where
    [i32; L]: Pod,
{
    // One comparison a tap: a sum of u32 cannot overflow.
    let values = &details[tap as usize..tap as usize + L];
    pulp::cast::<[i32; L], _>(values.try_into().expect("of that length"))
}
