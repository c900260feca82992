//! Exact integer lifting: predict and update, forwards (analysis) and backwards (synthesis).
//!
//! Based on: Calderbank, Daubechies, Sweldens, Yeo, "Wavelet Transforms That Map Integers to Integers", ACHA 5,
//! 1998. The arithmetic below is part of the file format (docs/FORMAT.md, "Arithmetic") and never changes:
//!
//! ```text
//! predict   d_i  = c_i − ((c_u + c_w) >> 1)                  odd_i  = d_i + ((c_u + c_w) >> 1)
//! update    c_v += (Σ_i w_iv d_i + 2^19) >> 20               even_v = c_v − ((Σ_i w_iv d_i + 2^19) >> 20)
//! ```
//!
//! Sums are exact in i64, so their order does not matter; the last addition wraps to i32. This file is the plain
//! reference: whole levels, one vertex at a time, in parallel over vertices.

use super::Filters;
use super::weights::WEIGHT_BITS;
use crate::hierarchy::{Hierarchy, Layout, Level, Odd, Slot};
use rayon::prelude::*;

/// Vertices per parallel task; enough that a task outweighs its dispatch.
const TASK: usize = 2048;

/// `(c_u + c_w) >> 1` for each channel.
pub fn predicted<const N: usize>(u: [i32; N], w: [i32; N]) -> [i32; N] {
    std::array::from_fn(|c| ((i64::from(u[c]) + i64::from(w[c])) >> 1) as i32)
}

/// `(Σ + 2^19) >> 20` for each channel, wrapped to i32.
pub fn rounded<const N: usize>(sum: [i64; N]) -> [i32; N] {
    sum.map(|s| ((s + (1 << (WEIGHT_BITS - 1))) >> WEIGHT_BITS) as i32)
}

/// `a + b` for each channel, wrapping.
pub fn plus<const N: usize>(a: [i32; N], b: [i32; N]) -> [i32; N] {
    std::array::from_fn(|c| a[c].wrapping_add(b[c]))
}

/// `a − b` for each channel, wrapping.
pub fn minus<const N: usize>(a: [i32; N], b: [i32; N]) -> [i32; N] {
    std::array::from_fn(|c| a[c].wrapping_sub(b[c]))
}

/// The slots at level j + 1 of the two ends of the edge that an odd vertex of level j halves.
pub fn parent_slots(coarse: &Layout, fine: &Layout, odd: Odd) -> [Slot; 2] {
    coarse.parents(coarse.odd_site(odd)).map(|p| fine.slot(Layout::refine(p)))
}

/// One level of analysis: `c^{j+1}` to `d^j` and `c^j`. `O(n_{j+1})`.
pub fn analyse_level<const N: usize>(
    hierarchy: &Hierarchy,
    filters: &Filters,
    level: Level,
    finer: &[[i32; N]],
) -> (Vec<[i32; N]>, Vec<[i32; N]>) {
    let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
    let details: Vec<[i32; N]> = (0..coarse.odd_len())
        .into_par_iter()
        .with_min_len(TASK)
        .map(|i| {
            let [u, w] = parent_slots(coarse, fine, Odd(i));
            let own = fine.slot(coarse.odd_site(Odd(i)));
            minus(finer[own.index()], predicted(finer[u.index()], finer[w.index()]))
        })
        .collect();
    let coarser = (0..coarse.len())
        .into_par_iter()
        .with_min_len(TASK)
        .map(|v| {
            let site = coarse.site(Slot(v));
            let even = fine.slot(Layout::refine(site));
            plus(finer[even.index()], rounded(filters.gather(coarse, site, &details)))
        })
        .collect();
    (details, coarser)
}

/// One level of synthesis: `c^j` and `d^j` to `c^{j+1}`. `O(n_{j+1})`.
pub fn synthesise_level<const N: usize>(
    hierarchy: &Hierarchy,
    filters: &Filters,
    level: Level,
    coarser: &[[i32; N]],
    details: &[[i32; N]],
) -> Vec<[i32; N]> {
    let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
    let evens: Vec<[i32; N]> = (0..coarse.len())
        .into_par_iter()
        .with_min_len(TASK)
        .map(|v| minus(coarser[v as usize], rounded(filters.gather(coarse, coarse.site(Slot(v)), details))))
        .collect();
    (0..fine.len())
        .into_par_iter()
        .with_min_len(TASK)
        .map(|s| {
            let site = fine.site(Slot(s));
            match Layout::coarsen(site) {
                Some(even) => evens[coarse.slot(even).index()],
                None => {
                    let [u, w] = coarse.parents(site).map(|p| evens[coarse.slot(p).index()]);
                    plus(details[coarse.odd_at(site).index()], predicted(u, w))
                }
            }
        })
        .collect()
}
