//! Exact closest points on a triangle mesh, through a tree of axis-aligned boxes.
//!
//! The tree is binary, stored flat (siblings side by side), and split by a binned surface-area
//! heuristic (Wald 2007, *On fast construction of SAH-based bounding volume hierarchies*).
//!
//! Guarantees: the same mesh always gives the same tree, and a query's answer depends on the mesh and on
//! the queries made before through the same cursor, never on threads. The distance is the least over all
//! triangles to within rounding (a few units in the last place); of triangles at equal distance any one
//! may be named. Degenerate triangles take part as segments or points.
//! Non-guarantees: it does not follow a mesh that changes; build it anew.

use glam::DVec3;

use super::triangle_distance::closest_on_triangle;
use super::{FaceIndex, TriangleMesh};

/// Triangles in a leaf. On scans of 70 k and 100 k faces 1 and 4 take the same time a query, 8 a tenth more;
/// 4 keeps the tree small.
const LEAF_TRIANGLES: usize = 4;
/// Bins tried along each axis; on the same scans 8, 16 and 32 are within a tenth of one another.
const BINS: usize = 16;
/// Below this depth the heuristic gives way to halving, which ends after 32 more levels at most.
const HEURISTIC_DEPTH: u32 = 40;
/// A descent leaves at most one box aside per level of the tree.
const STACK: usize = HEURISTIC_DEPTH as usize + 40;

/// The point of a mesh closest to a query.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// A face the point lies on.
    pub face: FaceIndex,
    /// The point, in model units.
    pub point: [f64; 3],
    /// The squared distance from the query, in squared model units.
    pub squared_distance: f64,
}

/// A box and what it holds: `count` triangles from slot `first`, or, if `count` is 0, the two boxes
/// `first` and `first + 1`.
#[derive(Clone, Copy, Debug)]
struct Node {
    min: DVec3,
    max: DVec3,
    first: u32,
    count: u32,
}

impl Node {
    /// A lower bound of the squared distance from `p` to anything inside.
    fn squared_distance(&self, p: DVec3) -> f64 {
        (self.min - p).max(p - self.max).max(DVec3::ZERO).length_squared()
    }
}

/// A bounding-volume tree over the triangles of a mesh. It keeps its own copy of their corners, in the
/// order of the leaves: about 130 bytes a face.
#[derive(Clone, Debug)]
pub struct BoundingVolumes {
    nodes: Vec<Node>,
    corners: Vec<[DVec3; 3]>,
    faces: Vec<u32>,
}

impl BoundingVolumes {
    /// Builds the tree; `None` for a mesh without faces. Cost: O(n log n), about 0.1 s for 100 k faces.
    ///
    /// Panics if a face refers to a vertex that does not exist.
    pub fn build(mesh: &TriangleMesh) -> Option<Self> {
        Self::build_while(mesh, &mut || true).unwrap_or(None)
    }

    /// [`build`](Self::build), asking now and then, after some hundredths of a second, whether to go on.
    ///
    /// # Errors
    /// The answer was no.
    pub fn build_while(
        mesh: &TriangleMesh,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Option<Self>, Abandoned> {
        if mesh.is_empty() {
            return Ok(None);
        }
        let mut builder = Builder::new(mesh);
        let nodes = builder.nodes(go_on)?;
        let faces: Vec<u32> = builder.triangles.iter().map(|triangle| triangle.face).collect();
        let corners = faces.iter().map(|&face| mesh.corners(FaceIndex(face)).map(DVec3::from)).collect();
        Ok(Some(Self { nodes, corners, faces }))
    }

    /// The point of the mesh closest to `point` (finite, model units). For many queries that lie near one
    /// another a [`cursor`](Self::cursor) is faster. Cost: O(log n) for points near the surface.
    pub fn closest(&self, point: [f64; 3]) -> ClosestPoint {
        self.cursor().closest(point)
    }

    fn answer(&self, best: &Best) -> ClosestPoint {
        ClosestPoint {
            face: FaceIndex(self.faces[best.slot]),
            point: best.point.to_array(),
            squared_distance: best.squared,
        }
    }

    /// A cursor for a sequence of queries.
    pub fn cursor(&self) -> ClosestPointCursor<'_> {
        ClosestPointCursor { tree: self, slot: None }
    }
}

/// A sequence of closest-point queries, each starting from the triangle that answered the one before:
/// where queries lie near one another, that is a good bound from the first step.
#[derive(Clone, Debug)]
pub struct ClosestPointCursor<'t> {
    tree: &'t BoundingVolumes,
    slot: Option<usize>,
}

/// The best answer so far.
struct Best {
    slot: usize,
    point: DVec3,
    squared: f64,
}

impl ClosestPointCursor<'_> {
    /// The point of the mesh closest to `point` (finite, model units).
    pub fn closest(&mut self, point: [f64; 3]) -> ClosestPoint {
        let query = DVec3::from(point);
        let slot = self.slot.unwrap_or(0);
        let (point, squared) = closest_on_triangle(query, &self.tree.corners[slot]);
        let mut best = Best { slot, point, squared };
        self.descend(query, &mut best, &|_| true);
        self.slot = Some(best.slot);
        self.tree.answer(&best)
    }

    /// The point closest to `point` on the faces that `allowed` admits, no further than `within`; `None` if there is
    /// none. Cost: that of looking at all faces nearer than the answer.
    pub fn closest_where(
        &mut self,
        point: [f64; 3],
        within: f64,
        allowed: &impl Fn(FaceIndex) -> bool,
    ) -> Option<ClosestPoint> {
        let query = DVec3::from(point);
        let mut best = Best { slot: usize::MAX, point: query, squared: within * within };
        if let Some(slot) = self.slot
            && allowed(FaceIndex(self.tree.faces[slot]))
        {
            let (point, squared) = closest_on_triangle(query, &self.tree.corners[slot]);
            if squared < best.squared {
                best = Best { slot, point, squared };
            }
        }
        self.descend(query, &mut best, allowed);
        if best.slot == usize::MAX {
            return None;
        }
        self.slot = Some(best.slot);
        Some(self.tree.answer(&best))
    }

    /// Depth first, the nearer box first, leaving out boxes no nearer than the best triangle.
    fn descend(&self, query: DVec3, best: &mut Best, allowed: &impl Fn(FaceIndex) -> bool) {
        let nodes = &self.tree.nodes;
        let mut aside = [(0u32, 0.0f64); STACK];
        let mut height = 0;
        let mut next = Some((0u32, nodes[0].squared_distance(query)));
        while let Some((index, bound)) = next {
            next = None;
            if bound < best.squared {
                let node = nodes[index as usize];
                if node.count > 0 {
                    self.try_leaf(node, query, best, allowed);
                } else {
                    let near = (node.first, nodes[node.first as usize].squared_distance(query));
                    let far = (node.first + 1, nodes[node.first as usize + 1].squared_distance(query));
                    let (near, far) = if far.1 < near.1 { (far, near) } else { (near, far) };
                    if far.1 < best.squared {
                        aside[height] = far;
                        height += 1;
                    }
                    next = Some(near);
                }
            }
            if next.is_none() && height > 0 {
                height -= 1;
                next = Some(aside[height]);
            }
        }
    }

    fn try_leaf(&self, leaf: Node, query: DVec3, best: &mut Best, allowed: &impl Fn(FaceIndex) -> bool) {
        let first = leaf.first as usize;
        for slot in first..first + leaf.count as usize {
            let (point, squared) = closest_on_triangle(query, &self.tree.corners[slot]);
            if squared < best.squared && allowed(FaceIndex(self.tree.faces[slot])) {
                *best = Best { slot, point, squared };
            }
        }
    }
}

/// A tree was given up before it was built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Abandoned;

/// Triangles put into bins between two questions whether to go on.
const STRIDE: usize = 1 << 17;

/// A triangle as the builder sees it.
struct Triangle {
    min: DVec3,
    max: DVec3,
    centre: DVec3,
    face: u32,
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

struct Builder {
    triangles: Vec<Triangle>,
}

impl Builder {
    fn new(mesh: &TriangleMesh) -> Self {
        let triangles = (0u32..).zip(&mesh.faces).map(|(face, _)| {
            let [a, b, c] = mesh.corners(FaceIndex(face)).map(DVec3::from);
            let (min, max) = (a.min(b).min(c), a.max(b).max(c));
            Triangle { min, max, centre: min + (max - min) * 0.5, face }
        });
        Self { triangles: triangles.collect() }
    }

    /// Puts the triangles in leaf order and returns the nodes, the root first.
    fn nodes(&mut self, go_on: &mut dyn FnMut() -> bool) -> Result<Vec<Node>, Abandoned> {
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

/// The cheapest of the binned cuts; `None` when the centres cannot be told apart.
fn best_cut(triangles: &[Triangle], centres: &Extent) -> Option<Cut> {
    let mut best: Option<Cut> = None;
    for axis in 0..3 {
        let width = centres.max[axis] - centres.min[axis];
        if width <= 0.0 || !(BINS as f64 / width).is_finite() {
            continue;
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

#[cfg(test)]
mod tests;
