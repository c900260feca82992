//! Surfaces for tests: plain arrays, no hierarchy.

use std::collections::HashMap;

use glam::Vec3;

/// A mesh as the renderer takes it.
pub(super) struct Shape {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Vec<[f32; 3]>,
    pub(super) triangles: Vec<[u32; 3]>,
}

/// The unit octahedron, split `levels` times and blown up to the unit sphere. Its first six vertices lie on the
/// axes: +x, −x, +y, −y, +z, −z.
pub(super) fn sphere(levels: u32) -> Shape {
    let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let mut points = axes.to_vec();
    let mut triangles = Vec::new();
    for x in [0, 1] {
        for y in [2, 3] {
            for z in [4, 5] {
                let outwards = (x + y + z) % 2 == 0;
                triangles.push(if outwards { [x, y, z] } else { [x, z, y] });
            }
        }
    }
    for _ in 0..levels {
        triangles = split(&mut points, &triangles);
    }
    let normals: Vec<[f32; 3]> = points.iter().map(|p| p.to_array()).collect();
    Shape { positions: normals.clone(), normals, triangles }
}

/// Splits each triangle in four, new points at unit length.
fn split(points: &mut Vec<Vec3>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let mut middles = HashMap::new();
    let mut middle = |points: &mut Vec<Vec3>, a: u32, b: u32| {
        *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
            points.push((points[a as usize] + points[b as usize]).normalize());
            points.len() as u32 - 1
        })
    };
    let mut finer = Vec::with_capacity(triangles.len() * 4);
    for &[a, b, c] in triangles {
        let (ab, bc, ca) = (middle(points, a, b), middle(points, b, c), middle(points, c, a));
        finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    finer
}

/// Every edge of these triangles once.
pub(super) fn edges(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut edges: Vec<[u32; 2]> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]])
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    edges.sort_unstable();
    edges.dedup();
    edges
}
