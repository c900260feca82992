//! The update step as a row kernel: `Σ_i w_iv d_i` for a run of even vertices at once, all channels side by side.
//!
//! Taps of one weight are added in i32 and multiplied once, in i64; details of [`super::SUMMABLE_BITS`] cannot overflow
//! a class of twelve. The stencil is its own mirror image across the row, so rows of many taps are added to theirs first, and each
//! tap of the sum stands for two. `pulp` tells at run time what the processor has: with AVX-512 and AVX2 products are taken of even and
//! odd lanes apart, which needs no widening; elsewhere the same sums are left to the compiler's vectoriser.

#[cfg(target_arch = "x86_64")]
mod x86;

use super::prefetch::Ahead;
use super::stencil::PlacedStencil;
use pulp::Arch;

/// Values that rows are worked on by: those of the largest register, and of a line of the cache.
pub(super) const LANES: usize = 16;

/// No implementation takes more values at a time.
pub(super) const LARGEST_BLOCK: usize = 48;

/// Which way the update goes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Direction {
    /// Analysis: adds.
    Add,
    /// Synthesis: subtracts.
    Subtract,
}

/// Updates a run of even vertices: `evens ± (Σ w d + 2^19) >> 20`.
pub(super) struct Update<'a> {
    pub(super) stencil: &'a PlacedStencil,
    pub(super) direction: Direction,
    /// Details in planes, and room for rows of sums of them.
    pub(super) details: &'a mut [i32],
    /// Where the planes end.
    pub(super) planes: usize,
    /// Where in `details` the first even vertex's taps are counted from.
    pub(super) at: usize,
    /// So many values before and after the run taps reach along a row.
    pub(super) reach: usize,
    pub(super) evens: &'a mut [i32],
}

impl Update<'_> {
    /// Does it with what the processor has, and has what is ahead fetched meanwhile.
    pub(super) fn run(self, arch: Arch, ahead: &mut Ahead) {
        match arch {
            #[cfg(target_arch = "x86_64")]
            Arch::V4(v4) => pulp::Simd::vectorize(v4, x86::With { registers: v4, update: self, ahead }),
            #[cfg(target_arch = "x86_64")]
            Arch::V3(v3) => pulp::Simd::vectorize(v3, x86::With { registers: v3, update: self, ahead }),
            // Enough values a block that the loop over taps outweighs its checks.
            _ => self.by_blocks::<32>(ahead, portable),
        }
    }

    /// Adds or subtracts what `update` gives for blocks of values; of the last block only what lies in the run.
    #[inline(always)]
    fn by_blocks<const L: usize>(
        self,
        ahead: &mut Ahead,
        update: impl Fn(&PlacedStencil, &[i32], &mut Ahead) -> [i32; L],
    ) {
        let Self { stencil, direction, details, planes, mut at, reach, evens } = self;
        ahead.spread(evens.len().div_ceil(L) * stencil.classes.len());
        for fold in &stencil.folds {
            let (from, sums) = details.split_at_mut(planes);
            let len = (evens.len() + 2 * reach).next_multiple_of(LANES);
            let [u, w] = fold.rows.map(|row| &from[row as usize + at - reach..][..len]);
            let sums = &mut sums[fold.to as usize + at - reach - planes..][..len];
            for ((sum, &u), &w) in sums.iter_mut().zip(u).zip(w) {
                *sum = u.wrapping_add(w);
            }
        }
        for block in evens.chunks_mut(L) {
            let update = update(stencil, &details[at..], ahead);
            match direction {
                Direction::Add => block.iter_mut().zip(update).for_each(|(e, u)| *e = e.wrapping_add(u)),
                Direction::Subtract => block.iter_mut().zip(update).for_each(|(e, u)| *e = e.wrapping_sub(u)),
            }
            at += L;
        }
    }
}

fn portable<const L: usize>(stencil: &PlacedStencil, details: &[i32], ahead: &mut Ahead) -> [i32; L] {
    let mut total = [1i64 << 19; L];
    let mut taps = stencil.taps.as_slice();
    for &(weight, count) in &stencil.classes {
        ahead.step();
        let mut sum = [0i32; L];
        for &tap in taps.split_off(..count).expect("taps of the class") {
            let values: &[i32; L] =
                details[tap as usize..tap as usize + L].try_into().expect("of that length");
            for l in 0..L {
                sum[l] = sum[l].wrapping_add(values[l]);
            }
        }
        for l in 0..L {
            total[l] += i64::from(sum[l]) * i64::from(weight);
        }
    }
    total.map(|sum| (sum >> 20) as i32)
}
