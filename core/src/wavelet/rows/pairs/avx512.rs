//! Splitting and merging with AVX-512: sixteen values picked out of thirty-two at once.

use pulp::x86::V4;
use pulp::{Simd, WithSimd};

/// Values of a register.
const LANES: usize = 16;
/// Values that are worked through together, sixteen pairs: six registers as they are stored, three of each plane.
const STORED: usize = 6 * LANES;
const PLANE: usize = 3 * LANES;

/// Where the values of a register are found: where two others begin, and which of their thirty-two values each is.
#[derive(Clone, Copy)]
struct Pick {
    from: [usize; 2],
    index: [i32; LANES],
}

/// The registers of both planes, in what is stored.
const SPLIT: [[Pick; 3]; 2] = {
    let mut picks = [[Pick { from: [0; 2], index: [0; LANES] }; 3]; 2];
    let mut at = 0;
    while at < 6 {
        let (plane, register) = (at / 3, at % 3);
        let first = stored(plane, register * LANES);
        let low = if first + 2 * LANES > STORED { STORED - 2 * LANES } else { first };
        let pick = &mut picks[plane][register];
        pick.from = [low, low + LANES];
        let mut lane = 0;
        while lane < LANES {
            pick.index[lane] = (stored(plane, register * LANES + lane) - low) as i32;
            lane += 1;
        }
        at += 1;
    }
    picks
};

/// Where a value of a plane is stored.
const fn stored(plane: usize, value: usize) -> usize {
    6 * (value / 3) + 3 * plane + value % 3
}

/// The registers as they are stored, in one of the first plane and one of the second.
const MERGE: [Pick; 6] = {
    let mut picks = [Pick { from: [0; 2], index: [0; LANES] }; 6];
    let mut register = 0;
    while register < 6 {
        let first = 3 * (register * LANES / 6);
        let low = if first + LANES > PLANE { PLANE - LANES } else { first };
        picks[register].from = [low; 2];
        let mut lane = 0;
        while lane < LANES {
            let (pair, value) = ((register * LANES + lane) / 6, (register * LANES + lane) % 6);
            let plane = value / 3;
            picks[register].index[lane] = (plane * LANES + 3 * pair + value % 3 - low) as i32;
            lane += 1;
        }
        register += 1;
    }
    picks
};

/// Splits stored pairs of three channels into planes, as many as come sixteen at a time; says how many pairs that are.
pub(super) fn split(v4: V4, pairs: &[i32], a: &mut [i32], b: &mut [i32]) -> usize {
    Simd::vectorize(v4, Split { v4, pairs, planes: [a, b] })
}

struct Split<'a> {
    v4: V4,
    pairs: &'a [i32],
    planes: [&'a mut [i32]; 2],
}

impl WithSimd for Split<'_> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        let Self { v4, pairs, planes: [a, b] } = self;
        let (groups, _) = pairs.as_chunks::<STORED>();
        let (a, _) = a.as_chunks_mut::<PLANE>();
        let (b, _) = b.as_chunks_mut::<PLANE>();
        for ((group, a), b) in groups.iter().zip(a).zip(b) {
            for (plane, picks) in [a, b].into_iter().zip(&SPLIT) {
                for (register, pick) in plane.as_chunks_mut::<LANES>().0.iter_mut().zip(picks) {
                    *register = picked(v4, [group, group], pick);
                }
            }
        }
        groups.len() * LANES
    }
}

/// Merges planes into stored pairs; the reverse of [`split`].
pub(super) fn merge(v4: V4, a: &[i32], b: &[i32], pairs: &mut [i32]) -> usize {
    Simd::vectorize(v4, Merge { v4, planes: [a, b], pairs })
}

struct Merge<'a> {
    v4: V4,
    planes: [&'a [i32]; 2],
    pairs: &'a mut [i32],
}

impl WithSimd for Merge<'_> {
    type Output = usize;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> usize {
        let Self { v4, planes: [a, b], pairs } = self;
        let (groups, _) = pairs.as_chunks_mut::<STORED>();
        let count = groups.len();
        let (a, _) = a.as_chunks::<PLANE>();
        let (b, _) = b.as_chunks::<PLANE>();
        for ((group, a), b) in groups.iter_mut().zip(a).zip(b) {
            for (register, pick) in group.as_chunks_mut::<LANES>().0.iter_mut().zip(&MERGE) {
                *register = picked(v4, [a, b], pick);
            }
        }
        count * LANES
    }
}

/// The values of a register, out of one of each array.
#[inline(always)]
fn picked<const L: usize>(v4: V4, [a, b]: [&[i32; L]; 2], pick: &Pick) -> [i32; LANES] {
    let load = |values: &[i32; L], from: usize| {
        let values: [i32; LANES] = values[from..from + LANES].try_into().expect("of that length");
        pulp::cast(values)
    };
    let [low, high] = [load(a, pick.from[0]), load(b, pick.from[1])];
    pulp::cast(v4.avx512f._mm512_permutex2var_epi32(low, pulp::cast(pick.index), high))
}
