//! From the mirror image of one half of a nearly symmetric input to its other half.
//!
//! The image lies beside the input by what is uneven about it, which may be many edges of the finest level; a fit, that
//! draws every place to the nearest, folds it there. So it is first led over as a whole: the ways to the closest points are
//! averaged over ever smaller surroundings (after Thirion 1998, *Image matching as a diffusion process*), those to another
//! sheet left out. Vertices on curves are led to the input's curves, corners to its corners.
//!
//! Guarantees: where the image lies on the input nothing moves; the same input gives the same result at any number of threads.

use super::creases::Creases;
use super::fitted::Fitted;
use super::held::curves;
use super::mirror::Laid;
use super::simplify::Cancelled;
use super::target::Target;
use crate::hierarchy::Site;
use crate::mesh::{BoundingVolumes, TriangleMesh};
use glam::DVec3;
use rayon::prelude::*;

/// Rounds of averaging over neighbours, step by step.
const ROUNDS: [usize; 14] = [64, 64, 48, 48, 32, 32, 16, 16, 8, 8, 4, 4, 2, 2];
/// There is nothing to do where all vertices are nearer than this part of an edge.
const NEAR: f64 = 0.25;
/// A closest point is on the same sheet if the normals there are no further apart than this cosine.
const SAME_SHEET: f64 = 0.5;
/// No point is looked for further away than this, over the diagonal.
const FAR: f64 = 0.1;
/// A vertex that came this part of an edge has other normals beside it.
const MOVED: f64 = 0.1;

/// What a vertex is led to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Goal {
    Surface,
    Boundary,
    Crease,
    Corner,
}

/// The sharp edges of an input.
pub(super) struct Features<'a> {
    pub(super) mesh: &'a TriangleMesh,
    pub(super) creases: &'a Creases,
}

/// Leads the vertices over to the input; their normals follow. Cost: about as much as two steps of the fit, and next to
/// nothing for a symmetric input.
///
/// # Errors
/// `go_on` answered no.
pub(super) fn approach(
    target: &Target,
    features: &Features,
    laid: &mut Laid,
    go_on: &dyn Fn() -> bool,
) -> Result<(), Cancelled> {
    let Laid { fitted, places, sheets, .. } = laid;
    let area: f64 = fitted.pattern.faces().iter().map(|f| doubled_area(f, places)).sum::<f64>() * 0.5;
    let edge = (4.0 / 3f64.sqrt() * area / fitted.pattern.faces().len() as f64).sqrt();
    let goals = goals(&laid.hierarchy, &laid.pinned, fitted);
    let (mesh, creases) = (features.mesh, features.creases);
    let chains = curves(mesh, &creases.chains());
    let corners: Vec<DVec3> = (mesh.positions.iter().zip(&creases.corners))
        .filter(|(_, corner)| **corner)
        .map(|(&p, _)| p.into())
        .collect();
    let ways = |places: &[DVec3], normals: &[DVec3]| {
        let way = |(cursor, v): (&mut Option<_>, usize)| {
            let at = places[v];
            let to = match goals[v] {
                Goal::Surface => {
                    let found = cursor.get_or_insert_with(|| target.tree.cursor()).closest(at.to_array());
                    let beside = target.normals[found.face.0 as usize].dot(normals[v]);
                    (beside > SAME_SHEET).then(|| found.point.into())
                }
                Goal::Boundary => Some(target.on_boundary(at)),
                Goal::Crease => {
                    chains.as_ref().map(|tree: &BoundingVolumes| tree.closest(at.to_array()).point.into())
                }
                Goal::Corner => corners
                    .iter()
                    .copied()
                    .min_by(|p, q| p.distance_squared(at).total_cmp(&q.distance_squared(at))),
            };
            to.map(|to: DVec3| to - at).filter(|way| way.length() < FAR)
        };
        let chunks = places.len().div_ceil(CHUNK);
        let of_chunk = |chunk: usize| {
            let mut cursor = None;
            let numbers = chunk * CHUNK..((chunk + 1) * CHUNK).min(places.len());
            numbers.map(|v| way((&mut cursor, v))).collect::<Vec<_>>()
        };
        (0..chunks).into_par_iter().flat_map_iter(of_chunk).collect::<Vec<Option<DVec3>>>()
    };
    let before = places.clone();
    for (step, &rounds) in ROUNDS.iter().enumerate() {
        if !go_on() {
            return Err(Cancelled);
        }
        let ways = ways(places, &normals(fitted, places));
        let farthest = ways.iter().flatten().map(|way| way.length()).fold(0.0, f64::max);
        if step == 0 && farthest < NEAR * edge {
            return Ok(());
        }
        let mean = averaged(fitted, &ways, rounds);
        places.iter_mut().zip(mean).for_each(|(place, way)| *place += way);
    }
    let normals = normals(fitted, places);
    let ways = ways(places, &normals);
    for (v, way) in ways.into_iter().enumerate().filter(|&(v, _)| goals[v] != Goal::Surface) {
        places[v] += way.unwrap_or(DVec3::ZERO);
    }
    for v in (0..places.len()).filter(|&v| places[v].distance(before[v]) > MOVED * edge) {
        sheets[v] = normals[v];
    }
    Ok(())
}

/// Vertices a thread takes at a time.
const CHUNK: usize = 1024;

fn goals(hierarchy: &crate::hierarchy::Hierarchy, pinned: &[bool], fitted: &Fitted) -> Vec<Goal> {
    let layout = hierarchy.layout(hierarchy.finest());
    let mut goals: Vec<Goal> = (fitted.along_boundary.iter())
        .map(|along| if along.is_some() { Goal::Boundary } else { Goal::Surface })
        .collect();
    for ends in layout.sharp_edges() {
        ends.iter().for_each(|slot| goals[slot.index()] = Goal::Crease);
    }
    for v in (0..pinned.len() as u32).filter(|&v| pinned[v as usize]) {
        goals[layout.slot(Site::Base(v)).index()] = Goal::Corner;
    }
    goals
}

/// The ways averaged with those of neighbours, so many times; where there is none, those around count.
fn averaged(fitted: &Fitted, ways: &[Option<DVec3>], rounds: usize) -> Vec<DVec3> {
    let mut sums: Vec<(DVec3, f64)> =
        ways.iter().map(|way| way.map_or((DVec3::ZERO, 0.0), |way| (way, 1.0))).collect();
    for _ in 0..rounds {
        let of_vertex = |v: usize| {
            let near = fitted.pattern.neighbours(v);
            let share = 0.5 / near.len() as f64;
            let own = (sums[v].0 * 0.5, sums[v].1 * 0.5);
            near.iter().fold(own, |sum, &w| {
                let (way, weight) = sums[w as usize];
                (sum.0 + way * share, sum.1 + weight * share)
            })
        };
        sums = (0..sums.len()).into_par_iter().map(of_vertex).collect();
    }
    sums.into_iter().map(|(way, weight)| if weight > 1e-3 { way / weight } else { DVec3::ZERO }).collect()
}

/// Unit normals of the vertices.
fn normals(fitted: &Fitted, places: &[DVec3]) -> Vec<DVec3> {
    let faces = fitted.pattern.faces();
    let of_face = |c: &u32| {
        let [a, b, c] = faces[*c as usize / 3].map(|v| places[v as usize]);
        (b - a).cross(c - a)
    };
    let of_vertex =
        |v: usize| fitted.pattern.corners(v).iter().map(of_face).sum::<DVec3>().normalize_or_zero();
    (0..places.len()).into_par_iter().map(of_vertex).collect()
}

fn doubled_area(face: &[u32; 3], places: &[DVec3]) -> f64 {
    let [a, b, c] = face.map(|v| places[v as usize]);
    (b - a).cross(c - a).length()
}
