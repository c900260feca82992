//! What pulls a surface toward the input: samples of both, each with the closest point of the other.

use super::fitted::Fitted;
use super::normal_equations::{FaceBlocks, Symmetric};
use super::target::Target;
use glam::DVec3;
use rayon::prelude::*;

/// Weight of a residual along the surface against one across it; keeps the system definite and the steps short. A
/// prototype found 0.01 to 0.1 equally good.
pub(super) const ALONG: f64 = 0.03;
/// Weight of a vertex as a sample, against one of the area samples: they matter to the maximum only.
const VERTEX_WEIGHT: f64 = 0.15;
/// Gaps below this (the diagonal is 1) have no direction; the normal stands in.
const NO_GAP: f64 = 1e-9;

/// One sample's demand on the fitted surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pull {
    /// The face of the fitted surface and the weights of its corners.
    pub(super) face: u32,
    pub(super) weights: [f64; 3],
    /// From the point of the fitted surface to where it should be.
    pub(super) gap: DVec3,
    pub(super) metric: Symmetric,
    pub(super) weight: f64,
}

/// The point of the fitted surface closest to a sample of the input.
#[derive(Debug, Clone, Copy)]
pub(super) struct Forth {
    pub(super) face: u32,
    pub(super) weights: [f64; 3],
    /// From there to the sample.
    pub(super) gap: DVec3,
}

/// The point of the input closest to a sample of the fitted surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Back {
    /// The face of the input.
    pub(super) face: u32,
    /// Whether it faces the other way: a face turned over, or led astray to the other side of a thin wall, is
    /// smoothed, not pulled.
    pub(super) against: bool,
    /// From the sample to there.
    pub(super) gap: DVec3,
}

/// All closest points at one iterate, and the distances.
pub(super) struct Pulls {
    /// How the samples were chosen.
    pub(super) look: Look,
    /// For each sample of the input that was looked at.
    pub(super) forth: Vec<Forth>,
    /// How many of them are spread by area; vertices follow.
    pub(super) by_area: usize,
    /// For each point inside a face of the fitted surface, face by face, then for each vertex.
    pub(super) back: Vec<Back>,
    /// Areas of the faces of the fitted surface.
    areas: Vec<f64>,
    /// The sum of the input's normals near each face of the fitted surface.
    pub(super) normals: Vec<DVec3>,
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

/// The middle of a face.
const MIDDLE: [[f64; 3]; 1] = [[1.0 / 3.0; 3]];
/// Points inside a face: exact for quadratic integrands.
const INSIDE: [[f64; 3]; 3] =
    [[2.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0], [1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0], [1.0 / 6.0, 1.0 / 6.0, 2.0 / 3.0]];

impl Look {
    /// The points of a face that are samples.
    pub(super) fn inside(self) -> &'static [[f64; 3]] {
        if self == Self::Rough { &MIDDLE } else { &INSIDE }
    }

    /// Every so many samples by area are looked at.
    pub(super) fn stride(self) -> usize {
        if self == Self::Rough { 2 } else { 1 }
    }
}

/// Factors on the weights of single samples, kept from iterate to iterate; those of a close look.
pub(super) struct Boosts {
    pub(super) from_input: Vec<f64>,
    pub(super) from_fitted: Vec<f64>,
}

impl Boosts {
    /// No sample weighs more than another of its kind.
    pub(super) fn even(target: &Target, fitted: &Fitted) -> Self {
        let count = INSIDE.len() * fitted.pattern.faces().len() + fitted.pattern.vertices();
        Self { from_input: vec![1.0; target.samples.len()], from_fitted: vec![1.0; count] }
    }
}

impl Pulls {
    pub(super) fn new(
        (target, fitted): (&Target, &Fitted),
        positions: &[DVec3],
        look: Look,
        forth: Vec<Forth>,
        back: Vec<Back>,
    ) -> Self {
        let area = |f: &[u32; 3]| {
            let [a, b, c] = f.map(|v| positions[v as usize]);
            (b - a).cross(c - a).length() * 0.5
        };
        let areas: Vec<f64> = fitted.pattern.faces().par_iter().map(area).collect();
        let total: f64 = areas.iter().sum();
        let by_area = target.by_area.div_ceil(look.stride());
        let per_face = look.inside().len();
        let near = |found: &[Back]| found.iter().map(|back| target.normals[back.face as usize]).sum();
        let normals = back[..per_face * areas.len()].par_chunks(per_face).map(near).collect();
        let squares =
            |gaps: &mut dyn Iterator<Item = DVec3>| gaps.map(|gap| gap.length_squared()).sum::<f64>();
        let from_input = squares(&mut forth[..by_area].iter().map(|forth| forth.gap)) / by_area as f64;
        let of_face = |(found, area): (&[Back], &f64)| squares(&mut found.iter().map(|back| back.gap)) * area;
        let from_fitted =
            back.chunks(per_face).zip(&areas).map(of_face).sum::<f64>() / total / per_face as f64;
        let gaps = forth.iter().map(|forth| forth.gap).chain(back.iter().map(|back| back.gap));
        let max = gaps.map(|gap| gap.length_squared()).fold(0.0, f64::max).sqrt();
        Self { look, forth, by_area, back, areas, normals, rms: from_input.max(from_fitted).sqrt(), max }
    }

    /// Whether some sample inside a face is closest to where the input faces the other way.
    pub(super) fn is_against(&self, face: usize) -> bool {
        let per_face = self.look.inside().len();
        self.back[face * per_face..(face + 1) * per_face].iter().any(|back| back.against)
    }

    /// What the samples on each face add to the system. Either way the area samples together weigh as much as there are
    /// vertices.
    pub(super) fn face_blocks(
        &self,
        (target, fitted): (&Target, &Fitted),
        positions: &[DVec3],
        boosts: &Boosts,
    ) -> Vec<FaceBlocks> {
        let faces = fitted.pattern.faces();
        let vertices = fitted.pattern.vertices() as f64;
        let inside = self.look.inside();
        let face_points = inside.len() * faces.len();
        let total: f64 = self.areas.iter().sum();
        let (starts, order) = self.by_face(faces.len());
        let by_area = vertices / self.by_area as f64;
        let by_vertex = VERTEX_WEIGHT * vertices / (self.forth.len() - self.by_area).max(1) as f64;
        let of_face = |f: usize| {
            let mut blocks = FaceBlocks::default();
            let [a, b, c] = faces[f].map(|v| positions[v as usize]);
            let normal = (b - a).cross(c - a);
            for &k in &order[starts[f] as usize..starts[f + 1] as usize] {
                let Forth { weights, gap, .. } = self.forth[k as usize];
                let k = k as usize;
                let share = if k < self.by_area { by_area } else { by_vertex };
                let weight =
                    share * boosts.from_input[if k < self.by_area { k * self.look.stride() } else { k }];
                Pull { weight, ..Pull::new(f as u32, weights, gap, normal) }.add_to(&mut blocks);
            }
            let mut add = |k: usize, weights, share: f64| {
                let Back { face, against, gap } = self.back[k];
                if !against {
                    let weight = share * boosts.from_fitted[k];
                    let normal = target.normals[face as usize];
                    Pull { weight, ..Pull::new(f as u32, weights, gap, normal) }.add_to(&mut blocks);
                }
            };
            // A face folded away must still be pulled.
            let share =
                vertices * self.areas[f] / total / inside.len() as f64 + 1e-3 * vertices / face_points as f64;
            for (k, weights) in inside.iter().enumerate() {
                add(f * inside.len() + k, *weights, share);
            }
            for (k, &v) in faces[f].iter().enumerate() {
                let own = fitted.pattern.corners(v as usize)[0] as usize == 3 * f + k;
                if own && face_points + (v as usize) < self.back.len() {
                    let mut weights = [0.0; 3];
                    weights[k] = 1.0;
                    add(face_points + v as usize, weights, VERTEX_WEIGHT);
                }
            }
            blocks
        };
        let mut blocks: Vec<FaceBlocks> = (0..faces.len()).into_par_iter().map(of_face).collect();
        for pull in target.boundary_pulls(fitted, positions) {
            pull.add_to(&mut blocks[pull.face as usize]);
        }
        blocks
    }

    /// The samples of the input by the face they are closest to: where each face's begin, and their numbers.
    pub(super) fn by_face(&self, faces: usize) -> (Vec<u32>, Vec<u32>) {
        let mut starts = vec![0u32; faces + 1];
        self.forth.iter().for_each(|forth| starts[forth.face as usize + 1] += 1);
        (0..faces).for_each(|f| starts[f + 1] += starts[f]);
        let mut at = starts.clone();
        let mut order = vec![0; self.forth.len()];
        for (k, forth) in (0..).zip(&self.forth) {
            let place = &mut at[forth.face as usize];
            order[*place as usize] = k;
            *place += 1;
        }
        (starts, order)
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
