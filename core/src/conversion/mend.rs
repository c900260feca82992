//! The worst places of a fit, mended each by itself: faces that are turned over, and where the surfaces are far apart.
//!
//! Around each such place some rings of vertices are fitted again, with more samples, the worst weighing ever more. What
//! a sample is drawn to must face the same way as the sheet it came from: each vertex knows its place on the input, so
//! the sheets of a thin wall or a tight valley stay apart. Starts from the fit and from the places themselves.
//!
//! Guarantees: a place is changed only where that makes it better; vertices on sharp edges and those far from all
//! such places stay; the same input gives the same result at any number of threads.

use super::fit::Iterate;
use super::fitted::Fitted;
use super::patch::{POINTS, Patch};
use super::pulls::Pulls;
use super::simplify::{Cancelled, ask};
use super::target::Target;
use super::unfold::Unfolding;
use glam::DVec3;
use rayon::prelude::*;

/// A place is bad from this many times the root mean square on.
const BAD: f64 = 10.0;
/// Samples count among the worst of a place from this many times the root mean square on.
const WORST: f64 = 4.0;
/// The greatest factor on a worst sample's weight.
const GREATEST_BOOST: f64 = 3000.0;
/// Weight of evening out along the surface, against that of the samples.
const SMOOTHING: f64 = 0.03;

/// How a pass goes on from one step to the next.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Steps {
    /// By fits.
    Fit,
    /// By smoothing alone, as far as the distance allows: a face may lie across a crevice whose walls turn it over
    /// however it is fitted.
    Smooth,
}

/// One pass over the bad places.
struct Pass {
    by: Steps,
    /// Rings of vertices around what is bad that may move.
    rings: usize,
    /// Steps from each start.
    steps: usize,
    /// The first from the fit, the second from the true places.
    starts: usize,
    /// The smoothing at first: strong enough to unfold. It falls to [`SMOOTHING`] over half of the steps.
    smoothing: f64,
}

/// First a little around all; then ever further around what is left, starting from the true places too. On three
/// scans the greatest distance falls by a third to two thirds, with about as many queries as the fit makes.
const PASSES: [Pass; 4] = [
    Pass { by: Steps::Fit, rings: 2, steps: 8, starts: 1, smoothing: 0.3 },
    Pass { by: Steps::Fit, rings: 5, steps: 10, starts: 2, smoothing: 1.0 },
    Pass { by: Steps::Fit, rings: 7, steps: 14, starts: 2, smoothing: 1.0 },
    Pass { by: Steps::Smooth, rings: 1, steps: 12, starts: 2, smoothing: 1.0 },
];

/// What all passes may cost: faces looked at, for each face of the whole and for the whole. Where hundreds of folds cannot
/// be undone, parts grow over most of the surface and mending would take many times as long as the fit.
const LOOKS_PER_FACE: usize = 2;
const LOOKS: usize = 200_000;

/// A part this many times the root mean square bad is left alone.
const DONE: f64 = 14.0;
/// A part is mended enough when its score is this many times the root mean square.
const ENOUGH: f64 = 15.0;

/// What is to be mended.
pub(super) struct Mending<'a> {
    pub(super) target: &'a Target<'a>,
    pub(super) fitted: &'a Fitted,
    /// The normals of the input at the true places of the vertices.
    pub(super) sheets: &'a [DVec3],
    /// These places.
    pub(super) places: &'a [DVec3],
    /// What may be looked at in turning the last faces back; see [`Unfolding`].
    pub(super) unfolding: u64,
    /// Whether there is little to mend: without the dearer passes.
    pub(super) briefly: bool,
}

impl Mending<'_> {
    /// Mends the bad places of a fit that was looked at closely; returns the positions and how many faces stay turned over
    /// or without area.
    ///
    /// # Errors
    /// The progress function asked to stop.
    pub(super) fn run(
        &self,
        Iterate { mut positions, pulls }: Iterate,
        progress: &dyn Fn(f32) -> bool,
    ) -> Result<(Vec<DVec3>, usize), Cancelled> {
        let mut bad = self.bad(&positions, &pulls, &|| progress(0.0))?;
        let mut looks = LOOKS + LOOKS_PER_FACE * self.fitted.pattern.faces().len();
        for (k, pass) in PASSES.iter().enumerate() {
            if self.briefly && pass.starts > 1 && pass.by == Steps::Fit {
                continue;
            }
            let done = |part: f32| progress((k as f32 + part) / PASSES.len() as f32);
            // Half of what is left, but the last may have it all.
            let share = if k + 1 == PASSES.len() { looks } else { looks / 2 };
            let used;
            (bad, used) = self.pass(pass, &mut positions, &pulls, &bad, share, &done)?;
            looks -= used;
        }
        let turned = self.turned(&positions, &|| progress(1.0))?;
        let Self { target, fitted, places, .. } = *self;
        let corners = |face: &[u32; 3], positions: &[DVec3]| face.map(|v| positions[v as usize]);
        let is_flat = |corners| twice_area_over_longest(corners) < FLAT;
        let turned: Vec<u32> = (0u32..)
            .zip(fitted.pattern.faces().iter().zip(&turned))
            .filter(|(_, (face, turned))| **turned || is_flat(corners(face, &positions)))
            .map(|(f, _)| f)
            .collect();
        if turned.is_empty() {
            return Ok((positions, 0));
        }
        let unfolding = Unfolding { target, fitted, places, pulls: &pulls, looks: self.unfolding };
        let before = positions.clone();
        unfolding.run(&mut positions, &turned, &|| progress(1.0))?;
        let moved = |face: &[u32; 3]| face.iter().any(|&v| positions[v as usize] != before[v as usize]);
        let mut cursor = target.tree.cursor();
        let faces = (0u32..).zip(fitted.pattern.faces());
        let stay = faces
            .filter(|(f, face)| turned.binary_search(f).is_ok() || moved(face))
            .map(|(_, face)| corners(face, &positions))
            .filter(|&face| is_flat(face) || target.is_turned(face, &mut cursor));
        let count = stay.count();
        Ok((positions, count))
    }

    /// Mends what lies around `bad` faces, given in ascending order, the smallest parts first, as long as no more than so
    /// many faces are looked at; returns the faces where that was not enough, ascending, and how many looks it took at
    /// most.
    fn pass(
        &self,
        pass: &Pass,
        positions: &mut [DVec3],
        pulls: &Pulls,
        bad: &[u32],
        looks: usize,
        progress: &dyn Fn(f32) -> bool,
    ) -> Result<(Vec<u32>, usize), Cancelled> {
        ask(&|| progress(0.0))?;
        let patch = Patch::around(self, pulls, bad, pass.rings);
        if patch.own == 0 {
            return Ok((Vec::new(), 0));
        }
        let steps = pass.starts * (pass.steps + 1);
        let (chosen, faces) = patch.smallest_parts(looks / steps);
        let mut tree = None;
        let mut best: Vec<DVec3> = patch.vertices.iter().map(|&v| positions[v as usize]).collect();
        let mut least = vec![f64::INFINITY; patch.parts];
        let starts = &[&positions[..], self.places][..pass.starts];
        // What is not tried now stays bad.
        let is_bad = |f: u32| bad.binary_search(&f).is_ok();
        let mut worst: Vec<bool> =
            (0..patch.own).map(|f| !chosen[patch.face_part[f] as usize] && is_bad(patch.faces[f])).collect();
        for (k, start) in starts.iter().enumerate() {
            let mut at: Vec<DVec3> = (0..patch.vertices.len())
                .map(|v| if patch.free[v] { start[patch.vertices[v] as usize] } else { best[v] })
                .collect();
            let mut boosts = (vec![1.0; patch.samples.len()], vec![1.0; patch.own * POINTS.len()]);
            for step in 0..=pass.steps {
                let go_on = || progress((k * (pass.steps + 1) + step) as f32 / steps as f32);
                if !go_on() {
                    return Err(Cancelled);
                }
                let active: Vec<bool> =
                    least.iter().zip(&chosen).map(|(l, chosen)| *chosen && *l > DONE * pulls.rms).collect();
                if !active.contains(&true) {
                    break;
                }
                let look = patch.look(self.target, &mut tree, &at, &active, &go_on)?;
                let scores = look.scores(&patch, pulls.rms, &active);
                for v in (0..at.len()).filter(|&v| patch.free[v]) {
                    let part = patch.part[v] as usize;
                    if scores[part] < least[part] {
                        best[v] = at[v];
                    }
                }
                for (f, worst) in worst.iter_mut().enumerate() {
                    let part = patch.face_part[f] as usize;
                    if scores[part] < least[part] {
                        *worst = look.turned[f] || look.greatest[f] > ENOUGH * pulls.rms;
                    }
                }
                least.iter_mut().zip(&scores).for_each(|(least, score)| *least = least.min(*score));
                if step == pass.steps {
                    break;
                }
                if pass.by == Steps::Smooth {
                    at = patch.smoothed(&at, &active);
                    continue;
                }
                boost(&mut boosts.0, &look.from_input, pulls.rms);
                boost(&mut boosts.1, &look.from_fitted, pulls.rms);
                let fallen = (2.0 * step as f64 / pass.steps as f64).min(1.0);
                let smoothing = pass.smoothing * libm::pow(SMOOTHING / pass.smoothing, fallen);
                at = patch.step(&look, &at, &boosts, smoothing, &active, &go_on)?;
                for v in (0..at.len()).filter(|&v| patch.free[v] && !active[patch.part[v] as usize]) {
                    at[v] = best[v];
                }
            }
        }
        for (v, &at) in patch.vertices.iter().zip(&best) {
            positions[*v as usize] = at;
        }
        Ok(((0..patch.own).filter(|&f| worst[f]).map(|f| patch.faces[f]).collect(), faces * steps))
    }

    /// Faces that are turned over, slivers, and those where the surfaces are far apart.
    fn bad(
        &self,
        positions: &[DVec3],
        pulls: &Pulls,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Vec<u32>, Cancelled> {
        let far = BAD * pulls.rms;
        let faces = self.fitted.pattern.faces();
        let mut bad = self.turned(positions, go_on)?;
        ask(go_on)?;
        bad.iter_mut().enumerate().for_each(|(f, bad)| *bad |= pulls.is_against(f));
        for (f, face) in faces.iter().enumerate() {
            let [a, b, c] = face.map(|v| positions[v as usize]);
            bad[f] |= twice_area_over_longest([a, b, c]) < SLIVER;
        }
        for forth in &pulls.forth {
            bad[forth.face as usize] |= forth.gap.length() > far;
        }
        for (k, back) in pulls.back.iter().enumerate() {
            if back.gap.length() > far {
                let at_vertex = k.checked_sub(3 * faces.len());
                bad[at_vertex.map_or(k / 3, |v| self.fitted.pattern.corners(v)[0] as usize / 3)] = true;
            }
        }
        Ok((0..faces.len() as u32).filter(|&f| bad[f as usize]).collect())
    }
}

impl Mending<'_> {
    /// For each face whether the input nearest to its middle faces the other way.
    fn turned(&self, positions: &[DVec3], go_on: &dyn Fn() -> bool) -> Result<Vec<bool>, Cancelled> {
        let of_chunk = |faces: &[[u32; 3]]| {
            let mut cursor = self.target.tree.cursor();
            let turned =
                |face: &[u32; 3]| self.target.is_turned(face.map(|v| positions[v as usize]), &mut cursor);
            faces.iter().map(turned).collect::<Vec<_>>()
        };
        let faces = self.fitted.pattern.faces();
        let mut turned = Vec::with_capacity(faces.len());
        for batch in faces.chunks(BATCH * CHUNK) {
            ask(go_on)?;
            turned.par_extend(batch.par_chunks(CHUNK).flat_map_iter(of_chunk));
        }
        Ok(turned)
    }
}

/// Faces one thread looks at in a row, and chunks between two questions whether to go on.
const CHUNK: usize = 1024;
const BATCH: usize = 32;
/// A face is flat, as bad as one that is turned over, below this part.
const FLAT: f64 = 1e-4;
/// Twice the area of a sliver is less than this part of its longest side's square.
const SLIVER: f64 = 0.05;

/// Twice the area of a triangle over the square of its longest side; 0 for one without area.
pub(super) fn twice_area_over_longest([a, b, c]: [DVec3; 3]) -> f64 {
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    if longest > 0.0 { (b - a).cross(c - a).length() / longest } else { 0.0 }
}

/// Raises the weights of the worst samples.
fn boost(boosts: &mut [f64], distances: &[f64], rms: f64) {
    for (boost, distance) in boosts.iter_mut().zip(distances) {
        let excess = distance / (WORST * rms);
        *boost = (*boost * excess.clamp(0.8, 3.0)).clamp(1.0, GREATEST_BOOST);
    }
}

#[cfg(test)]
mod tests;
