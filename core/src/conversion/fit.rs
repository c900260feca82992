//! Fitting the finest level to the input: two-way squared distances, a few Gauss–Newton steps (after Friedel,
//! Schröder, Khodakovsky 2004, *Variational normal meshes*), then the greatest distance.
//!
//! Guarantees: the best iterate of the last steps is returned; a step that would turn a face over is not made
//! there; the same input gives the same result at any number of threads.

use super::fitted::Fitted;
use super::normal_equations::{FaceBlocks, Symmetric, System};
use super::pulls::{Boosts, Look, Pulls};
use super::simplify::{Cancelled, ask};
use super::target::Target;
use super::watch::Watch;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::Arc;

/// How to fit.
#[derive(Debug, Clone, Copy)]
pub(super) struct FitRules {
    /// Steps in all.
    pub(super) steps: usize,
    /// The first of them, that look at fewer samples.
    pub(super) rough: usize,
    /// The step from which the worst samples weigh more.
    pub(super) boost_from: usize,
    /// Weight of evening out along the surface, against that of the samples.
    pub(super) smoothing: f64,
}

/// Conjugate gradients end after so many iterations, or when the residual has fallen so far.
const SOLVER: (usize, f64) = (30, 1e-3);
/// A step moves no vertex further than this part of its mean edge.
const TRUST: f64 = 0.5;
/// Rounds of taking steps back where faces would turn over.
const GUARD_ROUNDS: usize = 4;
/// A sample counts among the worst from this many times the root mean square on.
const WORST: f64 = 4.0;
/// The greatest factor on a worst sample's weight.
const GREATEST_BOOST: f64 = 300.0;
/// What the greatest distance counts against the root mean square when iterates are compared.
const MAX_VALUE: f64 = 0.04;
/// Factor on the smoothing at the corners of faces that are turned over.
const UNFOLD: f64 = 5.0;

/// Weight by which a vertex that is not free is held.
const HELD: f64 = 1e6;

/// What evens a surface out along itself.
#[derive(Clone, Copy)]
pub(super) struct Smoothing<'a> {
    /// Against that of the samples.
    pub(super) weight: f64,
    /// Where vertices are drawn to, but for those of faces turned over; by default all to the middle of their neighbours.
    pub(super) goal: Option<Goals<'a>>,
}

/// Where vertices are drawn to.
#[derive(Clone, Copy)]
pub(super) struct Goals<'a> {
    pub(super) places: &'a [DVec3],
    /// The share of the weight that each has.
    pub(super) shares: &'a [f64],
}

/// What the faces of a fitted surface are like.
#[derive(Clone, Copy)]
pub(super) struct Faces<'a> {
    /// The normal of the input near each.
    pub(super) normals: &'a [DVec3],
    /// Whether it is turned over.
    pub(super) turned: &'a [bool],
}

/// Positions, and how they lie beside the input.
pub(super) struct Iterate {
    pub(super) positions: Vec<DVec3>,
    pub(super) pulls: Arc<Pulls>,
}

/// Fits positions; returns the best iterate: least root mean square, with some regard to the greatest distance.
///
/// # Errors
/// The progress function asked to stop.
pub(super) fn fit(
    target: &Target,
    fitted: &Fitted,
    start: Vec<DVec3>,
    rules: &FitRules,
    progress: &dyn Fn(f32) -> bool,
) -> Result<Iterate, Cancelled> {
    let mut boosts = Boosts::even(target, fitted);
    let mut watch = Watch::new(target, fitted);
    let mut positions = start;
    let mut best: Option<(f64, Iterate)> = None;
    for step in 0..=rules.steps {
        let go_on = || progress(step as f32 / (rules.steps + 1) as f32);
        let look = if step < rules.rough { Look::Rough } else { Look::Close };
        let pulls = watch.look(&positions, look, &go_on)?;
        let turned = turned_faces(fitted, &positions, &pulls.normals);
        let folds = turned.iter().filter(|turned| **turned).count();
        let score = pulls.rms + MAX_VALUE * pulls.max + folds as f64 * 1e-6;
        if look == Look::Close && best.as_ref().is_none_or(|best| score < best.0) {
            best = Some((score, Iterate { positions: positions.clone(), pulls: pulls.clone() }));
        }
        if step == rules.steps {
            break;
        }
        if step >= rules.boost_from {
            boost(&mut boosts, &pulls);
        }
        let faces = Faces { normals: &pulls.normals, turned: &turned };
        ask(&go_on)?;
        let blocks = pulls.face_blocks((target, fitted), &positions, &boosts);
        ask(&go_on)?;
        let smoothing = Smoothing { weight: rules.smoothing, goal: None };
        let delta = solve(fitted, &positions, &blocks, faces, smoothing, &|_| true, &go_on)?;
        positions = guarded(fitted, &positions, &delta, &pulls.normals);
    }
    let (_, best) = best.expect("the last iterate was looked at closely");
    Ok(best)
}

/// One step of every vertex that is `free`.
///
/// # Errors
/// `go_on` answered no.
pub(super) fn solve(
    fitted: &Fitted,
    positions: &[DVec3],
    blocks: &[FaceBlocks],
    faces: Faces,
    smoothing: Smoothing,
    free: &(dyn Fn(usize) -> bool + Sync),
    go_on: &dyn Fn() -> bool,
) -> Result<Vec<DVec3>, Cancelled> {
    let own = |v: usize, _: &Symmetric| {
        if !free(v) {
            let mut block = Symmetric::default();
            block.add(&Symmetric::about(DVec3::Z, 1.0, 1.0), HELD);
            return (block, DVec3::ZERO);
        }
        let (tangent, to_mean) = along_surface(fitted, positions, faces.normals, v);
        let folded = fitted.pattern.corners(v).iter().any(|&c| faces.turned[c as usize / 3]);
        let (way, weight) = match smoothing.goal {
            Some(Goals { places, shares }) if !folded => {
                (places[v] - positions[v], smoothing.weight * shares[v])
            }
            _ => (to_mean, smoothing.weight * if folded { UNFOLD } else { 1.0 }),
        };
        let mut block = Symmetric::default();
        block.add(&tangent, weight);
        // A trace across the surface keeps vertices no sample sees in place.
        block.add(&Symmetric::about(DVec3::Z, 1.0, 1.0), 1e-4);
        if let Some(stiffness) = fitted.held.stiffness(v, positions) {
            block.add(&stiffness, 1.0);
        }
        (block, tangent.times(way) * weight)
    };
    let system = System::assemble(&fitted.pattern, blocks, own);
    let mut delta = system.solve(SOLVER.0, SOLVER.1, go_on).ok_or(Cancelled)?;
    delta.iter_mut().enumerate().filter(|(v, _)| !free(*v)).for_each(|(_, d)| *d = DVec3::ZERO);
    Ok(delta)
}

/// The projection onto the directions a vertex may slide in, and the way to the middle of its neighbours.
fn along_surface(fitted: &Fitted, positions: &[DVec3], normals: &[DVec3], v: usize) -> (Symmetric, DVec3) {
    let here = positions[v];
    if let Some([before, after]) = fitted.held.along(v).or(fitted.along_boundary[v]) {
        let (p, q) = (positions[before as usize], positions[after as usize]);
        let tangent = (q - p).normalize_or_zero();
        return (Symmetric::about(tangent, 1.0, 0.0), p + (q - p) * 0.5 - here);
    }
    let normal = fitted.pattern.corners(v).iter().fold(DVec3::ZERO, |sum, &c| sum + normals[c as usize / 3]);
    let near = fitted.pattern.neighbours(v);
    let mean = near.iter().fold(DVec3::ZERO, |sum, &w| sum + positions[w as usize]) / near.len() as f64;
    match normal.try_normalize() {
        Some(normal) => (Symmetric::about(normal, 0.0, 1.0), mean - here),
        None => (Symmetric::about(DVec3::Z, 1.0, 1.0), mean - here),
    }
}

/// Raises the weights of the worst samples; those of others fall back slowly.
fn boost(boosts: &mut Boosts, pulls: &Pulls) {
    let line = WORST * pulls.rms;
    let raise = |(boost, gap): (&mut f64, DVec3)| {
        let excess = gap.length() / line;
        let wanted = if excess > 1.0 { *boost * excess.min(3.0) } else { (*boost * 0.9).max(1.0) };
        *boost = wanted.min(GREATEST_BOOST);
    };
    boosts.from_input.iter_mut().zip(pulls.forth.iter().map(|forth| forth.gap)).for_each(raise);
    boosts.from_fitted.iter_mut().zip(pulls.back.iter().map(|back| back.gap)).for_each(raise);
}

/// Faces whose normal is against that of the input near them.
pub(super) fn turned_faces(fitted: &Fitted, positions: &[DVec3], normals: &[DVec3]) -> Vec<bool> {
    let turned = |(face, normal): (&[u32; 3], &DVec3)| {
        let [a, b, c] = face.map(|v| positions[v as usize]);
        (b - a).cross(c - a).dot(*normal) <= 0.0
    };
    fitted.pattern.faces().par_iter().zip(normals).map(turned).collect()
}

/// The positions after a step: shortened to the trust region, and not made where it would turn a face over.
pub(super) fn guarded(
    fitted: &Fitted,
    positions: &[DVec3],
    delta: &[DVec3],
    normals: &[DVec3],
) -> Vec<DVec3> {
    let mut next: Vec<DVec3> = (0..positions.len())
        .into_par_iter()
        .map(|v| {
            let near = fitted.pattern.neighbours(v);
            let mean: f64 = near.iter().map(|&w| positions[w as usize].distance(positions[v])).sum::<f64>()
                / near.len() as f64;
            fitted.held.put(v, positions[v], positions[v] + delta[v].clamp_length_max(TRUST * mean))
        })
        .collect();
    let was = turned_faces(fitted, positions, normals);
    for round in 0..GUARD_ROUNDS {
        let now = turned_faces(fitted, &next, normals);
        let mut bad: Vec<u32> = now
            .iter()
            .zip(&was)
            .zip(fitted.pattern.faces())
            .filter(|((now, was), _)| **now && !**was)
            .flat_map(|(_, face)| *face)
            .collect();
        if bad.is_empty() {
            break;
        }
        bad.sort_unstable();
        bad.dedup();
        let keep = if round + 2 < GUARD_ROUNDS { 0.4 } else { 0.0 };
        for v in bad {
            let v = v as usize;
            next[v] = fitted.held.put(v, positions[v], positions[v] + (next[v] - positions[v]) * keep);
        }
    }
    next
}
