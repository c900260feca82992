//! Moving the vertices of a converted surface along it, to where something else would rather have them: the distance
//! to the input stays as small as a fit can make it.
//!
//! Based on: Friedel, Schröder, Khodakovsky 2004, *Variational normal meshes*, which optimises where vertices lie along
//! the surface together with the distance. There the goal is detail along normals; here the goal is the caller's.
//!
//! Guarantees: no step is made where it would turn a face over; vertices on sharp edges stay on them; the same input gives
//! the same result at any number of threads.

use super::clean::clean;
use super::fit::{Faces, Goals, Smoothing, guarded, solve, turned_faces};
use super::fitted::Fitted;
use super::held::Held;
use super::pulls::{Boosts, Look, Pulls};
use super::remesh::{Frame, RemeshError};
use super::target::Target;
use super::watch::Watch;
use crate::hierarchy::Hierarchy;
use crate::mesh::TriangleMesh;
use glam::DVec3;

/// Rounds. On three scans the way left to the goal falls by half in the first two or three, and hardly any more after
/// ten.
const ROUNDS: usize = 12;
/// The last of them look at all samples.
const CLOSE: usize = 3;
/// Weight of the way to the goal, along the surface, against that of the samples. From 0.3 to 1 files become one or two
/// hundredths smaller.
const WEIGHT: f64 = 1.0;

/// Samples this many times the root mean square apart, as the surface is given, take the weight of the vertices around by half:
/// where the surface bends within an edge, no way along it ends on the input.
const NEAR: f64 = 2.0;

/// Where vertices should be, from where they are; only the way there along the surface counts.
pub type Goal<'a> = dyn Fn(&[[f64; 3]]) -> Vec<[f64; 3]> + 'a;

/// Fits a surface to a mesh again, drawn along itself towards a goal. Positions are in model units, by slot of the finest
/// level; `progress` gets the share that is done and returns whether to go on. Cost: each of the twelve rounds some three times a
/// step of the fit in [`remesh`](super::remesh::remesh), and one call of `goal`.
///
/// # Errors
/// The mesh has no surface, or `progress` asked to stop.
pub fn move_along(
    mesh: &TriangleMesh,
    hierarchy: &Hierarchy,
    positions: &[[f64; 3]],
    goal: &Goal,
    progress: &dyn Fn(f32) -> bool,
) -> Result<Vec<[f64; 3]>, RemeshError> {
    let input = clean(mesh, 0.0).ok_or(RemeshError::Empty)?.to_mesh();
    let frame = Frame::around(&input).ok_or(RemeshError::Empty)?;
    let input = frame.into_unit(&input);
    let mut fitted = Fitted::new(positions.len(), &hierarchy.triangles(hierarchy.finest()));
    let target = Target::new(&input).ok_or(RemeshError::Empty)?.sampled(fitted.pattern.faces().len());
    let mut at: Vec<DVec3> = positions.iter().map(|&p| frame.to_unit(p)).collect();
    fitted.held = Held::on_own_curves(hierarchy, &at);
    let boosts = Boosts::even(&target, &fitted);
    let mut watch = Watch::new(&target, &fitted);
    let mut near = None;
    for round in 0..ROUNDS {
        let go_on = || progress(round as f32 / ROUNDS as f32);
        let look = if round + CLOSE < ROUNDS { Look::Rough } else { Look::Close };
        let pulls = watch.look(&at, look, &go_on)?;
        let turned = turned_faces(&fitted, &at, &pulls.normals);
        let model: Vec<[f64; 3]> = at.iter().map(|&p| frame.to_model(p)).collect();
        let there: Vec<DVec3> = goal(&model).into_iter().map(|p| frame.to_unit(p)).collect();
        let blocks = pulls.face_blocks((&target, &fitted), &at, &boosts);
        let faces = Faces { normals: &pulls.normals, turned: &turned };
        let shares = shares(&fitted, &pulls, *near.get_or_insert(NEAR * pulls.rms));
        let goal = Some(Goals { places: &there, shares: &shares });
        let smoothing = Smoothing { weight: WEIGHT, goal };
        let delta = solve(&fitted, &at, &blocks, faces, smoothing, &|_| true, &go_on)?;
        at = guarded(&fitted, &at, &delta, &pulls.normals);
    }
    Ok(at.into_iter().map(|p| frame.to_model(p)).collect())
}

/// What share of the weight vertices have: the less, the further apart the surfaces are around them.
fn shares(fitted: &Fitted, pulls: &Pulls, near: f64) -> Vec<f64> {
    let mut gaps = vec![0.0f64; fitted.pattern.faces().len()];
    let of_back = pulls.look.inside().len();
    let forth = pulls.forth.iter().map(|forth| (forth.face as usize, forth.gap));
    let back = pulls.back[..of_back * gaps.len()].iter().enumerate().map(|(k, back)| (k / of_back, back.gap));
    forth.chain(back).for_each(|(face, gap)| gaps[face] = gaps[face].max(gap.length_squared()));
    let share = |v: usize| {
        let corners = fitted.pattern.corners(v).iter();
        let gap = corners.map(|&c| gaps[c as usize / 3]).fold(0.0, f64::max);
        1.0 / (1.0 + gap / (near * near).max(f64::MIN_POSITIVE))
    };
    (0..fitted.pattern.vertices()).map(share).collect()
}
