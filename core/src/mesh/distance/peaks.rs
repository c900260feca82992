//! The greatest distance inside faces: samples say where the surfaces are far apart, and there it is looked for closely.
//!
//! The distance to a surface changes by no more than the way gone, so a piece of a face whose middle is at distance `d` and
//! whose corners are `r` from it holds nothing further away than `d + r`, and mostly nothing near that. Faces are cut into
//! four where that is promising, the most promising piece first (best-first branch and bound).
//!
//! Guarantees: deterministic, bounded work. Non-guarantees: a peak in a face whose samples and corners all lie near is missed,
//! and so is a very steep one.

use super::super::bounding_volumes::BoundingVolumes;
use super::super::{FaceIndex, TriangleMesh};
use glam::DVec3;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// Points at this part of the greatest distance or more make their faces worth a search.
pub(super) const PROMISING: f64 = 0.35;
/// Queries in one face.
pub(super) const MOST_QUERIES: usize = 512;
/// Distances are taken to grow by no more than this part of the way gone, where twice as much is possible: surfaces that were
/// fitted to each other run side by side, and a quarter of the pieces does.
const STEEPNESS: f64 = 0.5;
/// A piece is not cut where it could hold only so much more than what is known.
const CLOSE_ENOUGH: f64 = 1.01;

/// Where a distance was measured: a sample by its face, or a vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct Found {
    pub(super) distance: f64,
    pub(super) index: u32,
}

/// The faces that hold the furthest of these points, at most so many, in the order of their distances.
pub(super) fn promising_faces(
    mesh: &TriangleMesh,
    at_samples: &[Found],
    at_vertices: &[Found],
    greatest: f64,
    most: usize,
) -> Vec<u32> {
    let least = PROMISING * greatest;
    let mut far = vec![0.0f64; mesh.positions.len()];
    at_vertices.iter().for_each(|found| far[found.index as usize] = found.distance);
    let corners = (0u32..).zip(&mesh.faces).map(|(f, face)| Found {
        distance: face.iter().fold(0.0, |far_of: f64, &v| far_of.max(far[v as usize])),
        index: f,
    });
    let mut faces: Vec<Found> = at_samples.iter().copied().chain(corners).collect();
    faces.retain(|found| found.distance >= least && found.distance > 0.0);
    // Each face once, with the furthest of its points.
    faces.sort_by(|a, b| (a.index, b.distance.to_bits()).cmp(&(b.index, a.distance.to_bits())));
    faces.dedup_by_key(|found| found.index);
    faces.sort_by(|a, b| (b.distance.to_bits(), a.index).cmp(&(a.distance.to_bits(), b.index)));
    faces.truncate(most);
    faces.iter().map(|found| found.index).collect()
}

/// A piece of a face, and the greatest distance it is expected to hold at most.
struct Piece {
    bound: f64,
    corners: [DVec3; 3],
}

impl Ord for Piece {
    fn cmp(&self, other: &Self) -> Ordering {
        let key = |piece: &Self| piece.corners.map(|corner| corner.to_array());
        let by_place = || {
            key(self)
                .as_flattened()
                .iter()
                .zip(key(other).as_flattened())
                .fold(Ordering::Equal, |order, (a, b)| order.then_with(|| a.total_cmp(b)))
        };
        self.bound.total_cmp(&other.bound).then_with(by_place)
    }
}

impl PartialOrd for Piece {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Piece {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Piece {}

/// The greatest distance found in a face, or `known` if that is more.
pub(super) fn peak_of_face(mesh: &TriangleMesh, face: u32, target: &BoundingVolumes, known: f64) -> f64 {
    let mut cursor = target.cursor();
    let mut measured = |corners: [DVec3; 3]| {
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let distance = cursor.closest(middle.to_array()).squared_distance.sqrt();
        let radius = corners.iter().fold(0.0f64, |radius, corner| radius.max(corner.distance(middle)));
        (distance, Piece { bound: distance + STEEPNESS * radius, corners })
    };
    let (distance, whole) = measured(mesh.corners(FaceIndex(face)).map(DVec3::from));
    let mut greatest = known.max(distance);
    let mut open = BinaryHeap::from([whole]);
    let mut queries = 1;
    while let Some(Piece { bound, corners: [a, b, c] }) = open.pop() {
        if bound <= greatest * CLOSE_ENOUGH || queries + 4 > MOST_QUERIES {
            break;
        }
        let [ab, bc, ca] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
        for corners in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            let (distance, piece) = measured(corners);
            greatest = greatest.max(distance);
            open.push(piece);
        }
        queries += 4;
    }
    greatest
}
