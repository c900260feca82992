//! Where on the surface the point closest to a given one lies.
//!
//! The hierarchy is the bounding-volume tree: a triangle of a coarse level bounds its descendants on the finest. Boxes
//! are made when first asked for, and refitted along the paths of what moved. The answer is the exact minimum over all
//! triangles, the first in order among equals, so it does not depend on how the boxes stand.

use super::{Runs, Vector};
use crate::hierarchy::{Address, Hierarchy, Layout, Level, Subtriangle};
use crate::mesh::closest_on_triangle;
use glam::DVec3;
use rayon::prelude::*;

/// Levels between the smallest boxes and the finest triangles: 16 triangles a box.
const LEAF_DEPTH: u8 = 2;
/// Base faces that share a box above them.
const GROUP: usize = 64;
/// Distances are compared with this much room, far above rounding and far below a step.
const ROOM: f64 = 1.0 + 1e-9;

/// A box in steps.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Bounds {
    low: Vector,
    high: Vector,
}

impl Bounds {
    const EMPTY: Bounds = Bounds { low: [i32::MAX; 3], high: [i32::MIN; 3] };

    fn with(mut self, low: Vector, high: Vector) -> Self {
        for c in 0..3 {
            self.low[c] = self.low[c].min(low[c]);
            self.high[c] = self.high[c].max(high[c]);
        }
        self
    }

    /// The squared distance of a point.
    fn squared_distance(&self, p: DVec3) -> f64 {
        let [low, high] = [self.low, self.high].map(|v| DVec3::from_array(v.map(f64::from)));
        (p - p.clamp(low, high)).length_squared()
    }
}

/// A point of the finest level.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Where it lies in the parameter domain.
    pub address: Address,
    /// The point, in steps.
    pub point: [f64; 3],
    /// Its squared distance from what was asked for, in steps.
    pub squared_distance: f64,
}

/// The tree of boxes over the finest level. Memory: 2 bytes a finest vertex or so.
#[derive(Debug, Clone)]
pub(super) struct BoundsTree {
    boxes: Vec<Vec<Bounds>>,
    groups: Vec<Bounds>,
    /// One bit per smallest box, clear between calls.
    seen: Vec<u64>,
}

impl BoundsTree {
    /// Boxes for all triangles. Linear in the finest vertices.
    pub(super) fn new(hierarchy: &Hierarchy, positions: &[Vector]) -> Self {
        let finest = hierarchy.finest();
        let leaf = Level(finest.0.saturating_sub(LEAF_DEPTH));
        let faces = hierarchy.base().faces().len();
        let per_face = |level: Level| (level.segments() as usize).pow(2);
        let mut boxes: Vec<Vec<Bounds>> =
            (0..=leaf.0).map(|l| vec![Bounds::EMPTY; faces * per_face(Level(l))]).collect();
        let layout = hierarchy.layout(finest);
        let n = leaf.segments();
        boxes[leaf.index()].par_chunks_mut(per_face(leaf)).enumerate().for_each(|(face, chunk)| {
            for triangle in Subtriangle::all_in_face(face as u32, n) {
                chunk[triangle.index(n) - face * per_face(leaf)] =
                    leaf_box(layout, positions, triangle, leaf);
            }
        });
        let seen = vec![0; boxes[leaf.index()].len().div_ceil(64)];
        let mut tree = Self { boxes, groups: vec![Bounds::EMPTY; faces.div_ceil(GROUP)], seen };
        for level in (0..leaf.0).rev().map(Level) {
            for face in 0..faces as u32 {
                Subtriangle::all_in_face(face, level.segments()).for_each(|t| tree.refit(level, t));
            }
        }
        (0..tree.groups.len()).for_each(|group| tree.refit_group(group));
        tree
    }

    /// Follows what moved on the finest level. Cost: what moved and the paths above it.
    pub(super) fn follow(&mut self, hierarchy: &Hierarchy, positions: &[Vector], runs: &Runs) {
        let layout = hierarchy.layout(hierarchy.finest());
        let leaf = Level(self.boxes.len() as u8 - 1);
        let n = leaf.segments();
        let mut touched = Subtriangle::holding(layout, runs.iter(), leaf, &mut self.seen);
        for &triangle in &touched {
            self.boxes[leaf.index()][triangle.index(n)] = leaf_box(layout, positions, triangle, leaf);
        }
        for level in (0..leaf.0).rev().map(Level) {
            touched.iter_mut().for_each(|t| *t = t.parent());
            touched.sort_unstable_by_key(|t| t.index(level.segments()));
            touched.dedup();
            touched.iter().for_each(|&t| self.refit(level, t));
        }
        let mut groups: Vec<usize> = touched.iter().map(|t| t.face as usize / GROUP).collect();
        groups.sort_unstable();
        groups.dedup();
        groups.into_iter().for_each(|group| self.refit_group(group));
    }

    fn refit(&mut self, level: Level, triangle: Subtriangle) {
        let finer = level.finer();
        let joined = triangle.children().into_iter().fold(Bounds::EMPTY, |all, child| {
            let child = self.boxes[finer.index()][child.index(finer.segments())];
            all.with(child.low, child.high)
        });
        self.boxes[level.index()][triangle.index(level.segments())] = joined;
    }

    fn refit_group(&mut self, group: usize) {
        let faces = self.boxes[0].chunks(GROUP).nth(group).expect("a group of faces");
        self.groups[group] = faces.iter().fold(Bounds::EMPTY, |all, b| all.with(b.low, b.high));
    }

    /// The closest point of the finest level. Cost: logarithmic, where the surface is not equally far everywhere.
    pub(super) fn nearest(&self, hierarchy: &Hierarchy, positions: &[Vector], p: [f64; 3]) -> Nearest {
        let p = DVec3::from_array(p);
        let layout = hierarchy.layout(hierarchy.finest());
        let mut search = Search { tree: self, layout, positions, p, best: None };
        let mut groups: Vec<(f64, usize)> =
            self.groups.iter().enumerate().map(|(at, b)| (b.squared_distance(p), at)).collect();
        groups.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        for (distance, group) in groups {
            if search.beaten(distance) {
                break;
            }
            let faces = group * GROUP..(group * GROUP + GROUP).min(self.boxes[0].len());
            let mut faces: Vec<(f64, u32)> =
                faces.map(|face| (self.boxes[0][face].squared_distance(p), face as u32)).collect();
            faces.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
            faces.into_iter().for_each(|(distance, face)| {
                search.visit(Level::BASE, Subtriangle::whole(face), distance);
            });
        }
        search.best.expect("a surface has triangles").0
    }
}

struct Search<'a> {
    tree: &'a BoundsTree,
    layout: &'a Layout,
    positions: &'a [Vector],
    p: DVec3,
    best: Option<(Nearest, usize)>,
}

impl Search<'_> {
    fn beaten(&self, squared_distance: f64) -> bool {
        self.best.as_ref().is_some_and(|(best, _)| squared_distance > best.squared_distance * ROOM)
    }

    fn visit(&mut self, level: Level, triangle: Subtriangle, squared_distance: f64) {
        if self.beaten(squared_distance) {
            return;
        }
        if level == self.layout.level() {
            return self.meet(triangle);
        }
        let finer = level.finer();
        let Some(boxes) = self.tree.boxes.get(finer.index()) else {
            return triangle
                .children()
                .into_iter()
                .for_each(|child| self.visit(finer, child, squared_distance));
        };
        let mut children = triangle
            .children()
            .map(|child| (boxes[child.index(finer.segments())].squared_distance(self.p), child));
        children.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        children.into_iter().for_each(|(distance, child)| self.visit(finer, child, distance));
    }

    fn meet(&mut self, triangle: Subtriangle) {
        let squared_distance = closest_within(self.layout, self.positions, self.p, triangle).1;
        let index = triangle.index(self.layout.segments());
        let better = self
            .best
            .as_ref()
            .is_none_or(|(best, first)| (squared_distance, index) < (best.squared_distance, *first));
        if better {
            self.best = Some((meet(self.layout, self.positions, self.p, triangle), index));
        }
    }
}

/// The point of a finest triangle closest to `p`, and its squared distance.
pub(super) fn closest_within(
    layout: &Layout,
    positions: &[Vector],
    p: DVec3,
    triangle: Subtriangle,
) -> (DVec3, f64) {
    closest_on_triangle(p, &corners(layout, positions, triangle))
}

/// The place of a finest triangle closest to `p`.
pub(super) fn meet(layout: &Layout, positions: &[Vector], p: DVec3, triangle: Subtriangle) -> Nearest {
    let (point, squared_distance) = closest_within(layout, positions, p, triangle);
    let weights = weights_of(point, &corners(layout, positions, triangle));
    let address = Address::within(triangle, layout.level(), weights);
    Nearest { address, point: point.to_array(), squared_distance }
}

/// Weights of a triangle's corners, none negative, sum 1, for a point of it.
fn weights_of(point: DVec3, [a, b, c]: &[DVec3; 3]) -> [f64; 3] {
    let normal = (*b - *a).cross(*c - *a);
    let area = |p: DVec3, q: DVec3| (p - point).cross(q - point).dot(normal).max(0.0);
    let areas = [area(*b, *c), area(*c, *a), area(*a, *b)];
    let sum = areas[0] + areas[1] + areas[2];
    if sum > 0.0 { areas.map(|x| x / sum) } else { [1.0, 0.0, 0.0] }
}

fn corners(layout: &Layout, positions: &[Vector], triangle: Subtriangle) -> [DVec3; 3] {
    triangle.corners().map(|[i, r]| {
        let slot = layout.slot(layout.site_at(triangle.face, [layout.segments() - i - r, i, r]));
        DVec3::from_array(positions[slot.index()].map(f64::from))
    })
}

/// The box of what a triangle of the leaves' level holds on the finest.
fn leaf_box(layout: &Layout, positions: &[Vector], triangle: Subtriangle, leaf: Level) -> Bounds {
    let m = 1u32 << (layout.level().0 - leaf.0);
    let n = layout.segments();
    let mut bounds = Bounds::EMPTY;
    for b in 0..=m {
        for a in 0..=m - b {
            let [i, r] = if triangle.down {
                [(triangle.i + 1) * m - a, (triangle.r + 1) * m - b]
            } else {
                [triangle.i * m + a, triangle.r * m + b]
            };
            let p = positions[layout.slot(layout.site_at(triangle.face, [n - i - r, i, r])).index()];
            bounds = bounds.with(p, p);
        }
    }
    bounds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::BaseMesh;
    use crate::mesh::shapes;
    use std::sync::Arc;

    /// Runs that go on over rows and faces, as those of whole levels do, are followed whole.
    #[test]
    fn followed_boxes_are_those_of_a_new_tree() {
        let mesh = shapes::octahedron();
        let base = Arc::new(BaseMesh::new(6, mesh.faces, &[]).expect("a base mesh"));
        let hierarchy = Hierarchy::new(base, Level(5)).expect("small");
        let count = hierarchy.layout(Level(5)).len();
        let place = |x: u32| [x, x * 37 + 11, x * 101 + 5].map(|x| (x * 7919 % 4001) as i32);
        let mut positions: Vec<Vector> = (0..count).map(place).collect();
        let mut tree = BoundsTree::new(&hierarchy, &positions);
        let face = hierarchy.layout(Level(5)).row(3, 1).0;
        for moved in [0..count, face + 10..face + 150, face - 5..face + 3, 2..count - 7, 5..6] {
            for slot in moved.clone() {
                positions[slot as usize] = positions[slot as usize].map(|x| (x * 5 + 3) % 6007);
            }
            tree.follow(&hierarchy, &positions, &Runs::of_runs(vec![moved.clone()]));
            let fresh = BoundsTree::new(&hierarchy, &positions);
            assert!(tree.boxes == fresh.boxes && tree.groups == fresh.groups, "{moved:?}");
        }
    }
}
