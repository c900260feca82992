//! What pulls a surface toward the input: samples of both, each with the closest point of the other.
//!
//! Boundaries pull apart from the rest: points of one boundary are drawn to the other boundary, in every direction but
//! along it.

use super::held::Held;
use super::normal_equations::{FaceBlocks, Pattern, Symmetric};
use super::simplify::Cancelled;
use crate::mesh::{AreaSampler, BoundingVolumes, TriangleMesh};
use glam::DVec3;
use rayon::prelude::*;

/// Weight of a residual along the surface against one across it; keeps the system definite and the steps short. A
/// prototype found 0.01 to 0.1 equally good.
const ALONG: f64 = 0.03;
/// Samples of the input for each face of the fitted surface.
const SAMPLES_PER_FACE: f64 = 2.0;
/// Weight of a vertex as a sample, against one of the area samples: they matter to the maximum only.
const VERTEX_WEIGHT: f64 = 0.15;
/// Gaps below this (the diagonal is 1) have no direction; the normal stands in.
const NO_GAP: f64 = 1e-9;
/// Queries one thread makes in a row.
const CHUNK: usize = 1024;
/// Chunks between two questions whether to go on: some hundredths of a second on two threads.
const BATCH: usize = 16;
/// The middle of a face.
const MIDDLE: [[f64; 3]; 1] = [[1.0 / 3.0; 3]];
/// Points inside a face: exact for quadratic integrands.
const INSIDE: [[f64; 3]; 3] =
    [[2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0]];

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
}

struct BoundaryCurve {
    tree: BoundingVolumes,
    segments: Vec<[DVec3; 2]>,
    samples: Vec<DVec3>,
}

/// One sample's demand on the fitted surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pull {
    /// The face of the fitted surface and the weights of its corners.
    pub(super) face: u32,
    pub(super) weights: [f64; 3],
    /// From the point of the fitted surface to where it should be.
    pub(super) gap: DVec3,
    metric: Symmetric,
    pub(super) weight: f64,
}

/// All demands at one iterate, and the distances behind them.
pub(super) struct Pulls {
    /// Sorted by face.
    pulls: Vec<Pull>,
    starts: Vec<u32>,
    /// Distances of the input's samples.
    pub(super) from_input: Vec<f64>,
    /// The faces of the fitted surface closest to them.
    pub(super) hit: Vec<u32>,
    /// Distances of the fitted surface's samples: three in each face, then one at each vertex.
    pub(super) from_fitted: Vec<f64>,
    /// The normal of the input near each face of the fitted surface, not of unit length.
    pub(super) normals: Vec<DVec3>,
    /// Whether some sample on a face of the fitted surface is closest to where the input faces the other way.
    pub(super) against: Vec<bool>,
    /// Root mean square, the larger of both ways.
    pub(super) rms: f64,
    /// Greatest distance of any sample.
    pub(super) max: f64,
}

/// How closely to look.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Look {
    /// Half of the samples by area, one in each face: a third of the queries, enough for the first steps.
    Rough,
    /// All samples, and the vertices of both.
    Close,
}

/// Factors on the weights of single samples, kept from iterate to iterate.
pub(super) struct Boosts {
    pub(super) from_input: Vec<f64>,
    pub(super) from_fitted: Vec<f64>,
}

/// A fitted surface: fixed faces, moving vertices.
pub(super) struct Fitted {
    pub(super) pattern: Pattern,
    /// Boundary edges as face and corner they leave.
    boundary: Vec<(u32, usize)>,
    /// For each vertex its neighbours along the boundary, if it lies on one.
    pub(super) along_boundary: Vec<Option<[u32; 2]>>,
    /// What keeps vertices on sharp edges.
    pub(super) held: Held,
}

impl Fitted {
    pub(super) fn new(vertices: usize, faces: &[[u32; 3]]) -> Self {
        let pattern = Pattern::new(vertices, faces);
        let leaves = |f: u32, a: u32, b: u32| {
            let face = faces[f as usize];
            (0..3).any(|k| face[k] == a && face[(k + 1) % 3] == b)
        };
        let mut boundary = Vec::new();
        let mut along_boundary: Vec<Option<[u32; 2]>> = vec![None; vertices];
        for (f, face) in faces.iter().enumerate() {
            for k in 0..3 {
                let (a, b) = (face[k], face[(k + 1) % 3]);
                if !pattern.corners(a as usize).iter().any(|&c| leaves(c / 3, b, a)) {
                    boundary.push((f as u32, k));
                    along_boundary[a as usize].get_or_insert([u32::MAX; 2])[1] = b;
                    along_boundary[b as usize].get_or_insert([u32::MAX; 2])[0] = a;
                }
            }
        }
        Self { pattern, boundary, along_boundary, held: Held::default() }
    }

    fn mesh(&self, positions: &[DVec3]) -> TriangleMesh {
        TriangleMesh {
            positions: positions.iter().map(|p| p.to_array()).collect(),
            faces: self.pattern.faces().to_vec(),
        }
    }
}

impl<'m> Target<'m> {
    /// Prepares the input for a surface of `fitted_faces` faces. `None` without faces.
    pub(super) fn new(mesh: &'m TriangleMesh, fitted_faces: usize) -> Option<Self> {
        let tree = BoundingVolumes::build(mesh)?;
        let corner = |v: u32| DVec3::from(mesh.positions[v as usize]);
        let normals = mesh
            .faces
            .par_iter()
            .map(|f| {
                let [a, b, c] = f.map(corner);
                (b - a).cross(c - a).normalize_or_zero()
            })
            .collect();
        let by_area = (fitted_faces as f64 * SAMPLES_PER_FACE) as usize;
        let (mut samples, mut sample_faces): (Vec<DVec3>, Vec<u32>) =
            AreaSampler::new(mesh, by_area as u64, 3)
                .points_and_faces(0..by_area as u64)
                .map(|(point, face)| (point, face.0))
                .unzip();
        // Of a much finer input every so many vertices will do.
        let stride = (mesh.positions.len() / fitted_faces.max(1)).max(1);
        samples.extend(mesh.positions.iter().step_by(stride).map(|&p| DVec3::from(p)));
        let mut face_of = vec![0; mesh.positions.len()];
        for (f, face) in mesh.faces.iter().enumerate() {
            face.iter().for_each(|&v| face_of[v as usize] = f as u32);
        }
        sample_faces.extend(face_of.iter().step_by(stride));
        let whole = Fitted::new(mesh.positions.len(), &mesh.faces);
        let segments: Vec<[DVec3; 2]> = whole
            .boundary
            .iter()
            .map(|&(f, k)| {
                let face = mesh.faces[f as usize];
                [corner(face[k]), corner(face[(k + 1) % 3])]
            })
            .collect();
        let boundary = curve(segments);
        Some(Self { mesh, tree, normals, samples, sample_faces, by_area, boundary })
    }

    /// No sample weighs more than another of its kind.
    pub(super) fn boosts(&self, fitted: &Fitted) -> Boosts {
        let count = 3 * fitted.pattern.faces().len() + fitted.pattern.vertices();
        Boosts { from_input: vec![1.0; self.samples.len()], from_fitted: vec![1.0; count] }
    }

    /// Every sample's closest point on the other surface. `go_on` is asked some times a second.
    ///
    /// # Errors
    /// The answer was no.
    pub(super) fn pulls(
        &self,
        fitted: &Fitted,
        positions: &[DVec3],
        boosts: &Boosts,
        look: Look,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Pulls, Cancelled> {
        let inside: &[[f64; 3]] = if look == Look::Rough { &MIDDLE } else { &INSIDE };
        let (samples, by_area): (Vec<DVec3>, usize) = match look {
            Look::Rough => {
                (self.samples[..self.by_area].iter().step_by(2).copied().collect(), self.by_area.div_ceil(2))
            }
            Look::Close => (self.samples.clone(), self.by_area),
        };
        let vertices = fitted.pattern.vertices() as f64;
        let current = fitted.mesh(positions);
        let mut tree = None;
        let back = rayon::in_place_scope(|scope| {
            scope.spawn(|_| tree = BoundingVolumes::build(&current));
            self.samples_of_fitted(fitted, positions, inside, look == Look::Close, go_on)
        })?;
        let tree = tree.expect("a fitted surface has faces");
        let forth = samples_of_input(&samples, fitted, &tree, positions, go_on)?;

        // Weights: either way the area samples together weigh as much as there are vertices.
        let area = |f: &[u32; 3]| {
            let [a, b, c] = f.map(|v| positions[v as usize]);
            (b - a).cross(c - a).length() * 0.5
        };
        let areas: Vec<f64> = fitted.pattern.faces().par_iter().map(area).collect();
        let total: f64 = areas.iter().sum();
        let per_face = inside.len();
        let face_points = per_face * areas.len();
        let mut pulls = Vec::with_capacity(forth.len() + back.len());
        let (mut squares, mut max) = ([0.0; 2], 0.0f64);
        let mut from_input = Vec::with_capacity(forth.len());
        let mut hit = Vec::with_capacity(forth.len());
        for (k, mut pull) in forth.into_iter().enumerate() {
            let squared = pull.gap.length_squared();
            let is_area = k < by_area;
            pull.weight = boosts.from_input[k]
                * if is_area {
                    vertices / by_area as f64
                } else {
                    VERTEX_WEIGHT * vertices / (samples.len() - by_area) as f64
                };
            squares[0] += if is_area { squared / by_area as f64 } else { 0.0 };
            max = max.max(squared);
            from_input.push(squared.sqrt());
            hit.push(pull.face);
            pulls.push(pull);
        }
        let mut normals = vec![DVec3::ZERO; areas.len()];
        let mut against = vec![false; areas.len()];
        let mut from_fitted = Vec::with_capacity(back.len());
        for (k, (mut pull, normal)) in back.into_iter().enumerate() {
            let squared = pull.gap.length_squared();
            if k < face_points {
                against[k / per_face] |= pull.weight == 0.0;
            }
            pull.weight *= boosts.from_fitted[k]
                * if k < face_points {
                    normals[k / per_face] += normal;
                    let share = areas[k / per_face] / total / per_face as f64;
                    squares[1] += squared * share;
                    // A face folded away must still be pulled.
                    vertices * share + 1e-3 * vertices / face_points as f64
                } else {
                    VERTEX_WEIGHT
                };
            max = max.max(squared);
            from_fitted.push(squared.sqrt());
            pulls.push(pull);
        }
        self.boundary_pulls(fitted, positions, &mut pulls);
        let (pulls, starts) = by_face(pulls, areas.len());
        let rms = squares[0].max(squares[1]).sqrt();
        Ok(Pulls { pulls, starts, from_input, hit, from_fitted, normals, against, rms, max: max.sqrt() })
    }

    fn samples_of_fitted(
        &self,
        fitted: &Fitted,
        positions: &[DVec3],
        inside: &[[f64; 3]],
        vertices: bool,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Vec<(Pull, DVec3)>, Cancelled> {
        let faces = fitted.pattern.faces();
        let points = inside.len() * faces.len();
        let total = points + if vertices { positions.len() } else { 0 };
        let of_chunk = |chunk: usize| {
            let mut cursor = self.tree.cursor();
            let pull = |k: usize| {
                let (face, weights) = if k < points {
                    (k / inside.len(), inside[k % inside.len()])
                } else {
                    let corner = fitted.pattern.corners(k - points)[0] as usize;
                    let mut weights = [0.0; 3];
                    weights[corner % 3] = 1.0;
                    (corner / 3, weights)
                };
                let [a, b, c] = faces[face].map(|v| positions[v as usize]);
                let at = a * weights[0] + b * weights[1] + c * weights[2];
                let found = cursor.closest(at.to_array());
                let normal = self.normals[found.face.0 as usize];
                let gap = DVec3::from(found.point) - at;
                let metric = Symmetric::about(direction(gap, normal), 1.0, ALONG);
                // A face turned over, or led astray to the other side of a thin wall, is smoothed, not pulled.
                let against = (b - a).cross(c - a).dot(normal) < 0.0;
                (
                    Pull { face: face as u32, weights, gap, metric, weight: if against { 0.0 } else { 1.0 } },
                    normal,
                )
            };
            (chunk * CHUNK..((chunk + 1) * CHUNK).min(total)).map(pull).collect::<Vec<_>>()
        };
        in_batches(total.div_ceil(CHUNK), go_on, &of_chunk)
    }

    fn boundary_pulls(&self, fitted: &Fitted, positions: &[DVec3], pulls: &mut Vec<Pull>) {
        let Some(target) = &self.boundary else { return };
        let segment = |&(f, k): &(u32, usize)| {
            let face = fitted.pattern.faces()[f as usize];
            [positions[face[k] as usize], positions[face[(k + 1) % 3] as usize]]
        };
        let Some(own) = curve(fitted.boundary.iter().map(segment).collect()) else { return };
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
    }
}

fn samples_of_input(
    samples: &[DVec3],
    fitted: &Fitted,
    tree: &BoundingVolumes,
    positions: &[DVec3],
    go_on: &dyn Fn() -> bool,
) -> Result<Vec<Pull>, Cancelled> {
    let of_chunk = |chunk: usize| {
        let points = &samples[chunk * CHUNK..((chunk + 1) * CHUNK).min(samples.len())];
        let mut cursor = tree.cursor();
        let pull = |p: &DVec3| {
            let found = cursor.closest(p.to_array());
            let corners = fitted.pattern.faces()[found.face.0 as usize].map(|v| positions[v as usize]);
            let gap = *p - DVec3::from(found.point);
            let [a, b, c] = corners;
            let direction = direction(gap, (b - a).cross(c - a));
            Pull {
                face: found.face.0,
                weights: barycentric(corners, found.point.into()),
                gap,
                metric: Symmetric::about(direction, 1.0, ALONG),
                weight: 0.0,
            }
        };
        points.iter().map(pull).collect::<Vec<_>>()
    };
    in_batches(samples.len().div_ceil(CHUNK), go_on, &of_chunk)
}

/// The answers of all chunks in order, asking after each batch of them whether to go on.
fn in_batches<T: Send>(
    chunks: usize,
    go_on: &dyn Fn() -> bool,
    of_chunk: &(impl Fn(usize) -> Vec<T> + Sync),
) -> Result<Vec<T>, Cancelled> {
    let mut all = Vec::with_capacity(chunks * CHUNK);
    for first in (0..chunks).step_by(BATCH) {
        if !go_on() {
            return Err(Cancelled);
        }
        all.par_extend((first..(first + BATCH).min(chunks)).into_par_iter().flat_map_iter(of_chunk));
    }
    Ok(all)
}

impl Pulls {
    /// What the samples on each face add to the system.
    pub(super) fn face_blocks(&self) -> Vec<FaceBlocks> {
        (0..self.starts.len() - 1)
            .into_par_iter()
            .map(|f| {
                let mut face = FaceBlocks::default();
                for pull in &self.pulls[self.starts[f] as usize..self.starts[f + 1] as usize] {
                    pull.add_to(&mut face);
                }
                face
            })
            .collect()
    }
}

impl Pull {
    /// A demand of weight 1 of a surface that bends across `normal`.
    pub(super) fn new(face: u32, weights: [f64; 3], gap: DVec3, normal: DVec3) -> Self {
        Self { face, weights, gap, metric: Symmetric::about(direction(gap, normal), 1.0, ALONG), weight: 1.0 }
    }

    /// What it adds to the system.
    pub(super) fn add_to(&self, face: &mut FaceBlocks) {
        let force = self.metric.times(self.gap) * self.weight;
        let mut at = 0;
        for a in 0..3 {
            face.right[a] += force * self.weights[a];
            for b in a..3 {
                face.blocks[at].add(&self.metric, self.weight * self.weights[a] * self.weights[b]);
                at += 1;
            }
        }
    }
}

/// Sorts pulls by face, keeping their order within one.
fn by_face(pulls: Vec<Pull>, faces: usize) -> (Vec<Pull>, Vec<u32>) {
    let mut starts = vec![0u32; faces + 1];
    pulls.iter().for_each(|pull| starts[pull.face as usize + 1] += 1);
    (0..faces).for_each(|f| starts[f + 1] += starts[f]);
    let mut at = starts.clone();
    let mut sorted = pulls.clone();
    for pull in pulls {
        let place = &mut at[pull.face as usize];
        sorted[*place as usize] = pull;
        *place += 1;
    }
    (sorted, starts)
}

/// Segments as a curve that can be asked for closest points; `None` without segments.
fn curve(segments: Vec<[DVec3; 2]>) -> Option<BoundaryCurve> {
    let positions = segments.iter().flatten().map(|p| p.to_array()).collect();
    // Triangles without area are answered as segments.
    let faces = (0..segments.len() as u32).map(|s| [2 * s, 2 * s + 1, 2 * s + 1]).collect();
    let tree = BoundingVolumes::build(&TriangleMesh { positions, faces })?;
    let samples = segments.iter().flat_map(|&[p, q]| [p, p + (q - p) * 0.5]).collect();
    Some(BoundaryCurve { tree, segments, samples })
}

fn direction(gap: DVec3, normal: DVec3) -> DVec3 {
    let length = gap.length();
    if length > NO_GAP { gap / length } else { normal.try_normalize().unwrap_or(DVec3::Z) }
}

/// Barycentric coordinates of a point of a triangle, clamped to it.
pub(super) fn barycentric([a, b, c]: [DVec3; 3], p: DVec3) -> [f64; 3] {
    let normal = (b - a).cross(c - a);
    let part = |q: DVec3, r: DVec3| (q - p).cross(r - p).dot(normal).max(0.0);
    let weights = [part(b, c), part(c, a), part(a, b)];
    let sum: f64 = weights.iter().sum();
    if sum > 0.0 { weights.map(|w| w / sum) } else { [1.0 / 3.0; 3] }
}
