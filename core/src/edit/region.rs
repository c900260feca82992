//! The neighbourhood of an edit: what lies within a radius and is connected to the edited vertex inside it.

use crate::hierarchy::{Layout, Level, Odd, Slot};
use crate::surface::{Surface, Vector};
use rustc_hash::FxHashSet;

/// Vertices of `M^j` within `radius` steps of one, straight through space, that can be reached without leaving the
/// ball; with their distance over the radius. The ball does not jump across fingers. Cost: the neighbourhood.
pub(super) fn neighbourhood_of_slot(
    surface: &Surface,
    level: Level,
    centre: Slot,
    radius: f64,
) -> Vec<(Slot, f64)> {
    let layout = surface.hierarchy().layout(level);
    let positions = surface.scaling(level);
    let from = positions[centre.index()];
    let mut seen = FxHashSet::from_iter([centre]);
    let mut region = vec![(centre, 0.0)];
    let mut at = 0;
    while at < region.len() {
        let site = layout.site(region[at].0);
        for neighbour in layout.ring_slots(site) {
            if !seen.insert(neighbour) {
                continue;
            }
            let t = distance(from, positions[neighbour.index()]) / radius;
            if t <= 1.0 {
                region.push((neighbour, t));
            }
        }
        at += 1;
    }
    region
}

/// The same for odd vertices of level j, by their places in `M^{j+1}`.
pub(super) fn neighbourhood_of_odd(
    surface: &Surface,
    level: Level,
    centre: Odd,
    radius: f64,
) -> Vec<(Odd, f64)> {
    let (coarse, fine) = (surface.hierarchy().layout(level), surface.hierarchy().layout(level.finer()));
    let slot = fine.slot(coarse.odd_site(centre));
    neighbourhood_of_slot(surface, level.finer(), slot, radius)
        .into_iter()
        .filter_map(|(slot, t)| {
            let site = fine.site(slot);
            Layout::coarsen(site).is_none().then(|| (coarse.odd_at(site), t))
        })
        .collect()
}

fn distance(a: Vector, b: Vector) -> f64 {
    let squared: f64 = (0..3)
        .map(|c| {
            let d = f64::from(a[c]) - f64::from(b[c]);
            d * d
        })
        .fold(0.0, |sum, d| sum + d);
    squared.sqrt()
}
