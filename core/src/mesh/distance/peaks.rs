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
    let is_far = |found: &Found| found.distance >= least && found.distance > 0.0;
    let mut faces: Vec<Found> = at_samples.iter().copied().chain(corners).filter(is_far).collect();
    // Each face once, with the furthest of its points.
    faces.sort_by(|a, b| (a.index, b.distance.to_bits()).cmp(&(b.index, a.distance.to_bits())));
    faces.dedup_by_key(|found| found.index);
    faces.sort_by(|a, b| (b.distance.to_bits(), a.index).cmp(&(a.distance.to_bits(), b.index)));
    faces.truncate(most);
    faces.iter().map(|found| found.index).collect()
}

/// The greatest distance found in a face, or `known` if that is more.
pub(super) fn peak_of_face(mesh: &TriangleMesh, face: u32, target: &BoundingVolumes, known: f64) -> f64 {
    let mut cursor = target.cursor();
    // The distance at the middle of a piece, and the greatest it is expected to hold.
    let mut measured = |corners: [DVec3; 3]| {
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let distance = cursor.closest(middle.to_array()).squared_distance.sqrt();
        let radius = corners.iter().fold(0.0f64, |radius, corner| radius.max(corner.distance(middle)));
        (distance, distance + STEEPNESS * radius)
    };
    let whole = mesh.corners(FaceIndex(face)).map(DVec3::from);
    let (distance, bound) = measured(whole);
    let mut greatest = known.max(distance);
    let mut pieces = vec![whole];
    // The bits of numbers that are not negative are in their order.
    let mut open = BinaryHeap::from([(bound.to_bits(), 0)]);
    while let Some((bound, piece)) = open.pop() {
        if f64::from_bits(bound) <= greatest * CLOSE_ENOUGH || pieces.len() + 4 > MOST_QUERIES {
            break;
        }
        let [a, b, c] = pieces[piece];
        let [ab, bc, ca] = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
        for corners in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]] {
            let (distance, bound) = measured(corners);
            greatest = greatest.max(distance);
            open.push((bound.to_bits(), pieces.len()));
            pieces.push(corners);
        }
    }
    greatest
}
