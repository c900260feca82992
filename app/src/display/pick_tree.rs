//! Which point of the shown surface lies under the cursor.
//!
//! The hierarchy is the bounding-volume tree: a triangle of a coarse level bounds its descendants. Boxes are kept
//! for all levels down to two above the shown one and refitted along the paths of moved vertices only.

use super::{HiddenFaces, ShownVertices};
use crate::render::Ray;
use bozzetto_core::hierarchy::{Address, Hierarchy, Layout, Level, Odd, Site, Slot, Subtriangle};
use bozzetto_core::surface::{Moved, Surface};
use glam::DVec3;
use rayon::prelude::*;

/// Levels between the smallest boxes and the shown triangles: 16 triangles a box.
const LEAF_DEPTH: u8 = 2;

#[derive(Debug, Clone, Copy)]
struct Bounds {
    low: [f32; 3],
    high: [f32; 3],
}

impl Bounds {
    const EMPTY: Bounds = Bounds { low: [f32::INFINITY; 3], high: [f32::NEG_INFINITY; 3] };

    fn with(mut self, low: [f32; 3], high: [f32; 3]) -> Self {
        for c in 0..3 {
            self.low[c] = self.low[c].min(low[c]);
            self.high[c] = self.high[c].max(high[c]);
        }
        self
    }

    /// The distance along the ray at which it enters, if it meets the box before `limit`.
    fn entered(&self, ray: &Ray, limit: f64) -> Option<f64> {
        let (mut near, mut far) = (0.0f64, limit);
        for c in 0..3 {
            let inverse = 1.0 / ray.direction[c];
            let a = (f64::from(self.low[c]) - ray.origin[c]) * inverse;
            let b = (f64::from(self.high[c]) - ray.origin[c]) * inverse;
            near = near.max(a.min(b));
            far = far.min(a.max(b));
        }
        (near <= far).then_some(near)
    }
}

/// Where a ray meets the shown surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The base face.
    pub face: u32,
    /// Barycentric coordinates in it, sum 1.
    pub barycentric: DVec3,
    /// The point, where it is drawn.
    pub point: DVec3,
    /// Its distance along the ray.
    pub distance: f64,
}

/// The tree of boxes over the shown level.
#[derive(Debug, Clone)]
pub struct PickTree {
    shown: Level,
    boxes: Vec<Vec<Bounds>>,
    /// One bit per smallest box, clear between calls.
    seen: Vec<u64>,
}

impl PickTree {
    /// Boxes for all triangles. Linear in the shown vertices.
    pub fn new(hierarchy: &Hierarchy, vertices: &ShownVertices) -> Self {
        let shown = vertices.level();
        let leaf = Level(shown.0.saturating_sub(LEAF_DEPTH));
        let faces = hierarchy.base().faces().len() as u32;
        let count = |level: Level| faces as usize * (level.segments() as usize).pow(2);
        let mut boxes: Vec<Vec<Bounds>> =
            (0..=leaf.0).map(|l| vec![Bounds::EMPTY; count(Level(l))]).collect();
        let layout = hierarchy.layout(shown);
        let n = leaf.segments();
        let per_face = (n * n) as usize;
        boxes[leaf.index()].par_chunks_mut(per_face).enumerate().for_each(|(face, chunk)| {
            for triangle in Subtriangle::all_in_face(face as u32, n) {
                chunk[triangle.index(n) - face * per_face] =
                    leaf_box(layout, vertices, triangle, shown.0 - leaf.0);
            }
        });
        let seen = vec![0; boxes[leaf.index()].len().div_ceil(64)];
        let mut tree = Self { shown, boxes, seen };
        for level in (0..leaf.0).rev().map(Level) {
            let n = level.segments();
            for face in 0..faces {
                for triangle in Subtriangle::all_in_face(face, n) {
                    tree.refit_inner(level, triangle);
                }
            }
        }
        tree
    }

    /// Follows an edit. Cost: the moved vertices and the paths above them.
    pub fn follow(&mut self, surface: &Surface, vertices: &ShownVertices, moved: &Moved) {
        let runs = match moved {
            Moved::Nothing => return,
            Moved::Everything => {
                *self = Self::new(surface.hierarchy(), vertices);
                return;
            }
            Moved::Some(runs) => runs,
        };
        let layout = surface.hierarchy().layout(self.shown);
        let leaf = Level(self.boxes.len() as u8 - 1);
        let mut touched = Subtriangle::holding(layout, runs.iter(), leaf, &mut self.seen);
        for &triangle in &touched {
            self.boxes[leaf.index()][triangle.index(leaf.segments())] =
                leaf_box(layout, vertices, triangle, self.shown.0 - leaf.0);
        }
        for level in (0..leaf.0).rev().map(Level) {
            touched.iter_mut().for_each(|t| *t = t.parent());
            touched.sort_unstable_by_key(|t| t.index(level.segments()));
            touched.dedup();
            touched.iter().for_each(|&t| self.refit_inner(level, t));
        }
    }

    fn refit_inner(&mut self, level: Level, triangle: Subtriangle) {
        let finer = level.finer();
        let joined = triangle.children().into_iter().fold(Bounds::EMPTY, |all, child| {
            let child = self.boxes[finer.index()][child.index(finer.segments())];
            all.with(child.low, child.high)
        });
        self.boxes[level.index()][triangle.index(level.segments())] = joined;
    }

    /// The nearest point of the shown surface on a ray, passing through what is hidden. Cost: logarithmic, where the
    /// surface is not a thicket.
    pub fn pick(
        &self,
        hierarchy: &Hierarchy,
        vertices: &ShownVertices,
        ray: &Ray,
        hidden: &HiddenFaces<'_>,
    ) -> Option<Hit> {
        let layout = hierarchy.layout(self.shown);
        let mut best: Option<Hit> = None;
        let limit = |best: &Option<Hit>| best.map_or(f64::INFINITY, |hit| hit.distance);
        let mut stack: Vec<(u8, Subtriangle)> =
            (0..hierarchy.base().faces().len() as u32).map(|f| (0, Subtriangle::whole(f))).collect();
        while let Some((level, triangle)) = stack.pop() {
            if let Some(boxes) = self.boxes.get(usize::from(level)) {
                let bounds = &boxes[triangle.index(Level(level).segments())];
                if bounds.entered(ray, limit(&best)).is_none() {
                    continue;
                }
            }
            if level < self.shown.0 {
                stack.extend(triangle.children().map(|child| (level + 1, child)));
                continue;
            }
            if let Some(hit) = meet(layout, vertices, triangle, ray)
                && hit.distance < limit(&best)
                && !hidden.hides(slots(layout, triangle))
            {
                best = Some(hit);
            }
        }
        best
    }
}

impl Hit {
    /// The vertex of `M^level` nearest in the parameter domain.
    pub fn nearest_vertex(&self, hierarchy: &Hierarchy, level: Level) -> Slot {
        let layout = hierarchy.layout(level);
        let (places, _) = self.corners(level);
        layout.slot(site(layout, self.face, places[0]))
    }

    /// The odd vertex of a level nearest in the parameter domain.
    pub fn nearest_odd(&self, hierarchy: &Hierarchy, level: Level) -> Odd {
        let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
        let (places, _) = self.corners(level.finer());
        let odd = places
            .into_iter()
            .map(|place| site(fine, self.face, place))
            .find(|&s| Layout::coarsen(s).is_none())
            .expect("a triangle has at most one even corner");
        coarse.odd_at(odd)
    }

    /// The corners of the triangle of a level that holds the hit, nearest first, with their weights.
    fn corners(&self, level: Level) -> ([[u32; 2]; 3], [f64; 3]) {
        let address = Address { face: self.face, at: [self.barycentric.y, self.barycentric.z] };
        let (triangle, weights) = address.triangle(level);
        let places = triangle.corners();
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| weights[b].total_cmp(&weights[a]));
        (order.map(|k| places[k]), order.map(|k| weights[k]))
    }
}

fn site(layout: &Layout, face: u32, [i, r]: [u32; 2]) -> Site {
    layout.site_at(face, [layout.segments() - i - r, i, r])
}

fn slots(layout: &Layout, triangle: Subtriangle) -> [u32; 3] {
    triangle.corners().map(|place| layout.slot(site(layout, triangle.face, place)).0)
}

/// The box of a triangle that lies `depth` levels above the shown ones.
fn leaf_box(layout: &Layout, vertices: &ShownVertices, triangle: Subtriangle, depth: u8) -> Bounds {
    let m = 1u32 << depth;
    let mut bounds = Bounds::EMPTY;
    for b in 0..=m {
        for a in 0..=m - b {
            let place = if triangle.down {
                [(triangle.i + 1) * m - a, (triangle.r + 1) * m - b]
            } else {
                [triangle.i * m + a, triangle.r * m + b]
            };
            let p = vertices.positions()[layout.slot(site(layout, triangle.face, place)).index()];
            bounds = bounds.with(p, p);
        }
    }
    bounds
}

/// Where a ray meets a shown triangle (Möller, Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997).
fn meet(layout: &Layout, vertices: &ShownVertices, triangle: Subtriangle, ray: &Ray) -> Option<Hit> {
    let places = triangle.corners();
    let at = |k: usize| {
        let slot = layout.slot(site(layout, triangle.face, places[k]));
        DVec3::from_array(vertices.positions()[slot.index()].map(f64::from))
    };
    let (a, b, c) = (at(0), at(1), at(2));
    let (e1, e2) = (b - a, c - a);
    let p = ray.direction.cross(e2);
    let determinant = e1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let s = ray.origin - a;
    let u = s.dot(p) / determinant;
    let q = s.cross(e1);
    let v = ray.direction.dot(q) / determinant;
    let distance = e2.dot(q) / determinant;
    if u < 0.0 || v < 0.0 || u + v > 1.0 || distance <= 0.0 {
        return None;
    }
    let weights = [1.0 - u - v, u, v];
    let n = f64::from(layout.segments());
    let mix =
        |coordinate: usize| (0..3).map(|k| weights[k] * f64::from(places[k][coordinate])).sum::<f64>() / n;
    let (x, y) = (mix(0), mix(1));
    Some(Hit {
        face: triangle.face,
        barycentric: DVec3::new(1.0 - x - y, x, y),
        point: ray.origin + ray.direction * distance,
        distance,
    })
}
