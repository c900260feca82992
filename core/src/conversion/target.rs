//! The input as a target of fits: samples, normals, closest points, and its boundary.
//!
//! Boundaries pull apart from the rest: points of one boundary are drawn to the other boundary, in every direction but
//! along it.

use super::fitted::Fitted;
use super::normal_equations::Symmetric;
use super::pulls::{ALONG, Pull};
use crate::mesh::{AreaSampler, BoundingVolumes, ClosestPointCursor, FaceIndex, TriangleMesh};
use glam::DVec3;
use rayon::prelude::*;
use std::borrow::Cow;
use std::sync::atomic::{AtomicU64, Ordering};

/// Samples of the input for each face of the fitted surface.
const SAMPLES_PER_FACE: f64 = 2.0;

/// Faces of the input this much further from a point than the closest are as close: where they meet, which of them a search
/// finds is chance, and a surface of 24 bits is saved in steps of up to half as much. In the unit box.
const AS_CLOSE: f64 = 6e-8;
/// A triangle counts as turned over up to this cosine: coordinates in a file are rounded, and thin triangles with them.
pub(super) const TURNED: f64 = 0.02;

/// The input, ready for queries.
pub(super) struct Target<'m> {
    pub(super) mesh: &'m TriangleMesh,
    pub(super) tree: Cow<'m, BoundingVolumes>,
    /// Unit normals of its faces.
    pub(super) normals: Vec<DVec3>,
    pub(super) samples: Vec<DVec3>,
    /// For each sample a face it lies on.
    pub(super) sample_faces: Vec<u32>,
    /// How many of the samples are spread by area; vertices follow.
    pub(super) by_area: usize,
    boundary: Option<BoundaryCurve>,
    /// Boxes and triangles looked at by the closest points of fits so far: what attempts cost, on any machine.
    looks: AtomicU64,
}

/// The boundary of a surface.
struct BoundaryCurve {
    tree: BoundingVolumes,
    segments: Vec<[DVec3; 2]>,
    samples: Vec<DVec3>,
}

impl<'m> Target<'m> {
    /// [`Target::new_while`] to the end.
    pub(super) fn new(mesh: &'m TriangleMesh) -> Option<Self> {
        Self::new_while(mesh, None, &|| true)
    }

    /// Prepares the input, without samples yet, and its tree if there is none. `None` without faces, or when `go_on`
    /// answered no. Cost: linear, and a tree.
    pub(super) fn new_while(
        mesh: &'m TriangleMesh,
        tree: Option<&'m BoundingVolumes>,
        go_on: &dyn Fn() -> bool,
    ) -> Option<Self> {
        let tree = match tree {
            Some(tree) => Cow::Borrowed(tree),
            None => Cow::Owned(BoundingVolumes::build_while(mesh, &mut || go_on()).ok()??),
        };
        let corner = |v: u32| DVec3::from(mesh.positions[v as usize]);
        let normal = |f: &[u32; 3]| {
            let [a, b, c] = f.map(corner);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let normals = mesh.faces.par_iter().map(normal).collect();
        let whole = Fitted::new(mesh.positions.len(), &mesh.faces);
        let side = |&(f, k): &(u32, usize)| {
            let face = mesh.faces[f as usize];
            [corner(face[k]), corner(face[(k + 1) % 3])]
        };
        let boundary = curve(whole.boundary.iter().map(side).collect());
        Some(Self {
            mesh,
            tree,
            normals,
            samples: Vec::new(),
            sample_faces: Vec::new(),
            by_area: 0,
            boundary,
            looks: AtomicU64::new(0),
        })
    }

    /// With samples for the fit of a surface of `fitted_faces` faces.
    pub(super) fn sampled(mut self, fitted_faces: usize) -> Self {
        let mesh = self.mesh;
        self.by_area = (fitted_faces as f64 * SAMPLES_PER_FACE) as usize;
        let count = self.by_area as u64;
        (self.samples, self.sample_faces) = AreaSampler::new(mesh, count, 3)
            .points_and_faces(0..count)
            .map(|(point, face)| (point, face.0))
            .unzip();
        // Of a much finer input every so many vertices will do.
        let stride = (mesh.positions.len() / fitted_faces.max(1)).max(1);
        self.samples.extend(mesh.positions.iter().step_by(stride).map(|&p| DVec3::from(p)));
        let mut face_of = vec![0; mesh.positions.len()];
        for (f, face) in mesh.faces.iter().enumerate() {
            face.iter().for_each(|&v| face_of[v as usize] = f as u32);
        }
        self.sample_faces.extend(face_of.iter().step_by(stride));
        self
    }

    /// Adds to [`Target::looks`].
    pub(super) fn count_looks(&self, looks: u64) {
        self.looks.fetch_add(looks, Ordering::Relaxed);
    }

    /// How many boxes and triangles were looked at so far. A sum: the same at any number of threads.
    pub(super) fn looks(&self) -> u64 {
        self.looks.load(Ordering::Relaxed)
    }

    /// The cosine of a triangle's normal to that of the input nearest to its middle, the least where several of its faces are
    /// as near, -1 for a triangle without area and 0 where only such are near; and how far the middle is from the input.
    pub(super) fn beside(&self, [a, b, c]: [DVec3; 3], cursor: &mut ClosestPointCursor) -> (f64, f64) {
        let middle = ((a + b + c) / 3.0).to_array();
        let near = cursor.closest(middle);
        let distance = near.squared_distance.sqrt();
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { return (-1.0, distance) };
        let cosine = |f: FaceIndex| normal.dot(self.normals[f.0 as usize]);
        let mut least = f64::INFINITY;
        cursor.each_within(middle, distance + AS_CLOSE, |f| {
            if self.normals[f.0 as usize] != DVec3::ZERO {
                least = least.min(cosine(f));
            }
        });
        (if least.is_finite() { least } else { 0.0 }, distance)
    }

    /// Whether a triangle lies the other way than the input nearest to its middle, or nearly so.
    pub(super) fn is_turned(&self, corners: [DVec3; 3], cursor: &mut ClosestPointCursor) -> bool {
        self.beside(corners, cursor).0 <= TURNED
    }

    /// The point of the input's boundary closest to one; that itself if there is no boundary.
    pub(super) fn on_boundary(&self, point: DVec3) -> DVec3 {
        self.boundary.as_ref().map_or(point, |curve| curve.tree.closest(point.to_array()).point.into())
    }

    /// What the boundary of the input demands of that of the fitted surface, and the other way.
    pub(super) fn boundary_pulls(&self, fitted: &Fitted, positions: &[DVec3]) -> Vec<Pull> {
        let mut pulls = Vec::new();
        let Some(target) = &self.boundary else { return pulls };
        let segment = |&(f, k): &(u32, usize)| {
            let face = fitted.pattern.faces()[f as usize];
            [positions[face[k] as usize], positions[face[(k + 1) % 3] as usize]]
        };
        let Some(own) = curve(fitted.boundary.iter().map(segment).collect()) else {
            return pulls;
        };
        let on_side = |(f, k): (u32, usize), t: f64| {
            let mut weights = [0.0; 3];
            weights[k] = 1.0 - t;
            weights[(k + 1) % 3] = t;
            (f, weights)
        };
        let mut add = |(face, weights), gap, [p, q]: [DVec3; 2], weight| {
            let tangent = (q - p).normalize_or_zero();
            pulls.push(Pull { face, weights, gap, metric: Symmetric::about(tangent, ALONG, 1.0), weight });
        };
        for (side, [p, q]) in fitted.boundary.iter().zip(&own.segments) {
            for t in [0.0, 0.5] {
                let at = *p + (*q - *p) * t;
                let found = target.tree.closest(at.to_array());
                let along = target.segments[found.face.0 as usize];
                add(on_side(*side, t), DVec3::from(found.point) - at, along, 1.0);
            }
        }
        let share = (2.0 * own.segments.len() as f64 / target.samples.len() as f64).min(2.0);
        for sample in &target.samples {
            let found = own.tree.closest(sample.to_array());
            let [p, q] = own.segments[found.face.0 as usize];
            let at = DVec3::from(found.point);
            let length = p.distance(q);
            let t = if length > 0.0 { (p.distance(at) / length).min(1.0) } else { 0.0 };
            add(on_side(fitted.boundary[found.face.0 as usize], t), *sample - at, [p, q], share);
        }
        pulls
    }
}

/// Segments as a curve that can be asked for closest points; `None` without segments.
fn curve(segments: Vec<[DVec3; 2]>) -> Option<BoundaryCurve> {
    let positions = segments.iter().flatten().map(|p| p.to_array()).collect();
    // Triangles without area are answered as segments.
    let faces = (0..segments.len() as u32).map(|s| [2 * s, 2 * s + 1, 2 * s + 1]).collect();
    let tree = BoundingVolumes::build(&TriangleMesh::new(positions, faces))?;
    let samples = segments.iter().flat_map(|&[p, q]| [p, p + (q - p) * 0.5]).collect();
    Some(BoundaryCurve { tree, segments, samples })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ridge of less than 90°: over it, either slope is as near as the other.
    #[test]
    fn where_faces_meet_the_least_cosine_counts() {
        let positions = vec![[0.0, -1.0, 0.0], [0.0, 1.0, 0.0], [0.7, 0.0, -1.0], [-0.7, 0.0, -1.0]];
        let orders = [[[0, 2, 1], [0, 1, 3]], [[0, 1, 3], [0, 2, 1]]];
        for faces in orders {
            let mesh = TriangleMesh::new(positions.clone(), faces.to_vec());
            let target = Target::new(&mesh).expect("faces");
            for slope in &target.normals {
                let [u, v] = [DVec3::Y * 0.02, slope.cross(DVec3::Y) * 0.02];
                let middle = DVec3::Z * 0.01;
                let over = [middle - u - v, middle + u - v, middle + v * 2.0];
                let (cosine, distance) = target.beside(over, &mut target.tree.cursor());
                assert!((-0.5..-0.1).contains(&cosine) && (distance - 0.01).abs() < 1e-9, "{cosine}");
                assert!(target.is_turned(over, &mut target.tree.cursor()));
                let down = *slope * 0.01 + DVec3::new(0.7 * slope.x.signum(), 0.0, -1.0) * 0.2;
                let beside = over.map(|corner| corner - middle + down);
                assert!(target.beside(beside, &mut target.tree.cursor()).0 > 0.99);
            }
        }
    }

    /// Two sheets so near to each other that a saved surface cannot tell them apart.
    #[test]
    fn sheets_in_one_place_are_as_close() {
        let sheet = |z: f64| [[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
        for (gap, turned) in [(0.5 * AS_CLOSE, true), (2.0 * AS_CLOSE, false)] {
            let positions = [sheet(0.0), sheet(gap)].concat();
            let mesh = TriangleMesh::new(positions, vec![[0, 2, 1], [3, 4, 5]]);
            let target = Target::new(&mesh).expect("faces");
            let upper = sheet(gap).map(|p| DVec3::new(0.5 * p[0], 0.5 * p[1], p[2]));
            assert_eq!(target.is_turned(upper, &mut target.tree.cursor()), turned, "{gap}");
        }
    }
}
