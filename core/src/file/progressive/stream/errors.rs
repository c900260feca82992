//! How far the surface that a reader has at some place of the stream is from the whole: measured on the surfaces.
//!
//! From points of the triangles of either surface to the other, by going to ever nearer triangles from those with the same address,
//! both root mean squares over the area, of which the larger counts. Levels that have not begun are looked at some levels
//! deep: what finer ones would do is little beside that.

use super::State;
use crate::hierarchy::{Layout, Level, Site, Slot, Subtriangle};
use crate::mesh::closest_on_triangle;
use crate::surface::{Surface, Vector};
use glam::DVec3;
use rayon::iter::Either;
use rayon::prelude::*;

/// More vertices than these are many.
const MANY: usize = 1 << 17;

/// Points that are measured, at most, on each surface: the result is some hundredths off. Of large surfaces fewer, since measuring
/// takes as long as writing does.
fn most_samples(whole: &Surface) -> u32 {
    if whole.scaling(whole.finest()).len() > MANY { 1024 } else { 2048 }
}
/// Levels beyond those that have begun that are looked at.
const DEEPER: usize = 2;
/// The least that is stated where something is missing, in steps.
const LEAST: f64 = 1.0 / 1024.0;

/// What the whole surface is on the level that was measured last.
pub(super) struct Ruler<'a> {
    whole: &'a Surface,
    level: Level,
    /// Of the triangles that are measured.
    corners: Vec<[u32; 3]>,
    /// Its positions there; empty on the finest level, where they are the surface's own.
    sampled: Vec<Vector>,
}

impl<'a> Ruler<'a> {
    pub(super) fn new(whole: &'a Surface) -> Self {
        let mut ruler = Self { whole, level: Level::BASE, corners: Vec::new(), sampled: Vec::new() };
        ruler.turn_to(Level::BASE);
        ruler
    }

    fn turn_to(&mut self, level: Level) {
        let (hierarchy, finest) = (self.whole.hierarchy(), self.whole.finest());
        let (layout, count) = (hierarchy.layout(level), hierarchy.face_count(level) as u32);
        let most = most_samples(self.whole);
        let chosen = |sample: u32| {
            let index = if count <= most { sample } else { spread(sample, count) };
            let triangle = Subtriangle::numbered(index as usize, layout.segments());
            let n = layout.segments();
            triangle.corners().map(|[i, r]| layout.slot(layout.site_at(triangle.face, [n - i - r, i, r])).0)
        };
        let exact = self.whole.scaling(finest);
        let at_finest = |slot: u32| exact[hierarchy.refine_slot(level, finest, Slot(slot)).index()];
        self.corners = (0..count.min(most)).map(chosen).collect();
        let sampled = if level == finest { 0 } else { layout.len() };
        self.sampled = (0..sampled).into_par_iter().map(at_finest).collect();
        self.level = level;
    }

    /// The distance in steps. Cost: a synthesis of the levels that have begun and [`DEEPER`] more, and some thousand walks. The
    /// same for any number of threads.
    pub(super) fn measure(&mut self, state: &State) -> f64 {
        let begun = state.levels.iter().rposition(|details| details.begun).map_or(0, |j| j + 1);
        let level = Level((begun + DEEPER).min(self.whole.finest().index()) as u8);
        if level != self.level {
            self.turn_to(level);
        }
        let known = state.synthesise(level.index());
        let finest = self.whole.finest();
        let exact = if level == finest { self.whole.scaling(finest) } else { &self.sampled };
        let layout = state.hierarchy.layout(level);
        let measured = |(sample, corners): (usize, &[u32; 3])| -> [f64; 3] {
            // Three points that give the mean of a quadratic function; each triangle has one of them.
            let start = corners[sample % 3];
            let site = layout.site(Slot(start));
            let corners_of = |positions: &[Vector]| {
                corners.map(|slot| DVec3::from_array(positions[slot as usize].map(f64::from)))
            };
            let point = |[a, b, c]: [DVec3; 3], at: DVec3| (a + b + c + 3.0 * at) / 6.0;
            let (ours, theirs) = (corners_of(exact), corners_of(&known));
            let at = |triangle: [DVec3; 3]| point(triangle, triangle[sample % 3]);
            let squared = |positions: &[Vector], point| squared_distance(layout, positions, site, point);
            let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length();
            // Points count by the area around them; by something where there is none at all.
            let weight = area(ours).max(f64::MIN_POSITIVE);
            [weight, weight * squared(exact, at(theirs)), weight * squared(&known, at(ours))]
        };
        let samples: Vec<[f64; 3]> =
            self.corners.par_iter().enumerate().with_min_len(128).map(measured).collect();
        let sum = |c: usize| samples.iter().map(|sample| sample[c]).sum::<f64>();
        (sum(1).max(sum(2)) / sum(0)).sqrt().max(LEAST)
    }
}

/// The squared distance of a point from the triangles near a vertex: from those at it on to those at the corners of the nearest, until
/// none is nearer.
fn squared_distance(layout: &Layout, positions: &[Vector], start: Site, p: DVec3) -> f64 {
    let sites = |triangle: Subtriangle| {
        triangle.corners().map(|[i, r]| layout.site_at(triangle.face, [layout.segments() - i - r, i, r]))
    };
    // The distance, where it may be below what there is.
    let squared = |triangle: Subtriangle, best: f64| {
        let place = |site: Site| DVec3::from_array(positions[layout.slot(site).index()].map(f64::from));
        let corners = sites(triangle).map(place);
        if beyond(p, &corners, best) { best } else { closest_on_triangle(p, &corners).1 }
    };
    let mut best: (f64, Option<Subtriangle>) = (f64::INFINITY, None);
    let (mut corners, mut looked_at) = (vec![start], Vec::with_capacity(32));
    loop {
        let before = best.0;
        for &site in &corners {
            let new = match site {
                // Most vertices lie inside a face.
                Site::Face { face, i, r } => Either::Left(Subtriangle::around(face, i, r, layout.segments())),
                _ => Either::Right(Subtriangle::incident(layout, site).into_iter()),
            };
            for triangle in new {
                if looked_at.contains(&triangle) {
                    continue;
                }
                looked_at.push(triangle);
                let found = squared(triangle, best.0);
                if found < best.0 {
                    best = (found, Some(triangle));
                }
            }
        }
        match best {
            (found, Some(nearest)) if found < before => corners = sites(nearest).to_vec(),
            _ => return best.0,
        }
    }
}

/// Whether a triangle's box is farther away than a squared distance, by more than rounding can make.
fn beyond(p: DVec3, [a, b, c]: &[DVec3; 3], squared: f64) -> bool {
    let off = (a.min(*b).min(*c) - p).max(p - a.max(*b).max(*c)).max(DVec3::ZERO);
    off.length_squared() > squared * (1.0 + 1e-6) + 1e-6
}

/// Numbers below a count, evenly spread by the golden ratio.
fn spread(sample: u32, count: u32) -> u32 {
    let part = sample.wrapping_mul(0x9e37_79b9);
    ((u64::from(part) * u64::from(count)) >> 32) as u32
}
