//! The update step as a row kernel: `Σ_i w_iv d_i` for a run of even vertices at once, all channels side by side.
//!
//! Taps of one weight are added in i32 and multiplied once, in i64; details of [`super::SUMMABLE_BITS`] cannot overflow
//! a class of twelve. `pulp` tells at run time what the processor has: with AVX-512 and AVX2 products are taken of even and
//! odd lanes apart, which needs no widening; elsewhere the same sums are left to the compiler's vectoriser.

#[cfg(target_arch = "x86_64")]
mod x86;

use super::stencil::PlacedStencil;
use pulp::Arch;

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
    pub(super) details: &'a [i32],
    /// Where in `details` the first even vertex's taps are counted from.
    pub(super) at: usize,
    pub(super) evens: &'a mut [i32],
}

impl Update<'_> {
    /// Does it with what the processor has.
    pub(super) fn run(self, arch: Arch) {
        match arch {
            #[cfg(target_arch = "x86_64")]
            Arch::V4(v4) => pulp::Simd::vectorize(v4, x86::With { registers: v4, update: self }),
            #[cfg(target_arch = "x86_64")]
            Arch::V3(v3) => pulp::Simd::vectorize(v3, x86::With { registers: v3, update: self }),
            _ => self.portable(),
        }
    }

    fn portable(self) {
        // Enough values a block that the loop over taps outweighs its checks.
        self.by_blocks(portable::<32>);
    }

    /// Adds or subtracts what `update` gives for blocks of values; of the last block only what lies in the run.
    #[inline(always)]
    fn by_blocks<const L: usize>(self, update: impl Fn(&PlacedStencil, &[i32], usize) -> [i32; L]) {
        let Self { stencil, direction, details, mut at, evens } = self;
        for block in evens.chunks_mut(L) {
            let update = update(stencil, details, at);
            match direction {
                Direction::Add => block.iter_mut().zip(update).for_each(|(e, u)| *e = e.wrapping_add(u)),
                Direction::Subtract => block.iter_mut().zip(update).for_each(|(e, u)| *e = e.wrapping_sub(u)),
            }
            at += L;
        }
    }
}

fn portable<const L: usize>(stencil: &PlacedStencil, details: &[i32], at: usize) -> [i32; L] {
    let details = &details[at..];
    let mut total = [1i64 << 19; L];
    let mut add = |weight: i32, taps: &[u32]| {
        let mut sum = [0i32; L];
        for &tap in taps {
            let values: &[i32; L] =
                details[tap as usize..tap as usize + L].try_into().expect("of that length");
            for l in 0..L {
                sum[l] = sum[l].wrapping_add(values[l]);
            }
        }
        for l in 0..L {
            total[l] += i64::from(sum[l]) * i64::from(weight);
        }
    };
    stencil.sixes.iter().for_each(|(weight, taps)| add(*weight, taps));
    stencil.twelves.iter().for_each(|(weight, taps)| add(*weight, taps));
    total.map(|sum| (sum >> 20) as i32)
}
