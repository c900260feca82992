//! About how many vertices coefficients move, told from their number before anything moves.
//!
//! Exact for hexagons of a regular mesh. Where coefficients are scattered more vertices move than is told, where they lie round
//! extraordinary vertices some more or fewer.

use crate::hierarchy::Level;
use crate::surface::Surface;

/// About how many vertices of a level `seen` move with so many hats of a coarser level, if they lie together: `n + 2 √n`
/// hats' worth, times four to the levels between.
pub(crate) fn of_hats(surface: &Surface, level: Level, hats: u64, seen: Level) -> u64 {
    refined(surface, level, hats + 2 * hats.isqrt(), seen)
}

/// About how many vertices of a level `seen` move with so many wavelets of a coarser level, if they lie together: within discs of
/// radius `√n / 3` of even vertices, and up to `k + 1` edges farther.
pub(crate) fn of_wavelets(surface: &Surface, level: Level, wavelets: u64, seen: Level) -> u64 {
    let rings = surface.form().wavelet.disc_radius().map_or(1, |k| u64::from(k) + 1);
    let across = wavelets.isqrt() + 1 + 3 * rings;
    refined(surface, level.finer(), 4 * across * across / 3, seen)
}

/// So many vertices' worth of a level, at a finer one; no more than that has.
fn refined(surface: &Surface, level: Level, count: u64, seen: Level) -> u64 {
    let all = u64::from(surface.hierarchy().layout(seen).len());
    count.saturating_mul(4_u64.saturating_pow(u32::from(seen.0 - level.0))).min(all)
}
