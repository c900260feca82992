//! The surroundings of the bad places of a fit, as a surface of its own, and how it lies beside the input.
//!
//! Guarantees: sums are taken in an order that does not depend on threads.

use super::fit::{Faces, Smoothing, guarded, solve, turned_faces};
use super::fitted::Fitted;
use super::mend::Mending;
use super::normal_equations::FaceBlocks;
use super::pulls::{Pull, Pulls, barycentric};
use super::simplify::{Cancelled, ask};
use super::target::Target;
use crate::mesh::{BoundingVolumes, FaceIndex, TriangleMesh};
use glam::DVec3;
use rayon::prelude::*;

/// Normals belong to one sheet if their cosine is above this.
const SAME_SHEET: f64 = -0.2;
/// Queries one thread makes in a row.
const CHUNK: usize = 256;
/// Chunks between two questions whether to go on.
const BATCH: usize = 64;
/// A turned face counts as much as so many times the root mean square of greatest distance.
const TURNED: f64 = 12.0;
/// Greatest distances below this many times the root mean square are alike.
const FINE: f64 = 12.0;

/// Points of a face: corners, the middles of its sides, its middle, and three between.
pub(super) const POINTS: [[f64; 3]; 10] = {
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

/// A sample of the input.
pub(super) struct Sample {
    at: DVec3,
    normal: DVec3,
    part: u32,
}

/// The surroundings of all bad places, as a surface of its own.
pub(super) struct Patch {
    /// The vertices of the whole.
    pub(super) vertices: Vec<u32>,
    /// Whether each may move, and which of the parts, that have no face in common, it belongs to.
    pub(super) free: Vec<bool>,
    pub(super) part: Vec<u32>,
    pub(super) parts: usize,
    /// The first `own` faces have a vertex that may move; the others lie around them.
    fitted: Fitted,
    pub(super) own: usize,
    /// The input's normal at the place of each vertex.
    sheets: Vec<DVec3>,
    pub(super) samples: Vec<Sample>,
    /// The faces of the whole, and the part each of its own belongs to.
    pub(super) faces: Vec<u32>,
    pub(super) face_part: Vec<u32>,
}

/// A patch beside the input.
pub(super) struct Nearest {
    /// For each sample, then each point of the patch, what it asks for.
    pulls: Vec<(u32, Pull)>,
    /// Distances, to any sheet.
    pub(super) from_input: Vec<f64>,
    pub(super) from_fitted: Vec<f64>,
    /// For each face the sum of the input's normals near its points.
    normals: Vec<DVec3>,
    /// Whether the normal at the point closest to its middle is against its own.
    pub(super) turned: Vec<bool>,
    /// The greatest distance at each face.
    pub(super) greatest: Vec<f64>,
}

impl Patch {
    pub(super) fn around(mending: &Mending, pulls: &Pulls, bad: &[u32], rings: usize) -> Self {
        let whole = mending.fitted;
        let faces = whole.pattern.faces();
        let mut inside = vec![false; whole.pattern.vertices()];
        let mut front: Vec<u32> = bad.iter().flat_map(|&f| faces[f as usize]).collect();
        for _ in 0..rings {
            front.retain(|&v| !std::mem::replace(&mut inside[v as usize], true));
            front = front.iter().flat_map(|&v| whole.pattern.neighbours(v as usize)).copied().collect();
        }
        (0..inside.len()).for_each(|v| inside[v] &= whole.held.is_free(v));
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
        let sheets = vertices.iter().map(|&v| mending.sheets[v as usize]).collect();

        // Samples by the part they were closest to.
        let mut part_of = vec![u32::MAX; faces.len()];
        let mut face_part = Vec::with_capacity(own);
        for (&f, face) in list[..own].iter().zip(&local) {
            let corner = face.iter().find(|&&v| free[v as usize]).expect("a face of its own");
            part_of[f as usize] = part[*corner as usize];
            face_part.push(part[*corner as usize]);
        }
        let mut samples = Vec::new();
        for ((&at, &f), forth) in target.samples.iter().zip(&target.sample_faces).zip(&pulls.forth) {
            let part = part_of[forth.face as usize];
            if part != u32::MAX {
                samples.push(Sample { at, normal: target.normals[f as usize], part });
            }
        }
        // More on faces of the input that lie wholly at one part.
        let first = target.by_area;
        let coarse = target.samples.len() == first + target.mesh.positions.len();
        for (f, face) in target.mesh.faces.iter().enumerate().filter(|_| coarse) {
            let [part, q, r] = face.map(|v| part_of[pulls.forth[first + v as usize].face as usize]);
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
        Self { vertices, free, part, parts, fitted, own, sheets, samples, faces: list, face_part }
    }

    /// Which of the parts have at most so many faces together, taken by their size; and how many these have.
    pub(super) fn smallest_parts(&self, most_faces: usize) -> (Vec<bool>, usize) {
        let mut sizes = vec![0; self.parts];
        self.face_part.iter().for_each(|&part| sizes[part as usize] += 1);
        let mut by_size: Vec<usize> = (0..self.parts).collect();
        by_size.sort_by_key(|&part| (sizes[part], part));
        let (mut chosen, mut faces) = (vec![false; self.parts], 0);
        for part in by_size {
            if faces + sizes[part] > most_faces {
                break;
            }
            chosen[part] = true;
            faces += sizes[part];
        }
        (chosen, faces)
    }

    fn corners(&self, face: usize, at: &[DVec3]) -> [DVec3; 3] {
        self.fitted.pattern.faces()[face].map(|v| at[v as usize])
    }

    /// `tree` is over the patch, from a look before, or not made yet. `go_on` is asked after some hundredths of a second each
    /// time.
    ///
    /// # Errors
    /// The answer was no.
    pub(super) fn look(
        &self,
        target: &Target,
        tree: &mut Option<BoundingVolumes>,
        at: &[DVec3],
        active: &[bool],
        go_on: &dyn Fn() -> bool,
    ) -> Result<Nearest, Cancelled> {
        ask(go_on)?;
        let faces: Vec<u32> =
            (0..self.own as u32).filter(|&f| active[self.face_part[f as usize] as usize]).collect();
        let samples: Vec<u32> = (0..self.samples.len() as u32)
            .filter(|&s| active[self.samples[s as usize].part as usize])
            .collect();
        let surface = TriangleMesh::new(
            at.iter().map(|p| p.to_array()).collect(),
            self.fitted.pattern.faces().to_vec(),
        );
        match tree {
            Some(tree) => tree.refit(&surface),
            None => *tree = BoundingVolumes::build(&surface),
        }
        let tree = tree.as_ref().expect("a patch has faces");
        let sheet = |f: usize, weights| {
            blend(self.fitted.pattern.faces()[f].map(|v| self.sheets[v as usize]), weights)
        };
        let middles: Vec<DVec3> = (0..surface.faces.len()).map(|f| sheet(f, POINTS[0])).collect();
        let from_input = |samples: &[u32]| {
            let (mut free, mut held) = (tree.cursor(), tree.cursor());
            let pull = |&number: &u32| {
                let sample = &self.samples[number as usize];
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
                (number, Pull::new(found.face.0, weights, gap, sample.normal), distance)
            };
            samples.iter().map(pull).collect::<Vec<_>>()
        };
        let from_fitted = |faces: &[u32]| {
            let (mut free, mut held) = (target.tree.cursor(), target.tree.cursor());
            let mut found = Vec::with_capacity(faces.len() * POINTS.len());
            for &f in faces {
                let f = f as usize;
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
        let mut back: Vec<(Pull, f64, DVec3, DVec3)> = Vec::with_capacity(faces.len() * POINTS.len());
        for batch in faces.chunks(BATCH * CHUNK / 8) {
            ask(go_on)?;
            back.par_extend(batch.par_chunks(CHUNK / 8).flat_map_iter(from_fitted));
        }
        let mut forth: Vec<(u32, Pull, f64)> = Vec::with_capacity(samples.len());
        for batch in samples.chunks(BATCH * CHUNK) {
            ask(go_on)?;
            forth.par_extend(batch.par_chunks(CHUNK).flat_map_iter(from_input));
        }
        let mut normals = middles;
        normals[..self.own].fill(DVec3::ZERO);
        let mut turned = vec![false; self.own];
        let mut greatest = vec![0.0f64; self.own];
        let mut from_input = vec![0.0; self.samples.len()];
        let mut from_fitted = vec![0.0; self.own * POINTS.len()];
        let mut pulls = Vec::with_capacity(back.len() + forth.len());
        for (number, pull, distance) in forth {
            from_input[number as usize] = distance;
            if (pull.face as usize) < self.own {
                greatest[pull.face as usize] = greatest[pull.face as usize].max(distance);
            }
            pulls.push((number, pull));
        }
        for (k, (pull, distance, normal, near)) in back.into_iter().enumerate() {
            let f = pull.face as usize;
            let number = f * POINTS.len() + k % POINTS.len();
            normals[f] += normal;
            if k % POINTS.len() == 0 {
                let [a, b, c] = self.corners(f, at);
                turned[f] = (b - a).cross(c - a).dot(near) <= 0.0;
            }
            from_fitted[number] = distance;
            greatest[f] = greatest[f].max(distance);
            pulls.push(((self.samples.len() + number) as u32, pull));
        }
        Ok(Nearest { pulls, from_input, from_fitted, normals, turned, greatest })
    }

    /// The positions after a step.
    ///
    /// # Errors
    /// `go_on` answered no.
    pub(super) fn step(
        &self,
        look: &Nearest,
        at: &[DVec3],
        boosts: &(Vec<f64>, Vec<f64>),
        smoothing: f64,
        active: &[bool],
        go_on: &dyn Fn() -> bool,
    ) -> Result<Vec<DVec3>, Cancelled> {
        let n = self.vertices.len() as f64;
        let shares = [n / boosts.0.len() as f64, n / boosts.1.len() as f64];
        let mut blocks = vec![FaceBlocks::default(); self.fitted.pattern.faces().len()];
        for &(k, mut pull) in &look.pulls {
            let k = k as usize;
            pull.weight = match k.checked_sub(boosts.0.len()) {
                None => shares[0] * boosts.0[k],
                Some(k) => shares[1] * boosts.1[k],
            };
            pull.add_to(&mut blocks[pull.face as usize]);
        }
        let turned = turned_faces(&self.fitted, at, &look.normals);
        let faces = Faces { normals: &look.normals, turned: &turned };
        let delta = solve(
            &self.fitted,
            at,
            &blocks,
            faces,
            Smoothing { weight: smoothing, goal: None },
            &|v| self.free[v] && active[self.part[v] as usize],
            go_on,
        )?;
        Ok(guarded(&self.fitted, at, &delta, &look.normals))
    }
}

impl Patch {
    /// Every vertex that may move half the way to the middle of its neighbours.
    pub(super) fn smoothed(&self, at: &[DVec3], active: &[bool]) -> Vec<DVec3> {
        let smooth = |v: usize| {
            if !self.free[v] || !active[self.part[v] as usize] {
                return at[v];
            }
            let near = self.fitted.pattern.neighbours(v);
            let mean = near.iter().map(|&w| at[w as usize]).sum::<DVec3>() / near.len() as f64;
            (at[v] + mean) * 0.5
        };
        (0..at.len()).map(smooth).collect()
    }
}

impl Nearest {
    /// How bad each part is that is still worked on; the others are infinitely bad.
    pub(super) fn scores(&self, patch: &Patch, rms: f64, active: &[bool]) -> Vec<f64> {
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
        for f in 0..patch.own {
            let part = patch.face_part[f];
            turned[part as usize] += f64::from(u8::from(self.turned[f]));
            self.from_fitted[f * POINTS.len()..(f + 1) * POINTS.len()].iter().for_each(|&d| count(part, d));
        }
        (0..patch.parts)
            .map(|p| {
                if !active[p] {
                    return f64::INFINITY;
                }
                greatest[p].max(FINE * rms) + TURNED * rms * turned[p] + (sums[p].0 / sums[p].1).sqrt()
            })
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

pub(super) fn blend([a, b, c]: [DVec3; 3], weights: [f64; 3]) -> DVec3 {
    a * weights[0] + b * weights[1] + c * weights[2]
}
