//! Keeping a mesh on a distance field and its triangles even: projection and tangential relaxation.
//!
//! Guarantees: a relaxation never turns a face against the field that was not turned before; moves that would are taken
//! back. Results do not depend on the number of threads (every vertex is computed from the round before).
//!
//! Non-guarantees: a face that arrives turned is helped by its neighbours' motion, not repaired by force; count with
//! [`worst_cosine`].

use rayon::prelude::*;

use crate::distance_field::{gradient, project};
use crate::skin::{Skin, area_vector};
use crate::vector::Vec3;

/// A face counts as turned when the cosine between its normal and the field's falls below this: steep but honest walls
/// (a lip, a lid) on a coarse level stay above it, folds do not.
pub const TURNED_COSINE: f64 = 0.1;

/// The shape a mesh is kept on: its distance field, and how long edges should be here and there.
pub struct Target<'a> {
    /// Signed distance, negative inside.
    pub field: &'a (dyn Fn(Vec3) -> f64 + Sync),
    /// Relative edge length wanted at a place: 1 is ordinary, smaller is finer.
    pub spacing: &'a (dyn Fn(Vec3) -> f64 + Sync),
}

/// Moves every vertex onto the field along its gradient, at most `longest` a step.
pub fn project_all(skin: &mut Skin, target: &Target, longest: f64) {
    skin.positions.par_iter_mut().for_each(|p| *p = project(target.field, *p, longest));
}

/// Relaxes `rounds` times: each vertex goes part of the way, in its tangent plane, towards the mean of its neighbours
/// weighted by edge length over wanted spacing squared (at rest a row's lengths are then as wanted), then back onto the field. `pinned` vertices stay.
pub fn relax(skin: &mut Skin, target: &Target, pinned: &[u32], rounds: u32) {
    let neighbours = skin.neighbours();
    let mut movable = vec![true; skin.positions.len()];
    for &id in pinned {
        movable[id as usize] = false;
    }
    let mut turned = turned_faces(skin, target);
    for _ in 0..rounds {
        let mut tangled = vec![false; skin.positions.len()];
        for (_, face) in turned.iter().zip(&skin.faces).filter(|(turned, _)| **turned) {
            face.iter().for_each(|&corner| tangled[corner as usize] = true);
        }
        let proposed: Vec<Vec3> = (0..skin.positions.len())
            .into_par_iter()
            .map(|v| match (movable[v], tangled[v]) {
                (false, _) => skin.positions[v],
                (true, false) => moved(skin, target, v, &neighbours[v]),
                (true, true) => untangled(skin, target, v, &neighbours[v]),
            })
            .collect();
        turned = accept(skin, target, proposed, &turned);
    }
}

/// How many faces are turned, and the smallest cosine between a face's normal and the field's gradient at its middle.
pub fn worst_cosine(skin: &Skin, target: &Target) -> (usize, f64) {
    let cosines: Vec<f64> = skin.faces.par_iter().map(|&face| face_cosine(skin, target, face)).collect();
    let turned = cosines.iter().filter(|&&cosine| cosine < TURNED_COSINE).count();
    (turned, cosines.into_iter().fold(1.0, f64::min))
}

fn moved(skin: &Skin, target: &Target, vertex: usize, neighbours: &[u32]) -> Vec3 {
    /// Part of the way to the weighted mean: below one, so that opposite neighbours do not swap places.
    const PART: f64 = 0.5;
    let here = skin.positions[vertex];
    let (mut sum, mut total, mut nearest) = (Vec3::default(), 0.0, f64::INFINITY);
    for &id in neighbours {
        let offset = skin.positions[id as usize] - here;
        let length = offset.length();
        let wanted = (target.spacing)(here + offset * 0.5);
        let weight = length / (wanted * wanted);
        sum += offset * weight;
        total += weight;
        nearest = nearest.min(length);
    }
    if total <= 0.0 {
        return here;
    }
    let normal = gradient(target.field, here).normalised();
    let step = (sum * (PART / total)).without(normal);
    project(target.field, here + step, nearest.max(1e-3))
}

/// Straight to the middle of the neighbours, through the solid if need be: what pulls a fold apart.
fn untangled(skin: &Skin, target: &Target, vertex: usize, neighbours: &[u32]) -> Vec3 {
    let mut sum = Vec3::default();
    for &id in neighbours {
        sum += skin.positions[id as usize];
    }
    let middle = sum * (1.0 / neighbours.len() as f64);
    project(target.field, skin.positions[vertex] * 0.3 + middle * 0.7, 0.02)
}

/// Takes the proposed places except round faces they would newly turn; returns which faces are turned then.
fn accept(skin: &mut Skin, target: &Target, proposed: Vec<Vec3>, before: &[bool]) -> Vec<bool> {
    let old = std::mem::replace(&mut skin.positions, proposed);
    let mut after = turned_faces(skin, target);
    loop {
        let mut reverted = vec![false; old.len()];
        for (at, face) in skin.faces.iter().enumerate() {
            if after[at] && !before[at] {
                for &corner in face {
                    let corner = corner as usize;
                    reverted[corner] |= skin.positions[corner] != old[corner];
                    skin.positions[corner] = old[corner];
                }
            }
        }
        if !reverted.contains(&true) {
            return after;
        }
        let (faces, still) = (&skin.faces, &*skin);
        after.par_iter_mut().zip(faces).for_each(|(turned, &face)| {
            if face.iter().any(|&corner| reverted[corner as usize]) {
                *turned = face_cosine(still, target, face) < TURNED_COSINE;
            }
        });
    }
}

/// Which faces turn against the field: their normal and its gradient do not agree to [`TURNED_COSINE`].
pub fn turned_faces(skin: &Skin, target: &Target) -> Vec<bool> {
    skin.faces.par_iter().map(|&face| face_cosine(skin, target, face) < TURNED_COSINE).collect()
}

fn face_cosine(skin: &Skin, target: &Target, face: [u32; 3]) -> f64 {
    let corners = skin.corners(face);
    let middle = (corners[0] + corners[1] + corners[2]) * (1.0 / 3.0);
    // One Newton step takes the middle of a coarse face out to where its normal is to be compared.
    let slope = gradient(target.field, middle);
    let steepness = slope.dot(slope).max(1e-6);
    let reach = ((target.field)(middle) / steepness).clamp(-0.1, 0.1);
    let outward = if reach.abs() > 2e-3 { gradient(target.field, middle - slope * reach) } else { slope };
    area_vector(corners).normalised().dot(outward.normalised())
}
