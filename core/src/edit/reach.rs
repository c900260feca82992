//! What a brush reaches: the vertices of a level round a point of the surface, with their weights.

use super::vocabulary::Falloff;
use crate::hierarchy::{Address, Layout, Level, Site, Slot};
use crate::surface::{Marks, Surface, Vector};

/// A vertex of a level under the brush.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Touched {
    pub(super) slot: Slot,
    pub(super) site: Site,
    /// From 0 to 1; above 1 where few coefficients share the pull, so that the touched point itself moves by 1.
    pub(super) weight: f64,
    /// The place in the region of the vertex from which it was reached; `usize::MAX` for the first.
    pub(super) from: usize,
}

/// A position or vector in steps.
pub(super) type Steps = [f64; 3];

pub(super) fn steps(v: Vector) -> Steps {
    v.map(f64::from)
}

pub(super) fn minus(a: Steps, b: Steps) -> Steps {
    std::array::from_fn(|c| a[c] - b[c])
}

pub(super) fn plus(a: Steps, b: Steps) -> Steps {
    std::array::from_fn(|c| a[c] + b[c])
}

pub(super) fn times(a: Steps, by: f64) -> Steps {
    a.map(|x| x * by)
}

pub(super) fn dot(a: Steps, b: Steps) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: Steps, b: Steps) -> Steps {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn length(a: Steps) -> f64 {
    dot(a, a).sqrt()
}

/// The vector at length 1; zero stays zero.
pub(super) fn unit(a: Steps) -> Steps {
    let length = length(a);
    if length > 0.0 { times(a, 1.0 / length) } else { a }
}

/// Where an address lies on `S^j`, in steps.
pub(super) fn point_on(surface: &Surface, level: Level, address: Address) -> Steps {
    let layout = surface.hierarchy().layout(level);
    let positions = surface.scaling(level);
    address.corners(layout).into_iter().fold([0.0; 3], |sum, (site, weight)| {
        plus(sum, times(steps(positions[layout.slot(site).index()]), weight))
    })
}

/// The vertices of `M^j` within `radius` steps of the point of `S^j` at an address, connected within the ball. Where the
/// ball is smaller than the level's triangle there, its corners share the touch by their hat functions. Cost: the
/// vertices.
pub(super) fn touched(
    surface: &Surface,
    level: Level,
    address: Address,
    radius: f64,
    falloff: Falloff,
    marks: &mut Marks,
) -> Vec<Touched> {
    let layout = surface.hierarchy().layout(level);
    let positions = surface.scaling(level);
    let corners = address.corners(layout);
    let at = |site: Site| steps(positions[layout.slot(site).index()]);
    let sides = [(0, 1), (1, 2), (2, 0)].map(|(a, b)| length(minus(at(corners[a].0), at(corners[b].0))));
    let spacing = sides.into_iter().fold(0.0, f64::max);
    let centre = point_on(surface, level, address);
    let mut region: Vec<Touched> = Vec::new();
    if radius > spacing {
        marks.reset(layout.len());
        let inverse = 1.0 / (radius * radius);
        let mut reach = |region: &mut Vec<Touched>, site: Site, from: usize| {
            let slot = layout.slot(site);
            if marks.insert(slot.0, site) {
                let d = minus(steps(positions[slot.index()]), centre);
                let squared = dot(d, d) * inverse;
                if squared <= 1.0 {
                    let weight = falloff.weight(squared.sqrt());
                    region.push(Touched { slot, site, weight, from });
                }
            }
        };
        corners.iter().for_each(|&(site, _)| reach(&mut region, site, usize::MAX));
        let mut next = 0;
        while next < region.len() {
            let site = region[next].site;
            layout.for_each_neighbour(site, |neighbour| reach(&mut region, neighbour, next));
            next += 1;
        }
    }
    if region.is_empty() {
        let squares: f64 = corners.iter().fold(0.0, |sum, (_, w)| sum + w * w);
        region.extend(corners.iter().filter(|(_, w)| *w > 0.0).map(|&(site, w)| Touched {
            slot: layout.slot(site),
            site,
            weight: w / squares,
            from: usize::MAX,
        }));
    }
    region
}

/// How far a brush reaches at a place of the surface, in steps: its radius, or where that is smaller than the level's
/// triangle there, the triangle's longest side, since its corners share the touch.
pub fn true_reach(surface: &Surface, level: Level, address: Address, radius: f64) -> f64 {
    let layout = surface.hierarchy().layout(level);
    let at = |site: Site| steps(surface.scaling(level)[layout.slot(site).index()]);
    let corners = address.corners(layout).map(|(site, _)| at(site));
    let sides = [(0, 1), (1, 2), (2, 0)].map(|(a, b)| length(minus(corners[a], corners[b])));
    sides.into_iter().fold(radius, f64::max)
}

/// The area-weighted normal of `S^j` at a vertex, not of length 1.
pub(super) fn normal_at(layout: &Layout, positions: &[Vector], site: Site) -> Steps {
    let at = |site: Site| positions[layout.slot(site).index()];
    let from = at(site);
    let edge = |site: Site| {
        let to = at(site);
        std::array::from_fn::<i64, 3, _>(|c| i64::from(to[c]) - i64::from(from[c]))
    };
    let mut sum = [0.0; 3];
    let mut add = |a: [i64; 3], b: [i64; 3]| {
        let normal = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
        sum = plus(sum, normal.map(|x| x as f64));
    };
    if let Site::Face { face, i, r } = site
        && i > 1
        && r > 1
        && i + r + 1 < layout.segments()
    {
        let around = crate::hierarchy::DIRECTIONS.map(|[_, di, dr]| {
            edge(Site::Face { face, i: i.wrapping_add_signed(di), r: r.wrapping_add_signed(dr) })
        });
        (0..6).for_each(|k| add(around[k], around[(k + 1) % 6]));
        return sum;
    }
    let ring = layout.ring(site);
    let around: Vec<[i64; 3]> = ring.around.iter().map(|&site| edge(site)).collect();
    around.windows(2).for_each(|pair| add(pair[0], pair[1]));
    if ring.closed {
        add(around[around.len() - 1], around[0]);
    }
    sum
}
