//! Boxes four together, in single precision, so that a query looks at four at once.
//!
//! Coordinates are taken from the middle of the mesh, over its extent, and rounded outward: a distance to a box is never
//! more than the true one by more than [`SLACK`].

use super::build::Node;
use bytemuck::{Pod, Zeroable};
use glam::DVec3;

/// A child that is a triangle; the other bits are its slot.
const TRIANGLE: u32 = 1 << 31;
/// No child.
const NONE: u32 = u32::MAX;
/// Relative error of a squared distance to a box, with some to spare: six roundings of 2⁻²⁴.
const SLACK: f64 = 1e-6;
/// Beyond so many extents a query counts as this far: its bounds are smaller then, which is safe.
const FARTHEST: f64 = 1e15;

/// Up to four boxes and what they hold.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(super) struct WideNode {
    min: [[f32; 4]; 3],
    max: [[f32; 4]; 3],
    children: [u32; 4],
}

/// A child of a wide node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Child {
    Node(usize),
    Triangle(usize),
}

impl Child {
    /// `None` where there is none.
    pub(super) fn of(code: u32) -> Option<Self> {
        match code {
            NONE => None,
            node if node & TRIANGLE == 0 => Some(Self::Node(node as usize)),
            triangle => Some(Self::Triangle((triangle ^ TRIANGLE) as usize)),
        }
    }

    fn code(self) -> u32 {
        match self {
            Self::Node(node) => node as u32,
            Self::Triangle(slot) => slot as u32 | TRIANGLE,
        }
    }
}

/// From model units to those of the boxes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    centre: DVec3,
    scale: f64,
}

/// A query in the units of the boxes, between two single-precision points.
pub(super) struct Query {
    low: [f32; 3],
    high: [f32; 3],
}

impl Frame {
    pub(super) fn around(root: &Node) -> Self {
        let extent = (root.max - root.min).max_element();
        let scale = if extent > 0.0 && (1.0 / extent).is_finite() { 1.0 / extent } else { 1.0 };
        Self { centre: root.min + (root.max - root.min) * 0.5, scale }
    }

    pub(super) fn query(&self, p: DVec3) -> Query {
        let at = ((p - self.centre) * self.scale).clamp(DVec3::splat(-FARTHEST), DVec3::splat(FARTHEST));
        Query { low: at.to_array().map(below), high: at.to_array().map(above) }
    }

    /// A box further away than this, in squared units of the boxes, holds nothing nearer than `squared` model units.
    pub(super) fn reach(&self, squared: f64) -> f32 {
        if squared > 0.0 { above(squared * self.scale * self.scale * (1.0 + SLACK)) } else { 0.0 }
    }
}

/// The greatest single-precision number that is not above `x`.
fn below(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x { near.next_down() } else { near }
}

/// The least single-precision number that is not below `x`.
fn above(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) < x { near.next_up() } else { near }
}

impl WideNode {
    /// Without children: their boxes are infinitely far.
    pub(super) const EMPTY: Self =
        Self { min: [[f32::INFINITY; 4]; 3], max: [[f32::NEG_INFINITY; 4]; 3], children: [NONE; 4] };

    /// Gives a child its box.
    pub(super) fn place(&mut self, k: usize, [min, max]: [DVec3; 2], frame: &Frame) {
        let (min, max) = ((min - frame.centre) * frame.scale, (max - frame.centre) * frame.scale);
        for axis in 0..3 {
            (self.min[axis][k], self.max[axis][k]) = (below(min[axis]), above(max[axis]));
        }
    }

    pub(super) fn children(&self) -> [u32; 4] {
        self.children
    }

    /// The squared distances from a query to the boxes.
    pub(super) fn squared_distances(&self, query: &Query) -> [f32; 4] {
        let mut sums = [0.0; 4];
        for axis in 0..3 {
            let (low, high) = (query.low[axis], query.high[axis]);
            for (k, sum) in sums.iter_mut().enumerate() {
                let (before, after) = (self.min[axis][k] - high, low - self.max[axis][k]);
                let outside = if before > after { before } else { after };
                let outside = if outside > 0.0 { outside } else { 0.0 };
                *sum += outside * outside;
            }
        }
        sums
    }
}

/// The binary tree's boxes four together; the root first, children after their parents.
pub(super) fn widened(nodes: &[Node], triangles: &[[DVec3; 2]], frame: &Frame) -> Vec<WideNode> {
    let mut wide = vec![WideNode::EMPTY];
    let mut pending = vec![(0usize, 0u32)];
    while let Some((at, index)) = pending.pop() {
        for (k, child) in quarters(nodes, index).into_iter().flatten().enumerate() {
            let (child, extent) = match child {
                Child::Triangle(slot) => (Child::Triangle(slot), triangles[slot]),
                Child::Node(node) => {
                    let extent = [nodes[node].min, nodes[node].max];
                    wide.push(WideNode::EMPTY);
                    pending.push((wide.len() - 1, node as u32));
                    (Child::Node(wide.len() - 1), extent)
                }
            };
            wide[at].children[k] = child.code();
            wide[at].place(k, extent, frame);
        }
    }
    wide
}

/// What a box of the binary tree holds, in up to four parts: the largest is opened while there is room.
fn quarters(nodes: &[Node], index: u32) -> [Option<Child>; 4] {
    let mut parts = [Some(Child::Node(index as usize)), None, None, None];
    let mut count = 1;
    let largest = |parts: &[Option<Child>; 4], count: usize| {
        let fits = |(k, part): (usize, &Option<Child>)| match *part {
            Some(Child::Node(node)) if count - 1 + nodes[node].parts() <= 4 => Some((k, node)),
            _ => None,
        };
        let area = |found: &(usize, usize)| nodes[found.1].half_area();
        parts.iter().enumerate().filter_map(fits).max_by(|a, b| area(a).total_cmp(&area(b)))
    };
    while let Some((k, node)) = largest(&parts, count) {
        let Node { first, count: triangles, .. } = nodes[node];
        for part in 0..nodes[node].parts() {
            let number = first as usize + part;
            let child = if triangles > 0 { Child::Triangle(number) } else { Child::Node(number) };
            parts[if part == 0 { k } else { count }] = Some(child);
            count += usize::from(part > 0);
        }
    }
    parts
}
