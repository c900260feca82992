//! The binary tree behind the boxes: split by a binned surface-area heuristic (Wald 2007, *On fast construction of
//! SAH-based bounding volume hierarchies*).

use super::super::{FaceIndex, TriangleMesh};
use super::Abandoned;
use glam::DVec3;

/// Triangles in a leaf; the boxes are taken four together anyway.
const LEAF_TRIANGLES: usize = 4;
/// Bins tried along each axis; on scans of 70 k and 100 k faces 8, 16 and 32 are within a tenth of one another.
const BINS: usize = 16;
/// Below this depth the heuristic gives way to halving, which ends after 32 more levels at most.
const HEURISTIC_DEPTH: u32 = 40;

/// A box and what it holds: `count` triangles from slot `first`, or, if `count` is 0, the two boxes
/// `first` and `first + 1`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    pub(super) min: DVec3,
    pub(super) max: DVec3,
    pub(super) first: u32,
    pub(super) count: u32,
}

impl Node {
    /// How many triangles or boxes it holds itself.
    pub(super) fn parts(&self) -> usize {
        if self.count > 0 { self.count as usize } else { 2 }
    }

    /// Half the surface area.
    pub(super) fn half_area(&self) -> f64 {
        Extent { min: self.min, max: self.max }.half_area()
    }
}

/// Triangles put into bins between two questions whether to go on.
const STRIDE: usize = 1 << 17;

/// A triangle as the builder sees it.
pub(super) struct Triangle {
    pub(super) min: DVec3,
    pub(super) max: DVec3,
    centre: DVec3,
    pub(super) face: u32,
}

/// A box that grows; it starts inside out.
#[derive(Clone, Copy)]
struct Extent {
    min: DVec3,
    max: DVec3,
}

impl Extent {
    const NONE: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    fn include(&mut self, min: DVec3, max: DVec3) {
        self.min = self.min.min(min);
        self.max = self.max.max(max);
    }

    /// Half the surface area; 0 for a box that holds nothing.
    fn half_area(&self) -> f64 {
        let side = (self.max - self.min).max(DVec3::ZERO);
        side.x * side.y + side.y * side.z + side.z * side.x
    }
}

/// A way to cut a set of triangles: those in the bins up to `bin` along `axis` go first.
struct Cut {
    axis: usize,
    bin: usize,
    cost: f64,
}

pub(super) struct Builder {
    /// In the order of the leaves, once there are nodes.
    pub(super) triangles: Vec<Triangle>,
}

impl Builder {
    pub(super) fn new(mesh: &TriangleMesh) -> Self {
        let triangles = (0u32..).zip(&mesh.faces).map(|(face, _)| {
            let [a, b, c] = mesh.corners(FaceIndex(face)).map(DVec3::from);
            let (min, max) = (a.min(b).min(c), a.max(b).max(c));
            Triangle { min, max, centre: min + (max - min) * 0.5, face }
        });
        Self { triangles: triangles.collect() }
    }

    /// Puts the triangles in leaf order and returns the nodes, the root first.
    pub(super) fn nodes(&mut self, go_on: &mut dyn FnMut() -> bool) -> Result<Vec<Node>, Abandoned> {
        let empty = Node { min: DVec3::ZERO, max: DVec3::ZERO, first: 0, count: 0 };
        let mut nodes = vec![empty];
        let mut pending = vec![(0usize, 0..self.triangles.len(), 0u32)];
        let mut binned = 0;
        while let Some((index, range, depth)) = pending.pop() {
            let triangles = &mut self.triangles[range.clone()];
            let mut extent = Extent::NONE;
            triangles.iter().for_each(|triangle| extent.include(triangle.min, triangle.max));
            nodes[index] = Node {
                min: extent.min,
                max: extent.max,
                first: range.start as u32,
                count: range.len() as u32,
            };
            if triangles.len() <= LEAF_TRIANGLES {
                continue;
            }
            binned += triangles.len();
            if binned >= STRIDE {
                binned = 0;
                if !go_on() {
                    return Err(Abandoned);
                }
            }
            let middle = range.start + split(triangles, depth);
            let first = nodes.len();
            nodes.extend([empty, empty]);
            (nodes[index].first, nodes[index].count) = (first as u32, 0);
            pending.push((first + 1, middle..range.end, depth + 1));
            pending.push((first, range.start..middle, depth + 1));
        }
        Ok(nodes)
    }
}

/// Reorders `triangles` into two non-empty parts and returns the size of the first.
fn split(triangles: &mut [Triangle], depth: u32) -> usize {
    let mut centres = Extent::NONE;
    triangles.iter().for_each(|triangle| centres.include(triangle.centre, triangle.centre));
    if depth < HEURISTIC_DEPTH
        && let Some(cut) = best_cut(triangles, &centres)
    {
        return partition(triangles, |triangle| bin_of(triangle, &centres, cut.axis) <= cut.bin);
    }
    // All centres in one place, or a tree grown too deep: halve along the longest axis. The face number
    // breaks ties, so the two halves are always the same sets.
    let axis = (centres.max - centres.min).max_position();
    let middle = triangles.len() / 2;
    triangles.select_nth_unstable_by(middle, |one, other| {
        one.centre[axis].total_cmp(&other.centre[axis]).then(one.face.cmp(&other.face))
    });
    middle
}

/// The cheapest of the binned cuts across the longest axis; `None` when the centres cannot be told apart. To try the
/// other axes too takes three times as long and makes queries on scans no faster.
fn best_cut(triangles: &[Triangle], centres: &Extent) -> Option<Cut> {
    let width = centres.max - centres.min;
    let axis = width.max_position();
    if width[axis] <= 0.0 || !(BINS as f64 / width[axis]).is_finite() {
        return None;
    }
    let mut bins = [(Extent::NONE, 0usize); BINS];
    for triangle in triangles {
        let (extent, count) = &mut bins[bin_of(triangle, centres, axis)];
        extent.include(triangle.min, triangle.max);
        *count += 1;
    }
    // Costs of everything right of each cut, then a sweep from the left.
    let mut right_costs = [(0.0, 0usize); BINS];
    let (mut extent, mut count) = (Extent::NONE, 0);
    for bin in (1..BINS).rev() {
        extent.include(bins[bin].0.min, bins[bin].0.max);
        count += bins[bin].1;
        right_costs[bin - 1] = (extent.half_area() * count as f64, count);
    }
    let mut best: Option<Cut> = None;
    let (mut extent, mut count) = (Extent::NONE, 0);
    for bin in 0..BINS - 1 {
        extent.include(bins[bin].0.min, bins[bin].0.max);
        count += bins[bin].1;
        let (right_cost, right_count) = right_costs[bin];
        let cost = extent.half_area() * count as f64 + right_cost;
        if count > 0 && right_count > 0 && best.as_ref().is_none_or(|best| cost < best.cost) {
            best = Some(Cut { axis, bin, cost });
        }
    }
    best
}

fn bin_of(triangle: &Triangle, centres: &Extent, axis: usize) -> usize {
    let scale = BINS as f64 / (centres.max[axis] - centres.min[axis]);
    (((triangle.centre[axis] - centres.min[axis]) * scale) as usize).min(BINS - 1)
}

/// Moves the triangles that satisfy `first` to the front and returns how many there are.
fn partition(triangles: &mut [Triangle], first: impl Fn(&Triangle) -> bool) -> usize {
    let mut front = 0;
    for index in 0..triangles.len() {
        if first(&triangles[index]) {
            triangles.swap(front, index);
            front += 1;
        }
    }
    front
}
