//! Spacing vertices evenly along the surface, coarse levels first: a coarse vertex carries its finer neighbourhood
//! with it, so what is uneven over long ways goes quickly.

use super::parameterise::OnFace;
use super::pulls::Fitted;
use super::simplify::Cancelled;
use super::walk::Ground;
use crate::hierarchy::{Hierarchy, Layout, Level, Slot};
use crate::mesh::connectivity::NONE;
use crate::mesh::{BoundingVolumes, TriangleMesh};
use glam::DVec3;
use rayon::prelude::*;

/// Rounds at each level, coarsest first and finest last.
const ROUNDS: usize = 8;
/// How many levels above the finest take part. Coarser vertices move so far that they fold the surface at features
/// smaller than their faces: with three, one scan had nine times as many folds.
const COARSER: u8 = 1;
/// Part of the way to the middle of the neighbours gone in a round.
const STEP: f64 = 0.6;
/// Rounds of taking moves back where faces would turn over.
const GUARD_ROUNDS: usize = 4;
/// Vertices one thread takes at a time.
const CHUNK: usize = 1024;

/// Moves the vertices of the finest level along the input surface. `O(n log n)` a round.
///
/// # Errors
/// The progress function asked to stop.
pub(super) fn relax(
    hierarchy: &Hierarchy,
    ground: &Ground,
    fitted: &Fitted,
    mut points: Vec<OnFace>,
    progress: &dyn Fn(f32) -> bool,
) -> Result<Vec<OnFace>, Cancelled> {
    let boundary = BoundaryWalk::new(ground);
    let finest = hierarchy.finest();
    let first = finest.0.saturating_sub(COARSER);
    for j in first..=finest.0 {
        let level = Level(j);
        let coarse = Fitted::new(hierarchy.layout(level).len() as usize, &hierarchy.triangles(level));
        let slots: Vec<usize> = (0..hierarchy.layout(level).len())
            .map(|s| hierarchy.refine_slot(level, finest, Slot(s)).index())
            .collect();
        for round in 0..ROUNDS {
            if !progress(
                (f32::from(j - first) + round as f32 / ROUNDS as f32) / f32::from(finest.0 - first + 1),
            ) {
                return Err(Cancelled);
            }
            let at: Vec<DVec3> = slots.iter().map(|&s| ground.place(&points[s])).collect();
            let moves = (0..at.len()).into_par_iter().map(|v| sideways(&coarse, &at, v)).collect();
            let moves = prolong(hierarchy, level, finest, moves);
            points = walked(ground, &boundary, fitted, &points, &moves);
        }
    }
    Ok(points)
}

/// A step toward the middle of the faces around, weighted by area, along the surface.
fn sideways(mesh: &Fitted, at: &[DVec3], v: usize) -> DVec3 {
    let here = at[v];
    if let Some([before, after]) = mesh.along_boundary[v] {
        let (p, q) = (at[before as usize], at[after as usize]);
        let tangent = (q - p).normalize_or_zero();
        return tangent * (p + (q - p) * 0.5 - here).dot(tangent) * STEP;
    }
    let (mut normal, mut middle, mut total) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for &corner in mesh.pattern.corners(v) {
        let [a, b, c] = mesh.pattern.faces()[corner as usize / 3].map(|w| at[w as usize]);
        let cross = (b - a).cross(c - a);
        let area = cross.length();
        normal += cross;
        middle += (a + b + c) / 3.0 * area;
        total += area;
    }
    match normal.try_normalize() {
        Some(normal) if total > 0.0 => {
            // Centroids lie a third short of the neighbours.
            let way = (middle / total - here) * 1.5;
            (way - normal * way.dot(normal)) * STEP
        }
        _ => DVec3::ZERO,
    }
}

/// Values at a level, linear between its vertices, at the vertices of a finer one.
fn prolong(hierarchy: &Hierarchy, from: Level, to: Level, mut values: Vec<DVec3>) -> Vec<DVec3> {
    for j in from.0..to.0 {
        let (coarse, fine) = (hierarchy.layout(Level(j)), hierarchy.layout(Level(j + 1)));
        values = (0..fine.len())
            .into_par_iter()
            .map(|s| {
                let site = fine.site(Slot(s));
                match Layout::coarsen(site) {
                    Some(even) => values[coarse.slot(even).index()],
                    None => {
                        let [a, b] = coarse.parents(site).map(|p| values[coarse.slot(p).index()]);
                        (a + b) * 0.5
                    }
                }
            })
            .collect();
    }
    values
}

/// Walks every vertex along its move, and takes those moves back that would turn a face over.
fn walked(
    ground: &Ground,
    boundary: &BoundaryWalk,
    fitted: &Fitted,
    points: &[OnFace],
    moves: &[DVec3],
) -> Vec<OnFace> {
    let mut next: Vec<OnFace> = (0..points.len())
        .into_par_iter()
        .with_min_len(CHUNK)
        .map(|v| {
            if fitted.along_boundary[v].is_some() {
                boundary.nearest(ground.place(&points[v]) + moves[v]).unwrap_or(points[v])
            } else {
                ground.walk(points[v], moves[v])
            }
        })
        .collect();
    let was = turned(ground, fitted, points);
    for _ in 0..GUARD_ROUNDS {
        let now = turned(ground, fitted, &next);
        let mut bad = false;
        for (face, (now, was)) in fitted.pattern.faces().iter().zip(now.into_iter().zip(&was)) {
            if now && !was {
                face.iter().for_each(|&v| next[v as usize] = points[v as usize]);
                bad = true;
            }
        }
        if !bad {
            break;
        }
    }
    next
}

/// Faces whose normal is against those of the input at their corners.
fn turned(ground: &Ground, fitted: &Fitted, points: &[OnFace]) -> Vec<bool> {
    let at: Vec<(DVec3, DVec3)> =
        points.par_iter().map(|point| (ground.place(point), ground.normal(point.face))).collect();
    let turned = |face: &[u32; 3]| {
        let [(a, n), (b, m), (c, o)] = face.map(|v| at[v as usize]);
        (b - a).cross(c - a).dot(n + m + o) <= 0.0
    };
    fitted.pattern.faces().par_iter().map(turned).collect()
}

/// The boundary of the input as something to walk along.
struct BoundaryWalk {
    tree: Option<BoundingVolumes>,
    segments: Vec<(u32, usize, [DVec3; 2])>,
}

impl BoundaryWalk {
    fn new(ground: &Ground) -> Self {
        let half_edges = 0..3 * ground.mesh.faces.len() as u32;
        let segments: Vec<(u32, usize, [DVec3; 2])> = half_edges
            .filter(|&h| ground.connectivity.twin(h) == NONE)
            .map(|h| {
                let (face, k) = (h / 3, h as usize % 3);
                let corners = ground.corners(face);
                (face, k, [corners[k], corners[(k + 1) % 3]])
            })
            .collect();
        let positions = segments.iter().flat_map(|(_, _, ends)| ends.map(|p| p.to_array())).collect();
        let faces = (0..segments.len() as u32).map(|s| [2 * s, 2 * s + 1, 2 * s + 1]).collect();
        Self { tree: BoundingVolumes::build(&TriangleMesh { positions, faces }), segments }
    }

    fn nearest(&self, p: DVec3) -> Option<OnFace> {
        let found = self.tree.as_ref()?.closest(p.to_array());
        let (face, k, [start, end]) = self.segments[found.face.0 as usize];
        let length = start.distance(end);
        let t = if length > 0.0 { (start.distance(found.point.into()) / length).min(1.0) } else { 0.0 };
        let mut weights = [0.0; 3];
        weights[k] = 1.0 - t;
        weights[(k + 1) % 3] = t;
        Some(OnFace { face, weights })
    }
}
