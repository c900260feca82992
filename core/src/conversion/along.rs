//! Moving the vertices of a converted surface along it, to where something else would rather have them: the distance
//! to the input stays as small as a fit can make it.
//!
//! Based on: Friedel, Schröder, Khodakovsky 2004, *Variational normal meshes*, which optimises where vertices lie along
//! the surface together with the distance. There the goal is detail along normals; here the goal is the caller's.
//!
//! Guarantees: no step is made where it would turn a face over; vertices on sharp edges stay on them; the same input gives
//! the same result at any number of threads.

use super::clean::clean;
use super::fit::{Faces, Smoothing, guarded, solve, turned_faces};
use super::fitted::Fitted;
use super::held::Held;
use super::pulls::{Boosts, Look};
use super::remesh::{Frame, RemeshError};
use super::target::Target;
use super::watch::Watch;
use crate::hierarchy::Hierarchy;
use crate::mesh::TriangleMesh;
use glam::DVec3;

/// Rounds. On three scans the way left to the goal falls by half in the first two or three, and hardly any more after
/// ten.
const ROUNDS: usize = 10;
/// The last of them look at all samples.
const CLOSE: usize = 3;
/// Weight of the way to the goal, along the surface, against that of the samples. From 0.3 to 1 files become one or two
/// hundredths smaller.
const WEIGHT: f64 = 1.0;

/// Where vertices should be, from where they are; only the way there along the surface counts.
pub type Goal<'a> = dyn Fn(&[[f64; 3]]) -> Vec<[f64; 3]> + 'a;

/// Fits a surface to a mesh again, drawn along itself towards a goal. Positions are in model units, by slot of the finest
/// level; `progress` gets the share that is done and returns whether to go on. Cost: each of the ten rounds some three times a
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
    for round in 0..ROUNDS {
        let go_on = || progress(round as f32 / ROUNDS as f32);
        let look = if round + CLOSE < ROUNDS { Look::Rough } else { Look::Close };
        let pulls = watch.look(&at, look, &go_on)?;
        let turned = turned_faces(&fitted, &at, &pulls.normals);
        let model: Vec<[f64; 3]> = at.iter().map(|&p| frame.to_model(p)).collect();
        let there: Vec<DVec3> = goal(&model).into_iter().map(|p| frame.to_unit(p)).collect();
        let blocks = pulls.face_blocks((&target, &fitted), &at, &boosts);
        let faces = Faces { normals: &pulls.normals, turned: &turned };
        let smoothing = Smoothing { weight: WEIGHT, there: Some(&there) };
        let delta = solve(&fitted, &at, &blocks, faces, smoothing, &|_| true, &go_on)?;
        at = guarded(&fitted, &at, &delta, &pulls.normals);
    }
    Ok(at.into_iter().map(|p| frame.to_model(p)).collect())
}
