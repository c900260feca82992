//! Copying detail: what is finer than a level, taken from one place of the surface to another.
//!
//! The detail of a place is the way from `M^j` to `M^J` there. The brush lays a patch of the surface round the source
//! onto the one it touches: version 1 shifts every touched vertex and looks for the nearest place of the whole surface;
//! version 2 lays the two patches onto each other by their normals, finds the source once and walks from it, so that
//! neighbours find neighbours, at a hundredth of the cost.

use super::brushes::{turn_normal, turned};
use super::reach::{Steps, Touched, minus, plus, point_on, steps};
use crate::hierarchy::{Address, Layout, Level, Site};
use crate::surface::Surface;

/// What every vertex under a dab goes by to have the detail, finer than `level`, of the place `offset` away: of the
/// finest level, at weight 1. `at` is the touched place.
pub(super) fn copied(
    surface: &Surface,
    level: Level,
    version: u32,
    region: &[Touched],
    (at, offset): (Address, Steps),
) -> Vec<Steps> {
    if version == 1 {
        return region.iter().map(|touched| from_nearest(surface, level, touched, offset)).collect();
    }
    let finest = surface.finest();
    let (layout, positions) = (surface.hierarchy().layout(finest), surface.scaling(finest));
    let here = point_on(surface, finest, at);
    let source = surface.nearest(plus(here, offset));
    let onto = turn_normal(surface, level, [source.address, at]);
    let back = transposed(&onto);
    let mut found: Vec<Site> = Vec::with_capacity(region.len());
    let first = heaviest(source.address.corners(layout));
    region
        .iter()
        .enumerate()
        .map(|(k, touched)| {
            let position = steps(positions[touched.slot.index()]);
            let wanted = plus(source.point, turned(&back, minus(position, here)));
            let start = if touched.from < k { found[touched.from] } else { first };
            let (site, place) = surface.walk(start, wanted);
            found.push(site);
            let there = minus(place.point, point_on(surface, level, place.address));
            minus(turned(&onto, there), own_detail(surface, level, touched, position))
        })
        .collect()
}

fn from_nearest(surface: &Surface, level: Level, touched: &Touched, offset: Steps) -> Steps {
    let finest = surface.finest();
    let layout = surface.hierarchy().layout(finest);
    let position = steps(surface.scaling(finest)[touched.slot.index()]);
    let source = surface.nearest(plus(position, offset));
    let there = minus(source.point, point_on(surface, level, source.address));
    let rotation = turn_normal(surface, level, [source.address, address_of(layout, touched.site)]);
    minus(turned(&rotation, there), own_detail(surface, level, touched, position))
}

/// The way from `S^j` to a vertex of the finest level.
fn own_detail(surface: &Surface, level: Level, touched: &Touched, position: Steps) -> Steps {
    let layout = surface.hierarchy().layout(surface.finest());
    minus(position, point_on(surface, level, address_of(layout, touched.site)))
}

fn address_of(layout: &Layout, site: Site) -> Address {
    let (face, b) = layout.chart(site);
    let n = f64::from(layout.segments());
    Address { face, at: [f64::from(b[1]) / n, f64::from(b[2]) / n] }
}

fn heaviest(corners: [(Site, f64); 3]) -> Site {
    let first = corners[0];
    corners.into_iter().fold(first, |most, c| if c.1 > most.1 { c } else { most }).0
}

fn transposed(m: &[Steps; 3]) -> [Steps; 3] {
    std::array::from_fn(|row| std::array::from_fn(|column| m[column][row]))
}
