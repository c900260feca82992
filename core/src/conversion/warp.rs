//! Sliding the vertices of one level over the domain, finer ones with them.
//!
//! The domain is the base mesh with every face equilateral, side `n = 2^J`; vertices of `M^J` are its lattice points.
//! A slide gives each vertex of `M^j` a way to go; between them it is linear, so a slide of less than a third of the
//! level's edges is one to one. Ways are plane vectors in the chart of a face (corner 0 at the origin, corner 1 on the
//! x axis); across an edge charts are unfolded, round a base vertex angles are scaled to a full turn.

use super::domain::{angle_in_fan, place_in_fan, width_in_fan};
use super::lattice::face_slots;
use crate::hierarchy::{Hierarchy, Layout, Level, Site, Slot};
use glam::DVec2;
use std::f64::consts::{FRAC_PI_3, FRAC_PI_6, PI, TAU};

/// A point of the lattice of a face, maybe between vertices: three vertices and their weights.
pub(super) type Cell = [([i32; 3], f64); 3];

/// A level of the hierarchy as what moves, and the finest as what is moved.
pub(super) struct Warp<'h> {
    hierarchy: &'h Hierarchy,
    coarse: &'h Layout,
    /// Segments of the finest level in one of the coarse level.
    pub(super) stride: u32,
    /// For each base face its coarse vertices, row by row.
    slots: Vec<u32>,
    per_face: usize,
}

impl<'h> Warp<'h> {
    pub(super) fn new(hierarchy: &'h Hierarchy, level: Level) -> Self {
        let coarse = hierarchy.layout(level);
        let n = coarse.segments();
        let per_face = ((n + 1) * (n + 2) / 2) as usize;
        let slots = face_slots(coarse);
        let stride = hierarchy.layout(hierarchy.finest()).segments() / n;
        Self { hierarchy, coarse, stride, slots, per_face }
    }

    /// The coarse vertices of a face, row by row.
    pub(super) fn face_slots(&self, face: usize) -> &[u32] {
        &self.slots[face * self.per_face..(face + 1) * self.per_face]
    }

    /// Coarse vertices of a face.
    pub(super) fn per_face(&self) -> usize {
        self.per_face
    }

    /// Vertices of the coarse level.
    pub(super) fn len(&self) -> usize {
        self.coarse.len() as usize
    }

    /// Where a vertex of a face comes among [`Warp::face_slots`].
    pub(super) fn index(&self, b: [i32; 3]) -> usize {
        row_index(self.coarse.segments() as i32, b)
    }

    /// Coarse vertices round a vertex of the finest level, and its weights.
    pub(super) fn cell(&self, b: [u32; 3]) -> Cell {
        let scale = 1.0 / f64::from(self.stride);
        cell(b.map(|x| f64::from(x) * scale))
    }

    /// A way in a vertex's own frame, in the chart of a face it belongs to.
    pub(super) fn in_chart(&self, slot: u32, face: u32, way: DVec2) -> DVec2 {
        match self.coarse.site(Slot(slot)) {
            Site::Face { .. } => way,
            Site::Edge { edge, .. } => DVec2::from_angle(self.edge_angle(edge, face)).rotate(way),
            Site::Base(v) => {
                let (middle, corner, width) = self.sector(v, face);
                let off = self.wrap(v, angle(way) - middle) * (FRAC_PI_3 / width);
                turned(way.length(), corner + FRAC_PI_6 + off)
            }
        }
    }

    /// The other way round: from the chart of a face into the vertex's own frame.
    pub(super) fn in_frame(&self, slot: u32, face: u32, way: DVec2) -> DVec2 {
        match self.coarse.site(Slot(slot)) {
            Site::Face { .. } => way,
            Site::Edge { edge, .. } => DVec2::from_angle(-self.edge_angle(edge, face)).rotate(way),
            Site::Base(v) => {
                let (middle, corner, width) = self.sector(v, face);
                let off = wrapped(angle(way) - corner - FRAC_PI_6) * (width / FRAC_PI_3);
                turned(way.length(), middle + off)
            }
        }
    }

    /// The level that slides.
    pub(super) fn layout(&self) -> &Layout {
        self.coarse
    }

    /// The face of a base vertex that a way in its frame points into, its corner, and the way in its chart.
    pub(super) fn face_ahead(&self, v: u32, way: DVec2) -> (u32, u8, DVec2) {
        let fan = self.hierarchy.base().fan(v);
        let turn = angle(way);
        let turn = if turn < 0.0 { turn + TAU } else { turn };
        let (at, _) = place_in_fan(self.hierarchy.base(), v, turn);
        let (face, corner) = fan.corners[at];
        (face, corner, self.in_chart(self.coarse.slot(Site::Base(v)).0, face, way))
    }

    /// The direction of a base edge at one of its ends, in that vertex's frame.
    pub(super) fn along(&self, v: u32, edge: u32) -> DVec2 {
        let base = self.hierarchy.base();
        let side = base.sides(edge)[0].expect("an edge has a face");
        let leaves = base.faces()[side.face as usize][usize::from(side.k)] == v;
        let (middle, _, width) = self.sector(v, side.face);
        turned(1.0, if leaves { middle - 0.5 * width } else { middle + 0.5 * width })
    }

    fn edge_angle(&self, edge: u32, face: u32) -> f64 {
        let base = self.hierarchy.base();
        let side = base.sides(edge).into_iter().flatten().find(|s| s.face == face).expect("a side");
        let from_low = base.edges()[edge as usize][0] == base.faces()[face as usize][usize::from(side.k)];
        f64::from(side.k) * 2.0 * FRAC_PI_3 + if from_low { 0.0 } else { PI }
    }

    /// The middle of a face's sector in the vertex's frame, the angle of its first side in the chart, its width.
    fn sector(&self, v: u32, face: u32) -> (f64, f64, f64) {
        let fan = self.hierarchy.base().fan(v);
        let at = fan.corners.iter().position(|&(f, _)| f == face).expect("a face of the fan");
        let base = self.hierarchy.base();
        let width = width_in_fan(base, v, at);
        (angle_in_fan(base, v, at, 0.5), f64::from(fan.corners[at].1) * 2.0 * FRAC_PI_3, width)
    }

    fn wrap(&self, v: u32, angle: f64) -> f64 {
        if self.hierarchy.base().fan(v).closed { wrapped(angle) } else { angle }
    }
}

/// Where a lattice point comes when the points of a face with `n` segments are listed row by row.
pub(super) fn row_index(n: i32, [_, i, r]: [i32; 3]) -> usize {
    (r * (n + 1) - r * (r - 1) / 2 + i) as usize
}

/// The lattice triangle that holds a point given by barycentric coordinates whose sum is a whole number.
pub(super) fn cell(b: [f64; 3]) -> Cell {
    let floor = b.map(|x| (x + 1e-9).floor());
    let rest: [f64; 3] = std::array::from_fn(|k| (b[k] - floor[k]).clamp(0.0, 1.0));
    let corner = floor.map(|x| x as i32);
    let missing = (rest[0] + rest[1] + rest[2]).round() as i32;
    std::array::from_fn(|k| {
        let mut at = corner;
        match missing {
            0 => (at, if k == 0 { 1.0 } else { 0.0 }),
            1 => {
                at[k] += 1;
                (at, rest[k])
            }
            _ => {
                at[(k + 1) % 3] += 1;
                at[(k + 2) % 3] += 1;
                (at, 1.0 - rest[k])
            }
        }
    })
}

/// Barycentric steps of a plane vector of a chart.
pub(super) fn steps(way: DVec2) -> [f64; 3] {
    let r = way.y * (2.0 / 3f64.sqrt());
    let i = way.x - 0.5 * r;
    [-i - r, i, r]
}

fn angle(v: DVec2) -> f64 {
    libm::atan2(v.y, v.x)
}

fn turned(length: f64, angle: f64) -> DVec2 {
    DVec2::new(libm::cos(angle), libm::sin(angle)) * length
}

fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}

#[cfg(test)]
mod tests;
