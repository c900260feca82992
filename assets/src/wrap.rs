//! Wrapping a subdivided sphere onto a distance field: every vertex has a direction from a centre and lies where the
//! ray in that direction, coming from outside, first meets the surface.
//!
//! Directions are relaxed so that triangles come out even on the surface, not on the sphere. The mesh cannot fold as
//! long as directions do not.

use crate::vector::{Vec3, vec3};
use rayon::prelude::*;

/// From where rays come in: outside everything.
const OUTSIDE: f64 = 1.6;
/// Share of the estimated distance that a step takes: blended fields overestimate a little.
const CAUTION: f64 = 0.7;

/// A mesh on the field.
pub struct Wrapped {
    /// Unit directions from the centre.
    pub directions: Vec<Vec3>,
    /// Where they meet the surface.
    pub positions: Vec<Vec3>,
}

/// Where the ray from outside towards the centre first meets the surface.
pub fn meet(field: &(dyn Fn(Vec3) -> f64 + Sync), centre: Vec3, direction: Vec3) -> Vec3 {
    let mut along = OUTSIDE;
    for _ in 0..400 {
        let distance = field(centre + direction * along);
        if distance < 1e-6 || along < 0.02 {
            break;
        }
        along -= (distance * CAUTION).max(2e-6);
    }
    centre + direction * along
}

/// Wraps directions onto the field.
pub fn wrap(field: &(dyn Fn(Vec3) -> f64 + Sync), centre: Vec3, directions: Vec<Vec3>) -> Wrapped {
    let positions = directions.par_iter().map(|&d| meet(field, centre, d)).collect();
    Wrapped { directions, positions }
}

/// Evens the triangles: each direction goes part of the way to the mean of the neighbours' places, weighted by distance,
/// unless that would turn a face seen from the centre. `rounds` times.
pub fn relax(
    field: &(dyn Fn(Vec3) -> f64 + Sync),
    centre: Vec3,
    mesh: &mut Wrapped,
    faces: &[[u32; 3]],
    rounds: u32,
) {
    let around = faces_around(mesh.directions.len(), faces);
    for _ in 0..rounds {
        let proposed: Vec<Vec3> = (0..mesh.directions.len())
            .into_par_iter()
            .map(|v| evened(mesh, centre, faces, &around[v], v))
            .collect();
        mesh.directions = proposed;
        mesh.positions = mesh.directions.par_iter().map(|&d| meet(field, centre, d)).collect();
    }
}

fn faces_around(vertices: usize, faces: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut around = vec![Vec::new(); vertices];
    for (f, face) in faces.iter().enumerate() {
        for &v in face {
            around[v as usize].push(f as u32);
        }
    }
    around
}

fn evened(mesh: &Wrapped, centre: Vec3, faces: &[[u32; 3]], around: &[u32], v: usize) -> Vec3 {
    let here = mesh.positions[v];
    let (mut sum, mut total) = (Vec3::default(), 0.0);
    for &f in around {
        for &corner in &faces[f as usize] {
            let offset = mesh.positions[corner as usize] - here;
            let weight = offset.length();
            sum += offset * weight;
            total += weight;
        }
    }
    if total <= 0.0 {
        return mesh.directions[v];
    }
    let mut part = 0.4;
    while part > 0.02 {
        let moved = (here + sum * (part / total) - centre).normalised();
        let folds = around.iter().any(|&f| turned(mesh, faces[f as usize], v, moved));
        if !folds {
            return moved;
        }
        part *= 0.5;
    }
    mesh.directions[v]
}

/// Whether a face would no longer be seen counter-clockwise from outside, or nearly not.
fn turned(mesh: &Wrapped, face: [u32; 3], v: usize, moved: Vec3) -> bool {
    let [a, b, c] =
        face.map(|corner| if corner as usize == v { moved } else { mesh.directions[corner as usize] });
    let spread = (b - a).cross(c - a);
    spread.dot(a) < 0.15 * spread.length().max((b - a).dot(b - a))
}

/// The icosahedron's corners on the unit sphere, and its faces.
pub fn icosahedron() -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let g = (1.0 + 5f64.sqrt()) * 0.5;
    let mut corners = Vec::new();
    for (one, golden) in [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)] {
        corners.push(vec3(one, golden, 0.0).normalised());
    }
    for (one, golden) in [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)] {
        corners.push(vec3(0.0, one, golden).normalised());
    }
    for (one, golden) in [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)] {
        corners.push(vec3(golden, 0.0, one).normalised());
    }
    let faces = vec![
        [0, 11, 5],
        [0, 5, 1],
        [0, 1, 7],
        [0, 7, 10],
        [0, 10, 11],
        [1, 5, 9],
        [5, 11, 4],
        [11, 10, 2],
        [10, 7, 6],
        [7, 1, 8],
        [3, 9, 4],
        [3, 4, 2],
        [3, 2, 6],
        [3, 6, 8],
        [3, 8, 9],
        [4, 9, 5],
        [2, 4, 11],
        [6, 2, 10],
        [8, 6, 7],
        [9, 8, 1],
    ];
    (corners, faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_icosahedron_is_closed_and_faces_outwards() {
        let (corners, faces) = icosahedron();
        let mut edges = std::collections::BTreeSet::new();
        for face in &faces {
            let [a, b, c] = face.map(|v| corners[v as usize]);
            assert!((b - a).cross(c - a).dot(a) > 0.0, "{face:?}");
            for k in 0..3 {
                assert!(edges.insert((face[k], face[(k + 1) % 3])), "{face:?}: an edge twice");
            }
        }
        assert!(edges.iter().all(|&(a, b)| edges.contains(&(b, a))));
    }

    #[test]
    fn a_sphere_is_met_at_its_radius() {
        let field = |p: Vec3| p.length() - 0.5;
        let (directions, faces) = icosahedron();
        let mut mesh = wrap(&field, Vec3::default(), directions);
        relax(&field, Vec3::default(), &mut mesh, &faces, 3);
        assert!(mesh.positions.iter().all(|p| (p.length() - 0.5).abs() < 1e-4));
    }
}
