//! Walking on a triangle mesh: straight on within a face, unfolded over each edge. A walker never changes sheets, as a
//! closest point may.

use super::parameterise::OnFace;
use crate::mesh::TriangleMesh;
use crate::mesh::connectivity::{Connectivity, NONE};
use glam::DVec3;

/// Edges crossed at most; a walk longer than that ends where it is.
const LONGEST: usize = 200;

/// A surface to walk on.
pub(super) struct Ground<'m> {
    pub(super) mesh: &'m TriangleMesh,
    pub(super) connectivity: &'m Connectivity<'m>,
}

impl Ground<'_> {
    /// Where the corners of a face are.
    pub(super) fn corners(&self, face: u32) -> [DVec3; 3] {
        self.mesh.faces[face as usize].map(|v| DVec3::from(self.mesh.positions[v as usize]))
    }

    /// Where a point is in space.
    pub(super) fn place(&self, point: &OnFace) -> DVec3 {
        let [a, b, c] = self.corners(point.face);
        a * point.weights[0] + b * point.weights[1] + c * point.weights[2]
    }

    /// The unit normal of a face, 0 for one without area.
    pub(super) fn normal(&self, face: u32) -> DVec3 {
        let [a, b, c] = self.corners(face);
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// The end of a walk from `start`, along `way` as nearly as the surface allows and no longer. It ends early at a
    /// boundary. Cost: one step for each edge crossed.
    pub(super) fn walk(&self, start: OnFace, way: DVec3) -> OnFace {
        let mut at = start;
        let normal = self.normal(at.face);
        let mut way = {
            let along = way - normal * way.dot(normal);
            // On a face that stands across the way, the way is as short as its shadow.
            let length = along.length();
            if length > 0.5 * way.length() { along * (way.length() / length) } else { along }
        };
        for _ in 0..LONGEST {
            let [a, b, c] = self.corners(at.face);
            let normal = (b - a).cross(c - a);
            let squared = normal.length_squared();
            if squared <= 0.0 || way == DVec3::ZERO {
                return at;
            }
            let speed = [c - b, a - c, b - a].map(|side| normal.cross(side).dot(way) / squared);
            let mut exit = (1.0, None);
            for (k, (weight, speed)) in at.weights.iter().zip(speed).enumerate() {
                if speed < 0.0 && -weight / speed < exit.0 {
                    exit = (-weight / speed, Some(k));
                }
            }
            let moved: [f64; 3] = std::array::from_fn(|k| (at.weights[k] + exit.0 * speed[k]).max(0.0));
            let sum: f64 = moved.iter().sum();
            if !sum.is_finite() || sum <= 0.0 {
                return at;
            }
            at.weights = moved.map(|w| w / sum);
            let Some(opposite) = exit.1 else { return at };
            at.weights[opposite] = 0.0;

            // Half-edge k runs from corner k to k + 1, so the one opposite corner k is k + 1.
            let k = (opposite + 1) % 3;
            let twin = self.connectivity.twin(3 * at.face + k as u32);
            if twin == NONE {
                return at;
            }
            let corners = [a, b, c];
            let along = (corners[(k + 1) % 3] - corners[k]).normalize_or_zero();
            way *= 1.0 - exit.0;
            let straight = way.dot(along);
            let across = (way - along * straight).length();
            let (face, k2) = (twin / 3, (twin % 3) as usize);
            let mut weights = [0.0; 3];
            weights[k2] = at.weights[(k + 1) % 3];
            weights[(k2 + 1) % 3] = at.weights[k];
            at = OnFace { face, weights };
            // Into the next face: its side runs the other way, and its inside lies to the left.
            let inward = self.normal(face).cross(-along);
            way = along * straight + inward * across;
        }
        at
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_walk_on_a_plane_is_straight() {
        let size = 9u32;
        let positions = (0..size * size)
            .map(|v| [f64::from(v % size), f64::from(v / size) + 0.1 * f64::from(v % 3), 0.0]);
        let mut faces = Vec::new();
        for y in 0..size - 1 {
            for x in 0..size - 1 {
                let v = y * size + x;
                faces.extend([[v, v + 1, v + size], [v + 1, v + size + 1, v + size]]);
            }
        }
        let mesh = TriangleMesh::new(positions.collect(), faces);
        let connectivity = Connectivity::build(size * size, mesh.faces.clone()).expect("a manifold");
        let ground = Ground { mesh: &mesh, connectivity: &connectivity };
        let start = OnFace { face: 40, weights: [0.2, 0.5, 0.3] };
        let from = ground.place(&start);
        for way in [DVec3::new(3.1, 2.2, 0.0), DVec3::new(-1.3, 0.7, 0.0), DVec3::new(0.01, -0.02, 0.0)] {
            let end = ground.place(&ground.walk(start, way));
            assert!(end.distance(from + way) < 1e-9, "{end} for {}", from + way);
        }
        // The boundary ends it.
        let end = ground.place(&ground.walk(start, DVec3::new(100.0, 0.0, 0.0)));
        assert!((end.x - 8.0).abs() < 1e-9);
    }

    #[test]
    fn a_walk_round_a_sphere_keeps_its_length() {
        let mesh = shapes::octahedron();
        let connectivity = Connectivity::build(6, mesh.faces.clone()).expect("a manifold");
        let ground = Ground { mesh: &mesh, connectivity: &connectivity };
        // Through the middles of six edges, a hexagon in a plane through the centre, back to the start.
        let start = OnFace { face: 3, weights: [0.5, 0.25, 0.25] };
        let way = DVec3::new(-0.5, 0.0, 0.5) * 6.0;
        let end = ground.walk(start, way);
        assert!(ground.place(&end).distance(ground.place(&start)) < 1e-9);
    }
}
