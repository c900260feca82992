//! The input as a target of fits: samples, normals, closest points, and its boundary.
//!
//! Boundaries pull apart from the rest: points of one boundary are drawn to the other boundary, in every direction but
//! along it.

use super::fitted::Fitted;
use super::normal_equations::Symmetric;
use super::pulls::{ALONG, Pull};
use crate::mesh::{AreaSampler, BoundingVolumes, ClosestPointCursor, TriangleMesh};
use glam::DVec3;
use std::sync::atomic::{AtomicU64, Ordering};

/// Samples of the input for each face of the fitted surface.
const SAMPLES_PER_FACE: f64 = 2.0;

/// Normals of faces that meet where a normal is wanted are looked at if the first is no nearer than this cosine.
const PLAIN: f64 = 0.5;
/// They are found this far from the middle of a triangle, as a part of the way to its corners.
const BESIDE: f64 = 1e-4;

/// The input, ready for queries.
pub(super) struct Target<'m> {
    pub(super) mesh: &'m TriangleMesh,
    pub(super) tree: BoundingVolumes,
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
        Self::new_while(mesh, &|| true)
    }

    /// Prepares the input, without samples yet. `None` without faces, or when `go_on` answered no. Cost: linear, and a
    /// tree.
    pub(super) fn new_while(mesh: &'m TriangleMesh, go_on: &dyn Fn() -> bool) -> Option<Self> {
        let tree = BoundingVolumes::build_while(mesh, &mut || go_on()).ok()??;
        let corner = |v: u32| DVec3::from(mesh.positions[v as usize]);
        let normal = |f: &[u32; 3]| {
            let [a, b, c] = f.map(corner);
            (b - a).cross(c - a).normalize_or_zero()
        };
        let normals = mesh.faces.iter().map(normal).collect();
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

    /// The cosine of a triangle's normal to that of the input nearest to its middle, the least where faces of the input
    /// meet there, or -1 without area; and how far the middle is from the input.
    pub(super) fn beside(&self, [a, b, c]: [DVec3; 3], cursor: &mut ClosestPointCursor) -> (f64, f64) {
        let normal = (b - a).cross(c - a).try_normalize();
        let middle = (a + b + c) / 3.0;
        let mut at = |point: DVec3| {
            let near = cursor.closest(point.to_array());
            let cosine = normal.map_or(-1.0, |normal| normal.dot(self.normals[near.face.0 as usize]));
            (cosine, near.squared_distance.sqrt())
        };
        let (cosine, distance) = at(middle);
        if cosine > PLAIN || normal.is_none() {
            return (cosine, distance);
        }
        let least =
            [a, b, c].map(|corner| at(middle.lerp(corner, BESIDE)).0).into_iter().fold(cosine, f64::min);
        (least, distance)
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
