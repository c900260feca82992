//! Splitting rows of the fine grid into two planes and merging them again.
//!
//! Row `ρ` of a face's interior is stored from `i = 1`: plane `B` (odd `i`) at 0, then `A` and `B` by turns, so the pair
//! of column `I ≥ 1` stands at `2I − 1` and `2I`.
//!
//! Three channels, the usual case, are moved four values at a time, the fourth overwritten by the next move: a load and
//! a store a vertex.

/// Pairs that are moved together.
const GROUP: usize = 8;

/// Splits the pairs of a stored row into planes.
pub(super) fn split<const N: usize>(pairs: &[[i32; N]], a: &mut [[i32; N]], b: &mut [[i32; N]]) {
    let done = if N == 3 {
        let (groups, _) = pairs.as_flattened().as_chunks::<{ 6 * GROUP }>();
        let (a, _) = a.as_flattened_mut().as_chunks_mut::<{ 3 * GROUP }>();
        let (b, _) = b.as_flattened_mut().as_chunks_mut::<{ 3 * GROUP }>();
        for ((group, a), b) in groups.iter().zip(a).zip(b) {
            for pair in 0..GROUP {
                move_triple(group, 6 * pair, a, 3 * pair);
                move_triple(group, 6 * pair + 3, b, 3 * pair);
            }
        }
        groups.len() * GROUP
    } else {
        0
    };
    let (rest, _) = pairs[2 * done..].as_chunks::<2>();
    for ((pair, a), b) in rest.iter().zip(&mut a[done..]).zip(&mut b[done..]) {
        *a = pair[0];
        *b = pair[1];
    }
}

/// Merges two planes into the pairs of a stored row.
pub(super) fn merge<const N: usize>(a: &[[i32; N]], b: &[[i32; N]], pairs: &mut [[i32; N]]) {
    let done = if N == 3 {
        let (a, _) = a.as_flattened().as_chunks::<{ 3 * GROUP }>();
        let (b, _) = b.as_flattened().as_chunks::<{ 3 * GROUP }>();
        let (groups, _) = pairs.as_flattened_mut().as_chunks_mut::<{ 6 * GROUP }>();
        for ((group, a), b) in groups.iter_mut().zip(a).zip(b) {
            for pair in 0..GROUP {
                move_triple(a, 3 * pair, group, 6 * pair);
                move_triple(b, 3 * pair, group, 6 * pair + 3);
            }
        }
        a.len() * GROUP
    } else {
        0
    };
    let (rest, _) = pairs[2 * done..].as_chunks_mut::<2>();
    for ((pair, a), b) in rest.iter_mut().zip(&a[done..]).zip(&b[done..]) {
        *pair = [*a, *b];
    }
}

/// Moves three values, and one more where both arrays have it.
#[inline(always)]
fn move_triple<const A: usize, const B: usize>(from: &[i32; A], at: usize, to: &mut [i32; B], place: usize) {
    let count = if at + 4 <= A && place + 4 <= B { 4 } else { 3 };
    to[place..place + count].copy_from_slice(&from[at..at + count]);
}
