//! Exact closest points on a triangle mesh, through a tree of axis-aligned boxes.
//!
//! A binary tree split by a surface-area heuristic is folded into one of four boxes a node, kept in single precision
//! (after Dammertz, Hanika, Keller 2008, *Shallow bounding volume hierarchies*); triangles are tested in double.
//!
//! Guarantees: the same mesh always gives the same tree, and a query's answer depends on the mesh and on
//! the queries made before through the same cursor, never on threads. The distance is the least over all
//! triangles to within rounding (a few units in the last place); of triangles at equal distance any one
//! may be named. Degenerate triangles take part as segments or points.
//! Non-guarantees: it does not follow a mesh that changes; [`refit`](BoundingVolumes::refit) it.

mod build;
mod wide;

use self::build::Builder;
use self::wide::{Child, Frame, WideNode, widened};
use crate::memory::Buffer;
use glam::DVec3;
use std::cell::RefCell;

use super::triangle_distance::closest_on_triangle;
use super::{FaceIndex, TriangleMesh};

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

/// A bounding-volume tree over the triangles of a mesh. It keeps its own copy of their corners, in the
/// order of the leaves: about 130 bytes a face.
#[derive(Clone, Debug)]
pub struct BoundingVolumes {
    frame: Frame,
    nodes: Buffer<WideNode>,
    corners: Buffer<[DVec3; 3]>,
    faces: Vec<u32>,
    /// For each face its slot among the corners.
    slots: Vec<u32>,
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
        let binary = builder.nodes(go_on)?;
        let frame = Frame::around(&binary[0]);
        let boxes: Vec<[DVec3; 2]> =
            builder.triangles.iter().map(|triangle| [triangle.min, triangle.max]).collect();
        let nodes = widened(&binary, &boxes, &frame);
        let faces: Vec<u32> = builder.triangles.iter().map(|triangle| triangle.face).collect();
        let corners = Buffer::of(faces.len(), |slot| mesh.corners(FaceIndex(faces[slot])).map(DVec3::from));
        let mut slots = vec![0; faces.len()];
        (0..).zip(&faces).for_each(|(slot, &face)| slots[face as usize] = slot);
        Ok(Some(Self { frame, nodes: nodes.into(), corners, faces, slots }))
    }

    /// Follows the vertices of its mesh to other places: `mesh` has the same faces. The boxes stay as they are nested,
    /// so far moves make queries slow, never wrong. Cost: O(n), a twentieth of building.
    ///
    /// Panics if `mesh` has another number of faces, or a face refers to a vertex that does not exist.
    pub fn refit(&mut self, mesh: &TriangleMesh) {
        assert_eq!(mesh.faces.len(), self.faces.len(), "a tree is refitted to the faces it was built over");
        for (corners, &face) in self.corners.iter_mut().zip(&self.faces) {
            *corners = mesh.corners(FaceIndex(face)).map(DVec3::from);
        }
        let mut extents = vec![[DVec3::ZERO; 2]; self.nodes.len()];
        for at in (0..self.nodes.len()).rev() {
            let mut whole = [DVec3::INFINITY, DVec3::NEG_INFINITY];
            for (k, code) in self.nodes[at].children().into_iter().enumerate() {
                let extent = match Child::of(code) {
                    None => continue,
                    Some(Child::Node(node)) => extents[node],
                    Some(Child::Triangle(slot)) => {
                        let [a, b, c] = self.corners[slot];
                        [a.min(b).min(c), a.max(b).max(c)]
                    }
                };
                whole = [whole[0].min(extent[0]), whole[1].max(extent[1])];
                self.nodes[at].place(k, extent, &self.frame);
            }
            extents[at] = whole;
        }
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
        ClosestPointCursor { tree: self, slot: None, aside: Vec::new(), looked_at: 0 }
    }
}

/// A sequence of closest-point queries, each starting from the triangle that answered the one before:
/// where queries lie near one another, that is a good bound from the first step.
#[derive(Clone, Debug)]
pub struct ClosestPointCursor<'t> {
    tree: &'t BoundingVolumes,
    slot: Option<usize>,
    /// Boxes and triangles put aside, with a lower bound of their squared distance each.
    aside: Vec<(f32, u32)>,
    looked_at: u64,
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

    /// How many boxes and triangles all queries together looked at: what they cost, on whatever machine.
    pub fn looked_at(&self) -> u64 {
        self.looked_at
    }

    /// The next query starts from a face instead, best one the answer lies on or near.
    pub fn start_at(&mut self, face: FaceIndex) {
        self.slot = self.tree.slots.get(face.0 as usize).map(|&slot| slot as usize);
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

    /// Shows `visit` every face that is nearer to `point` than so far, in no particular order. Cost: that of looking at all of
    /// them.
    pub fn each_within(&mut self, point: [f64; 3], radius: f64, visit: impl FnMut(FaceIndex)) {
        let query = DVec3::from(point);
        let visit = RefCell::new(visit);
        let mut bound = Best { slot: usize::MAX, point: query, squared: radius * radius };
        // None is taken for the best, so the bound stays.
        self.descend(query, &mut bound, &|face| {
            (*visit.borrow_mut())(face);
            false
        });
    }

    /// The nearest box or triangle first, leaving out those no nearer than the best triangle.
    fn descend(&mut self, point: DVec3, best: &mut Best, allowed: &impl Fn(FaceIndex) -> bool) {
        let Self { tree, aside, looked_at, .. } = self;
        let query = tree.frame.query(point);
        let mut reach = tree.frame.reach(best.squared);
        aside.clear();
        aside.push((0.0, 0));
        while let Some((bound, code)) = aside.pop() {
            if bound >= reach {
                continue;
            }
            *looked_at += 1;
            match Child::of(code) {
                Some(Child::Triangle(slot)) => {
                    let (point, squared) = closest_on_triangle(point, &tree.corners[slot]);
                    if squared < best.squared && allowed(FaceIndex(tree.faces[slot])) {
                        *best = Best { slot, point, squared };
                        reach = tree.frame.reach(squared);
                    }
                }
                Some(Child::Node(node)) => {
                    let node = &tree.nodes[node];
                    let bottom = aside.len();
                    for (bound, code) in node.squared_distances(&query).into_iter().zip(node.children()) {
                        if bound < reach {
                            // The nearest on top.
                            let nearer =
                                aside[bottom..].iter().rev().take_while(|other| other.0 < bound).count();
                            aside.insert(aside.len() - nearer, (bound, code));
                        }
                    }
                }
                None => {}
            }
        }
    }
}

/// A tree was given up before it was built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Abandoned;

#[cfg(test)]
mod tests;
