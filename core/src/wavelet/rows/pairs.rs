//! Splitting rows of the fine grid into two planes and merging them again.
//!
//! Row `ρ` of a face's interior is stored from `i = 1`: plane `B` (odd `i`) at 0, then `A` and `B` by turns, so the pair
//! of column `I ≥ 1` stands at `2I − 1` and `2I`.
//!
//! Three channels, the usual case, are picked out of whole registers with AVX-512. Elsewhere they are moved four values at a
//! time, the fourth overwritten by the next move: one load and one store a vertex, an eighth of a level's whole time less than
//! channel by channel.

#[cfg(target_arch = "x86_64")]
mod avx512;

use pulp::Arch;

/// Pairs that are moved together.
const GROUP: usize = 8;

/// Splits the pairs of a stored row into planes.
pub(super) fn split<const N: usize>(arch: Arch, pairs: &[[i32; N]], a: &mut [[i32; N]], b: &mut [[i32; N]]) {
    let done = split_registers(arch, pairs, a, b);
    let (pairs, a, b) = (&pairs[2 * done..], &mut a[done..], &mut b[done..]);
    let mut done = 0;
    if N == 3 {
        let (groups, _) = pairs.as_flattened().as_chunks::<{ 6 * GROUP }>();
        let (a, _) = a.as_flattened_mut().as_chunks_mut::<{ 3 * GROUP }>();
        let (b, _) = b.as_flattened_mut().as_chunks_mut::<{ 3 * GROUP }>();
        for ((group, a), b) in groups.iter().zip(a).zip(b) {
            for pair in 0..GROUP {
                move_triple(group, 6 * pair, a, 3 * pair);
                move_triple(group, 6 * pair + 3, b, 3 * pair);
            }
        }
        done = groups.len() * GROUP;
    }
    let (rest, _) = pairs[2 * done..].as_chunks::<2>();
    for ((pair, a), b) in rest.iter().zip(&mut a[done..]).zip(&mut b[done..]) {
        *a = pair[0];
        *b = pair[1];
    }
}

/// Merges two planes into the pairs of a stored row.
pub(super) fn merge<const N: usize>(arch: Arch, a: &[[i32; N]], b: &[[i32; N]], pairs: &mut [[i32; N]]) {
    let done = merge_registers(arch, a, b, pairs);
    let (a, b, pairs) = (&a[done..], &b[done..], &mut pairs[2 * done..]);
    let mut done = 0;
    if N == 3 {
        let (groups, _) = pairs.as_flattened_mut().as_chunks_mut::<{ 6 * GROUP }>();
        let (a, _) = a.as_flattened().as_chunks::<{ 3 * GROUP }>();
        let (b, _) = b.as_flattened().as_chunks::<{ 3 * GROUP }>();
        done = groups.len() * GROUP;
        for ((group, a), b) in groups.iter_mut().zip(a).zip(b) {
            for pair in 0..GROUP {
                move_triple(a, 3 * pair, group, 6 * pair);
                move_triple(b, 3 * pair, group, 6 * pair + 3);
            }
        }
    }
    let (rest, _) = pairs[2 * done..].as_chunks_mut::<2>();
    for ((pair, a), b) in rest.iter_mut().zip(&a[done..]).zip(&b[done..]) {
        *pair = [*a, *b];
    }
}

/// [`split`] of as many pairs as fill whole registers; says how many that are.
#[inline(always)]
fn split_registers<const N: usize>(
    arch: Arch,
    pairs: &[[i32; N]],
    a: &mut [[i32; N]],
    b: &mut [[i32; N]],
) -> usize {
    match arch {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(v4) if N == 3 => {
            avx512::split(v4, pairs.as_flattened(), a.as_flattened_mut(), b.as_flattened_mut())
        }
        _ => {
            let _ = (a, b, pairs);
            0
        }
    }
}

/// [`merge`] of as many pairs as fill whole registers; says how many that are.
#[inline(always)]
fn merge_registers<const N: usize>(
    arch: Arch,
    a: &[[i32; N]],
    b: &[[i32; N]],
    pairs: &mut [[i32; N]],
) -> usize {
    match arch {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(v4) if N == 3 => {
            avx512::merge(v4, a.as_flattened(), b.as_flattened(), pairs.as_flattened_mut())
        }
        _ => {
            let _ = (a, b, pairs);
            0
        }
    }
}

/// Moves three values, and one more where both arrays have it.
#[inline(always)]
fn move_triple<const A: usize, const B: usize>(from: &[i32; A], at: usize, to: &mut [i32; B], place: usize) {
    if at + 4 <= A && place + 4 <= B {
        let four: [i32; 4] = from[at..at + 4].try_into().expect("of that length");
        to[place..place + 4].copy_from_slice(&in_one_register(four));
    } else {
        to[place..place + 3].copy_from_slice(&from[at..at + 3]);
    }
}

/// The same four values, as one value for the compiler, which would split the move to leave out what is overwritten.
#[inline(always)]
fn in_one_register(four: [i32; 4]) -> [i32; 4] {
    #[cfg(target_arch = "x86_64")]
    let four = pulp::cast(pulp::cast::<_, std::arch::x86_64::__m128i>(four));
    four
}
