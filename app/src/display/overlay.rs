//! Overlays that explain a coefficient: the tint of its influence and the outline of its support.

use bozzetto_core::edit::Kind;
use bozzetto_core::hierarchy::{Layout, Level, Odd, PublicId, Slot};
use bozzetto_core::surface::Surface;
use rustc_hash::FxHashSet;

/// Where and how strongly one coefficient acts on the shown level.
#[derive(Debug, Clone, PartialEq)]
pub struct Influence {
    /// Slots of the shown level with the basis function's value there; the largest magnitude is about 1.
    pub values: Vec<(Slot, f64)>,
}

impl Influence {
    /// The influence of the coefficient with a public id, if it reaches the shown level. Cost: its support.
    pub fn of(surface: &Surface, kind: Kind, level: Level, vertex: PublicId, shown: Level) -> Option<Self> {
        let layout = surface.hierarchy().layout(level);
        let values = match kind {
            Kind::Scaling if shown >= level && vertex.0 < layout.len() => {
                surface.scaling_function(level, layout.slot(layout.site_of(vertex)), shown)
            }
            Kind::Wavelet
                if shown > level && (layout.len()..layout.len() + layout.odd_len()).contains(&vertex.0) =>
            {
                surface.wavelet_function(level, Odd(vertex.0 - layout.len()), shown)
            }
            _ => return None,
        };
        Some(Self { values })
    }
}

/// The colour where a basis function is positive.
const POSITIVE: [u8; 3] = [236, 124, 48];
/// The colour where it is negative.
const NEGATIVE: [u8; 3] = [58, 128, 214];

/// The tints of an influence by slot: signed colours, strength by magnitude. Small magnitudes are raised so that a
/// wavelet's side lobes show.
pub fn tints(influence: &Influence) -> Vec<(Slot, [u8; 4])> {
    let largest = influence.values.iter().map(|(_, x)| x.abs()).fold(f64::MIN_POSITIVE, f64::max);
    influence
        .values
        .iter()
        .map(|&(slot, x)| {
            let [r, g, b] = if x >= 0.0 { POSITIVE } else { NEGATIVE };
            let strength = (x.abs() / largest).sqrt() * 200.0;
            (slot, [r, g, b, strength as u8])
        })
        .collect()
}

/// The outline of a support: the shown edges, as pairs of slots, around the region where the influence is not zero.
/// Connectivity alone, so it holds however the surface moves. Cost: the support.
pub fn support_border(layout: &Layout, influence: &Influence) -> Vec<[u32; 2]> {
    let inside: FxHashSet<u32> =
        influence.values.iter().filter(|(_, x)| *x != 0.0).map(|(s, _)| s.0).collect();
    let around = |slot: u32| {
        let ring = layout.ring(layout.site(Slot(slot)));
        let slots: Vec<u32> = ring.around.iter().map(|&s| layout.slot(s).0).collect();
        (slots, ring.closed)
    };
    let mut border: Vec<u32> =
        inside.iter().flat_map(|&slot| around(slot).0).filter(|slot| !inside.contains(slot)).collect();
    border.sort_unstable();
    border.dedup();
    let on_border: FxHashSet<u32> = border.iter().copied().collect();
    let mut edges = Vec::new();
    for &slot in &border {
        let (ring, closed) = around(slot);
        for (k, &next) in ring.iter().enumerate() {
            // An edge of the outline has the support on one side and lies on the border itself.
            let after = ring.get(k + 1).or(ring.first().filter(|_| closed));
            let before = k.checked_sub(1).map_or(ring.last().filter(|_| closed), |k| ring.get(k));
            let touches = [before, after].into_iter().flatten().any(|s| inside.contains(s));
            if slot < next && touches && on_border.contains(&next) {
                edges.push([slot, next]);
            }
        }
    }
    edges
}
