//! The surface that a stream, or a part of it, holds.

use super::progressive::{Decoded, Held};
use crate::hierarchy::Hierarchy;
use crate::memory::Buffer;
use crate::surface::{Form, LIMIT, Surface, Vector, within_limit};
use crate::wavelet::Filters;
use rayon::prelude::*;

/// The surface; `None` if all of it is known and it reaches beyond the limit. What is known in part may overshoot, and is
/// moved to the limit. `O(n_J)`.
pub(super) fn surface_of(
    hierarchy: Hierarchy,
    filters: Filters,
    form: Form,
    decoded: Decoded,
) -> Option<Surface> {
    let within = |all: &[Vector]| all.par_iter().all(|v| v.iter().all(|&x| within_limit(x)));
    let clamp = |all: &mut Buffer<Vector>| {
        all.par_iter_mut().for_each(|v| *v = v.map(|x| x.clamp(-LIMIT, LIMIT)));
    };
    // Looked at before analysis or synthesis, whose sums are exact within the limit only.
    match decoded.held {
        Held::Coefficients(mut base, mut details) => {
            if !decoded.exact {
                clamp(&mut base);
                details.iter_mut().for_each(clamp);
            } else if !within(&base) || !details.iter().all(|d| within(d)) {
                return None;
            }
            Some(Surface::with_filters(hierarchy, filters, form, base, details))
        }
        Held::Finest(mut finest) => {
            if !decoded.exact {
                clamp(&mut finest);
            } else if !within(&finest) {
                return None;
            }
            let surface = Surface::finest_with_filters(hierarchy, filters, form, finest);
            if decoded.exact || surface.is_within_limit() {
                Some(surface)
            } else {
                Some(surface.with_coefficients_clamped())
            }
        }
    }
}
