//! Where the constant stencil serves: no extraordinary vertex, boundary or sharp edge near by, and a level fine enough
//! that neighbourhoods do not wrap around.
//!
//! An odd vertex has the constant weights unless something irregular lies in its disc `N_k`, and it updates even
//! vertices up to `k` edges from its edge's ends: so an even vertex is regular beyond `2k + 1` edges. Seen from one
//! base face, the regular vertices of a row are one run.

use super::Wavelet;
use crate::hierarchy::{Layout, Site};
use std::ops::Range;

/// Even vertices within so many edges of something irregular are irregular themselves.
pub(super) fn margin(k: u8) -> u32 {
    2 * u32::from(k) + 1
}

/// Whether a level is too coarse for the constant stencil anywhere.
pub(super) fn is_coarse(layout: &Layout, wavelet: Wavelet) -> bool {
    matches!(wavelet, Wavelet::Disc(k) if layout.level().0 < 2 + k)
}

/// Whether the constant stencil serves an even vertex.
pub(super) fn is_regular(layout: &Layout, site: Site, wavelet: Wavelet) -> bool {
    let (face, [_, i, r]) = layout.chart(site);
    regular_run(layout, wavelet, face, r).contains(&i)
}

/// The regular even vertices of row `r` of a face's whole grid, borders included.
pub(super) fn regular_run(layout: &Layout, wavelet: Wavelet, face: u32, r: u32) -> Range<u32> {
    let last = layout.segments() - r;
    let Wavelet::Disc(k) = wavelet else { return 0..last + 1 };
    if is_coarse(layout, wavelet) {
        return 0..0;
    }
    let (base, margin) = (layout.base(), margin(k));
    let corner = base.faces()[face as usize].map(|v| !base.is_regular(v));
    let edge = base.face_edges(face).map(|e| base.is_boundary_edge(e) || base.is_sharp(e));
    if (edge[0] && r <= margin) || (corner[2] && last <= margin) {
        return 0..0;
    }
    let mut from = if edge[2] { margin + 1 } else { 0 };
    if corner[0] && r <= margin {
        from = from.max(margin + 1 - r);
    }
    let mut to = if edge[1] { last.saturating_sub(margin) } else { last + 1 };
    if corner[1] {
        to = to.min(layout.segments() - margin);
    }
    if from < to { from..to } else { 0..0 }
}

/// The irregular even vertices of a level. Cost: their number, the rows and the base mesh.
pub(super) fn irregular_sites(layout: &Layout, wavelet: Wavelet) -> Vec<Site> {
    if wavelet == Wavelet::Lazy {
        return Vec::new();
    }
    let n = layout.segments();
    let base = layout.base();
    let mut sites: Vec<Site> = (0..base.vertex_count()).map(Site::Base).collect();
    sites.retain(|&site| !is_regular(layout, site, wavelet));
    let irregular = |edge: u32, t: u32| !is_regular(layout, Site::Edge { edge, t }, wavelet);
    for edge in 0..base.edges().len() as u32 {
        // From either end up to the first regular vertex.
        let from_low = (1..n).take_while(|&t| irregular(edge, t)).count() as u32;
        let from_high = (from_low + 1..n).rev().take_while(|&t| irregular(edge, t)).count() as u32;
        sites.extend((1..=from_low).chain(n - from_high..n).map(|t| Site::Edge { edge, t }));
    }
    for face in 0..base.faces().len() as u32 {
        for r in 1..n.saturating_sub(1) {
            let (last, run) = (n - r - 1, regular_run(layout, wavelet, face, r));
            let (before, after) =
                if run.is_empty() { (1..last + 1, 0..0) } else { (1..run.start, run.end..last + 1) };
            sites.extend(before.chain(after).map(|i| Site::Face { face, i, r }));
        }
    }
    sites
}
