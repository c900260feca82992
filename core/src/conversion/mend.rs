//! The worst places of a fit, mended each by itself: faces that are turned over, and where the surfaces are far apart.
//!
//! Around each such place some rings of vertices are fitted again, with more samples, the worst weighing ever more. What
//! a sample is drawn to must face the same way as the sheet it came from: each vertex knows its place on the input, so
//! the sheets of a thin wall or a tight valley stay apart. Starts from the fit and from the places themselves.
//!
//! Guarantees: a place is changed only where that makes it better; vertices on a boundary and those far from all such
//! places stay; the same input gives the same result at any number of threads.

use super::fit::{Faces, guarded, solve, turned_faces};
use super::normal_equations::FaceBlocks;
use super::parameterise::OnFace;
use super::pulls::{Fitted, Look, Pull, Pulls, Target, barycentric};
use super::simplify::Cancelled;
use crate::mesh::{BoundingVolumes, FaceIndex, TriangleMesh};
use glam::DVec3;
use rayon::prelude::*;

/// A place is bad from this many times the root mean square on.
const BAD: f64 = 9.0;
/// Samples count among the worst of a place from this many times the root mean square on.
const WORST: f64 = 4.0;
/// Rings of vertices around what is bad that may move.
const RINGS: usize = 3;
/// Steps from each start.
const STEPS: usize = 10;
/// The greatest factor on a worst sample's weight.
const GREATEST_BOOST: f64 = 3000.0;
/// Normals belong to one sheet if their cosine is above this.
const SAME_SHEET: f64 = -0.2;
/// Weight of evening out along the surface, against that of the samples.
const SMOOTHING: f64 = 0.03;
/// Queries one thread makes in a row.
const CHUNK: usize = 256;
/// A turned face counts as much as so many times the root mean square of greatest distance.
const TURNED: f64 = 6.0;
/// Greatest distances below this many times the root mean square are alike.
const FINE: f64 = 10.0;

/// Points of a face: corners, the middles of its sides, its middle, and three between.
const POINTS: [[f64; 3]; 10] = {
    const T: f64 = 1.0 / 3.0;
    const H: f64 = 0.5;
    const S: f64 = 1.0 / 6.0;
    [
        [T, T, T],
        [1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 1.0],
        [H, H, 0.0],
        [0.0, H, H],
        [H, 0.0, H],
        [4.0 * S, S, S],
        [S, 4.0 * S, S],
        [S, S, 4.0 * S],
    ]
};

/// What is to be mended.
pub(super) struct Mending<'a> {
    pub(super) target: &'a Target<'a>,
    pub(super) fitted: &'a Fitted,
    /// The true places of the vertices on the input.
    pub(super) points: &'a [OnFace],
    pub(super) places: &'a [DVec3],
}

impl Mending<'_> {
    /// Mends the bad places of a fit.
    ///
    /// # Errors
    /// The progress function asked to stop.
    pub(super) fn run(
        &self,
        mut positions: Vec<DVec3>,
        progress: &dyn Fn(f32) -> bool,
    ) -> Result<Vec<DVec3>, Cancelled> {
        let pulls = self.target.pulls(self.fitted, &positions, &self.target.boosts(self.fitted), Look::Close);
        let patch = Patch::around(self, &pulls, &self.bad(&positions, &pulls));
        if patch.own == 0 {
            return Ok(positions);
        }
        let starts = [&positions[..], self.places];
        let mut best = patch.vertices.iter().map(|&v| positions[v as usize]).collect::<Vec<_>>();
        let mut least = vec![f64::INFINITY; patch.parts];
        let steps = starts.len() * (STEPS + 1);
        for (k, start) in starts.iter().enumerate() {
            let mut at: Vec<DVec3> = (0..patch.vertices.len())
                .map(|v| if patch.free[v] { start[patch.vertices[v] as usize] } else { best[v] })
                .collect();
            let mut boosts = (vec![1.0; patch.samples.len()], vec![1.0; patch.own * POINTS.len()]);
            for step in 0..=STEPS {
                if !progress((k * (STEPS + 1) + step) as f32 / steps as f32) {
                    return Err(Cancelled);
                }
                let look = patch.look(self.target, &at);
                let better: Vec<bool> = look
                    .scores(&patch, pulls.rms)
                    .iter()
                    .zip(&mut least)
                    .map(|(score, least)| {
                        let better = score < least;
                        *least = least.min(*score);
                        better
                    })
                    .collect();
                for v in (0..at.len()).filter(|&v| patch.free[v] && better[patch.part[v] as usize]) {
                    best[v] = at[v];
                }
                if step == STEPS {
                    break;
                }
                boost(&mut boosts.0, &look.from_input, pulls.rms);
                boost(&mut boosts.1, &look.from_fitted, pulls.rms);
                at = patch.step(&look, &at, &boosts);
            }
        }
        for (v, &at) in patch.vertices.iter().zip(&best) {
            positions[*v as usize] = at;
        }
        Ok(positions)
    }

    /// Faces that are turned over, slivers, and those where the surfaces are far apart.
    fn bad(&self, positions: &[DVec3], pulls: &Pulls) -> Vec<u32> {
        let far = BAD * pulls.rms;
        let mut bad = pulls.against.clone();
        let faces = self.fitted.pattern.faces();
        for (f, face) in faces.iter().enumerate() {
            let [a, b, c] = face.map(|v| positions[v as usize]);
            let longest =
                (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
            bad[f] |= (b - a).cross(c - a).length() < SLIVER * longest;
        }
        for (distance, &face) in pulls.from_input.iter().zip(&pulls.hit) {
            bad[face as usize] |= *distance > far;
        }
        for (k, distance) in pulls.from_fitted.iter().enumerate() {
            if *distance > far {
                let at_vertex = k.checked_sub(3 * faces.len());
                bad[at_vertex.map_or(k / 3, |v| self.fitted.pattern.corners(v)[0] as usize / 3)] = true;
            }
        }
        (0..faces.len() as u32).filter(|&f| bad[f as usize]).collect()
    }
}

/// Twice the area of a sliver is less than this part of its longest side's square.
const SLIVER: f64 = 0.05;

/// Raises the weights of the worst samples.
fn boost(boosts: &mut [f64], distances: &[f64], rms: f64) {
    for (boost, distance) in boosts.iter_mut().zip(distances) {
        let excess = distance / (WORST * rms);
        *boost = (*boost * excess.clamp(0.8, 3.0)).clamp(1.0, GREATEST_BOOST);
    }
}

/// A sample of the input.
struct Sample {
    at: DVec3,
    normal: DVec3,
    part: u32,
}

/// The surroundings of all bad places, as a surface of its own.
struct Patch {
    /// The vertices of the whole.
    vertices: Vec<u32>,
    /// Whether each may move, and which of the parts, that have no face in common, it belongs to.
    free: Vec<bool>,
    part: Vec<u32>,
    parts: usize,
    /// The first `own` faces have a vertex that may move; the others lie around them.
    fitted: Fitted,
    own: usize,
    /// The input's normal at the place of each vertex.
    sheets: Vec<DVec3>,
    samples: Vec<Sample>,
}

/// A patch beside the input.
struct Nearest {
    /// For each sample, then each point of the patch, what it asks for.
    pulls: Vec<Pull>,
    /// Distances, to any sheet.
    from_input: Vec<f64>,
    from_fitted: Vec<f64>,
    /// For each face the sum of the input's normals near its points.
    normals: Vec<DVec3>,
    /// Whether the normal at the point closest to its middle is against its own.
    turned: Vec<bool>,
}

impl Patch {
    fn around(mending: &Mending, pulls: &Pulls, bad: &[u32]) -> Self {
        let whole = mending.fitted;
        let faces = whole.pattern.faces();
        let movable = |v: u32| whole.along_boundary[v as usize].is_none();
        let mut inside = vec![false; whole.pattern.vertices()];
        let mut front: Vec<u32> = bad.iter().flat_map(|&f| faces[f as usize]).collect();
        for _ in 0..RINGS {
            front.retain(|&v| !std::mem::replace(&mut inside[v as usize], true));
            front = front.iter().flat_map(|&v| whole.pattern.neighbours(v as usize)).copied().collect();
        }
        (0..inside.len()).for_each(|v| inside[v] &= movable(v as u32));
        let touches = |f: usize, of: &[bool]| faces[f].iter().any(|&v| of[v as usize]);
        let mut list: Vec<u32> =
            (0..faces.len()).filter(|&f| touches(f, &inside)).map(|f| f as u32).collect();
        let own = list.len();
        let mut near = inside.clone();
        list.iter().flat_map(|&f| faces[f as usize]).for_each(|v| near[v as usize] = true);
        list.extend(
            (0..faces.len()).filter(|&f| touches(f, &near) && !touches(f, &inside)).map(|f| f as u32),
        );

        let mut number = vec![u32::MAX; inside.len()];
        let mut vertices = Vec::new();
        let local: Vec<[u32; 3]> = list
            .iter()
            .map(|&f| {
                faces[f as usize].map(|v| {
                    let number = &mut number[v as usize];
                    if *number == u32::MAX {
                        *number = vertices.len() as u32;
                        vertices.push(v);
                    }
                    *number
                })
            })
            .collect();
        let free: Vec<bool> = vertices.iter().map(|&v| inside[v as usize]).collect();
        let fitted = Fitted::new(vertices.len(), &local);
        let (part, parts) = components(&fitted, &free);
        let target = mending.target;
        let sheets =
            vertices.iter().map(|&v| target.normals[mending.points[v as usize].face as usize]).collect();

        // Samples by the part they were closest to.
        let mut part_of = vec![u32::MAX; faces.len()];
        for (k, &f) in list[..own].iter().enumerate() {
            let corner = local[k].into_iter().find(|&v| free[v as usize]).expect("a face of its own");
            part_of[f as usize] = part[corner as usize];
        }
        let mut samples = Vec::new();
        for ((&at, &f), &hit) in target.samples.iter().zip(&target.sample_faces).zip(&pulls.hit) {
            let part = part_of[hit as usize];
            if part != u32::MAX {
                samples.push(Sample { at, normal: target.normals[f as usize], part });
            }
        }
        // More on faces of the input that lie wholly at one part.
        let first = target.samples.len() - target.mesh.positions.len();
        for (f, face) in target.mesh.faces.iter().enumerate() {
            let [part, q, r] = face.map(|v| part_of[pulls.hit[first + v as usize] as usize]);
            if part == u32::MAX || part != q || part != r {
                continue;
            }
            let f = f as u32;
            let corners = target.mesh.corners(FaceIndex(f)).map(DVec3::from);
            for weights in &POINTS[4..7] {
                samples.push(Sample {
                    at: blend(corners, *weights),
                    normal: target.normals[f as usize],
                    part,
                });
            }
        }
        Self { vertices, free, part, parts, fitted, own, sheets, samples }
    }

    fn corners(&self, face: usize, at: &[DVec3]) -> [DVec3; 3] {
        self.fitted.pattern.faces()[face].map(|v| at[v as usize])
    }

    fn look(&self, target: &Target, at: &[DVec3]) -> Nearest {
        let surface = TriangleMesh {
            positions: at.iter().map(|p| p.to_array()).collect(),
            faces: self.fitted.pattern.faces().to_vec(),
        };
        let tree = BoundingVolumes::build(&surface).expect("a patch has faces");
        let sheet = |f: usize, weights| {
            blend(self.fitted.pattern.faces()[f].map(|v| self.sheets[v as usize]), weights)
        };
        let middles: Vec<DVec3> = (0..surface.faces.len()).map(|f| sheet(f, POINTS[0])).collect();
        let from_input = |samples: &[Sample]| {
            let (mut free, mut held) = (tree.cursor(), tree.cursor());
            let pull = |sample: &Sample| {
                let any = free.closest(sample.at.to_array());
                let distance = any.squared_distance.sqrt();
                let same = |f: FaceIndex| middles[f.0 as usize].dot(sample.normal) >= SAME_SHEET;
                let found = if same(any.face) {
                    any
                } else {
                    held.closest_where(sample.at.to_array(), f64::INFINITY, &same).unwrap_or(any)
                };
                let corners = self.corners(found.face.0 as usize, at);
                let weights = barycentric(corners, found.point.into());
                let gap = sample.at - DVec3::from(found.point);
                (Pull::new(found.face.0, weights, gap, sample.normal), distance)
            };
            samples.iter().map(pull).collect::<Vec<_>>()
        };
        let from_fitted = |faces: std::ops::Range<usize>| {
            let (mut free, mut held) = (target.tree.cursor(), target.tree.cursor());
            let mut found = Vec::with_capacity(faces.len() * POINTS.len());
            for f in faces {
                let corners = self.corners(f, at);
                for weights in POINTS {
                    let point = blend(corners, weights);
                    let any = free.closest(point.to_array());
                    let distance = any.squared_distance.sqrt();
                    let own = sheet(f, weights);
                    let same = |g: FaceIndex| target.normals[g.0 as usize].dot(own) >= SAME_SHEET;
                    let chosen = if same(any.face) {
                        any
                    } else {
                        held.closest_where(point.to_array(), f64::INFINITY, &same).unwrap_or(any)
                    };
                    let normal = target.normals[chosen.face.0 as usize];
                    let gap = DVec3::from(chosen.point) - point;
                    let near = target.normals[any.face.0 as usize];
                    found.push((Pull::new(f as u32, weights, gap, normal), distance, normal, near));
                }
            }
            found
        };
        let back: Vec<(Pull, f64, DVec3, DVec3)> = (0..self.own.div_ceil(CHUNK / 8))
            .into_par_iter()
            .flat_map_iter(|k| from_fitted(k * (CHUNK / 8)..((k + 1) * (CHUNK / 8)).min(self.own)))
            .collect();
        let forth: Vec<(Pull, f64)> = self.samples.par_chunks(CHUNK).flat_map_iter(from_input).collect();
        let mut normals = middles;
        normals[..self.own].fill(DVec3::ZERO);
        let mut turned = vec![false; normals.len()];
        for (k, (_, _, normal, near)) in back.iter().enumerate() {
            let f = k / POINTS.len();
            normals[f] += *normal;
            if k % POINTS.len() == 0 {
                let [a, b, c] = self.corners(f, at);
                turned[f] = (b - a).cross(c - a).dot(*near) <= 0.0;
            }
        }
        let from_input = forth.iter().map(|found| found.1).collect();
        let from_fitted = back.iter().map(|found| found.1).collect();
        let pulls = forth.into_iter().map(|f| f.0).chain(back.into_iter().map(|b| b.0)).collect();
        Nearest { pulls, from_input, from_fitted, normals, turned }
    }

    /// The positions after a step.
    fn step(&self, look: &Nearest, at: &[DVec3], boosts: &(Vec<f64>, Vec<f64>)) -> Vec<DVec3> {
        let n = self.vertices.len() as f64;
        let shares = [n / boosts.0.len() as f64, n / boosts.1.len() as f64];
        let mut blocks = vec![FaceBlocks::default(); self.fitted.pattern.faces().len()];
        for (k, pull) in look.pulls.iter().enumerate() {
            let mut pull = *pull;
            pull.weight = match k.checked_sub(boosts.0.len()) {
                None => shares[0] * boosts.0[k],
                Some(k) => shares[1] * boosts.1[k],
            };
            pull.add_to(&mut blocks[pull.face as usize]);
        }
        let turned = turned_faces(&self.fitted, at, &look.normals);
        let faces = Faces { normals: &look.normals, turned: &turned };
        let delta = solve(&self.fitted, at, &blocks, faces, SMOOTHING, &|v| self.free[v]);
        guarded(&self.fitted, at, &delta, &look.normals)
    }
}

impl Nearest {
    /// How bad each part is.
    fn scores(&self, patch: &Patch, rms: f64) -> Vec<f64> {
        let mut greatest = vec![0.0f64; patch.parts];
        let mut sums = vec![(0.0, 0.0); patch.parts];
        let mut turned = vec![0.0; patch.parts];
        let mut count = |part: u32, distance: f64| {
            let part = part as usize;
            greatest[part] = greatest[part].max(distance);
            sums[part].0 += distance * distance;
            sums[part].1 += 1.0;
        };
        for (sample, &distance) in patch.samples.iter().zip(&self.from_input) {
            count(sample.part, distance);
        }
        let faces = patch.fitted.pattern.faces();
        for (f, face) in faces[..patch.own].iter().enumerate() {
            let corner = face.iter().find(|&&v| patch.free[v as usize]).expect("a face of its own");
            let part = patch.part[*corner as usize];
            turned[part as usize] += f64::from(u8::from(self.turned[f]));
            self.from_fitted[f * POINTS.len()..(f + 1) * POINTS.len()].iter().for_each(|&d| count(part, d));
        }
        (0..patch.parts)
            .map(|p| greatest[p].max(FINE * rms) + TURNED * rms * turned[p] + (sums[p].0 / sums[p].1).sqrt())
            .collect()
    }
}

/// The parts of the free vertices that are joined by edges; how many.
fn components(fitted: &Fitted, free: &[bool]) -> (Vec<u32>, usize) {
    let mut part = vec![u32::MAX; free.len()];
    let mut parts = 0;
    for first in 0..free.len() {
        if !free[first] || part[first] != u32::MAX {
            continue;
        }
        part[first] = parts;
        let mut stack = vec![first];
        while let Some(v) = stack.pop() {
            for &w in fitted.pattern.neighbours(v) {
                if free[w as usize] && part[w as usize] == u32::MAX {
                    part[w as usize] = parts;
                    stack.push(w as usize);
                }
            }
        }
        parts += 1;
    }
    (part, parts as usize)
}

fn blend([a, b, c]: [DVec3; 3], weights: [f64; 3]) -> DVec3 {
    a * weights[0] + b * weights[1] + c * weights[2]
}
