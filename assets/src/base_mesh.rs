//! The base mesh of the faun's head, placed by hand.
//!
//! Seven rings of eight vertices run round bust, neck, jaw, mouth, nose, brow and crown; a vertex closes them at
//! each end. Two quadrilaterals a side are pulled out into a horn and an ear. Only the model's left half (x ≥ 0) is
//! written down; the other is its mirror image.
//!
//! Guarantees: closed, genus 0, counter-clockwise from outside, valences 4 to 8.

use std::collections::BTreeMap;

use crate::faun::{ear_point, horn_point};
use crate::skin::Skin;
use crate::vector::{Vec3, vec3};

/// The base mesh and the vertices that stay where they are put.
pub struct BaseMesh {
    /// The triangles.
    pub skin: Skin,
    /// Vertices at tips (horns, ears, beard): a tangential relaxation would let them slide off.
    pub pinned: Vec<u32>,
}

/// Points of each ring from the middle of the front round the left to the middle of the back.
#[rustfmt::skip]
const RINGS: [[Vec3; 5]; 7] = [
    // bust
    [vec3(0.0, -0.93, 0.22), vec3(0.38, -0.93, 0.12), vec3(0.52, -0.93, -0.11), vec3(0.38, -0.93, -0.34), vec3(0.0, -0.93, -0.44)],
    // neck
    [vec3(0.0, -0.66, 0.13), vec3(0.20, -0.64, 0.04), vec3(0.27, -0.60, -0.14), vec3(0.20, -0.52, -0.34), vec3(0.0, -0.48, -0.41)],
    // beard and jaw
    [vec3(0.0, -0.84, 0.51), vec3(0.19, -0.46, 0.30), vec3(0.31, -0.35, 0.04), vec3(0.30, -0.28, -0.26), vec3(0.0, -0.20, -0.50)],
    // mouth
    [vec3(0.0, -0.27, 0.52), vec3(0.23, -0.24, 0.36), vec3(0.39, -0.06, 0.07), vec3(0.40, -0.06, -0.20), vec3(0.0, 0.02, -0.57)],
    // nose, cheekbone and the ear's upper root
    [vec3(0.0, -0.07, 0.66), vec3(0.25, 0.00, 0.39), vec3(0.43, 0.18, 0.06), vec3(0.43, 0.18, -0.22), vec3(0.0, 0.24, -0.62)],
    // brow
    [vec3(0.0, 0.23, 0.45), vec3(0.15, 0.31, 0.41), vec3(0.34, 0.36, 0.21), vec3(0.37, 0.42, -0.22), vec3(0.0, 0.48, -0.54)],
    // crown
    [vec3(0.0, 0.55, 0.34), vec3(0.08, 0.62, 0.22), vec3(0.30, 0.57, -0.01), vec3(0.25, 0.62, -0.22), vec3(0.0, 0.66, -0.33)],
];
const BOTTOM: Vec3 = vec3(0.0, -1.0, -0.11);
const TOP: Vec3 = vec3(0.0, 0.74, -0.02);
/// Ring and segment of the quadrilaterals that are pulled out.
const EAR: (usize, usize) = (3, 2);
const HORN: (usize, usize) = (5, 1);
/// The vertex at the tip of the beard.
const BEARD_TIP: (usize, usize) = (2, 0);

/// Builds the base mesh: 168 faces, 86 vertices.
pub fn head_base() -> BaseMesh {
    let mut half = Half::default();
    let columns = RINGS[0].len();
    let at = |ring: usize, column: usize| (ring * columns + column) as u32;
    half.positions.extend(RINGS.iter().flatten());
    let bottom = half.add(BOTTOM);
    let top = half.add(TOP);
    half.pinned.push(at(BEARD_TIP.0, BEARD_TIP.1));

    for column in 0..columns - 1 {
        half.faces.push([bottom, at(0, column + 1), at(0, column)]);
        let last = RINGS.len() - 1;
        half.faces.push([at(last, column), at(last, column + 1), top]);
        for ring in 0..last {
            // Counter-clockwise from outside, from the lower front.
            let quad =
                [at(ring, column), at(ring, column + 1), at(ring + 1, column + 1), at(ring + 1, column)];
            match (ring, column) {
                EAR => half.pull_out(quad, &[ear_ring(0.46)], ear_point(1.04, 0.0, 0.0)),
                HORN => half.pull_out(quad, &[horn_ring(0.34), horn_ring(0.72)], horn_point(1.045, 0.8, 0.0)),
                _ => half.split(quad),
            }
        }
    }
    half.mirrored()
}

/// Four points round the horn at `along` (0 root, 1 tip), in the order of the quadrilateral it grows from: the lower
/// front one is nearest the middle of the face, the lower back one the temple.
fn horn_ring(along: f64) -> [Vec3; 4] {
    [(0.8, -0.7), (0.8, 0.7), (-0.6, 0.7), (-0.6, -0.7)].map(|(front, side)| horn_point(along, front, side))
}

/// Four points round the ear at `along`: lower front, lower back, upper back, upper front.
fn ear_ring(along: f64) -> [Vec3; 4] {
    [(-0.8, 0.9), (-0.8, -0.9), (0.8, -0.9), (0.8, 0.9)].map(|(up, front)| ear_point(along, up, front))
}

/// The model's left half while it is being built.
#[derive(Default)]
struct Half {
    positions: Vec<Vec3>,
    faces: Vec<[u32; 3]>,
    pinned: Vec<u32>,
}

impl Half {
    fn add(&mut self, position: Vec3) -> u32 {
        self.positions.push(position);
        self.positions.len() as u32 - 1
    }

    /// Two triangles, by the diagonal from the first corner.
    fn split(&mut self, [a, b, c, d]: [u32; 4]) {
        self.faces.extend([[a, b, c], [a, c, d]]);
    }

    /// Grows a four-sided tube from `root` through `rings` to `tip`.
    fn pull_out(&mut self, root: [u32; 4], rings: &[[Vec3; 4]], tip: Vec3) {
        let mut lower = root;
        for ring in rings {
            let upper = ring.map(|position| self.add(position));
            for side in 0..4 {
                let next = (side + 1) % 4;
                self.split([lower[side], lower[next], upper[next], upper[side]]);
            }
            lower = upper;
        }
        let tip = self.add(tip);
        self.pinned.push(tip);
        for side in 0..4 {
            self.faces.push([lower[side], lower[(side + 1) % 4], tip]);
        }
    }

    /// Both halves, sharing the vertices with x = 0.
    fn mirrored(self) -> BaseMesh {
        let mut skin = Skin { positions: self.positions, faces: self.faces };
        let mut image = BTreeMap::new();
        for id in 0..skin.positions.len() as u32 {
            let position = skin.positions[id as usize];
            if position.x == 0.0 {
                image.insert(id, id);
            } else {
                image.insert(id, skin.positions.len() as u32);
                skin.positions.push(position.mirrored());
            }
        }
        let other: Vec<[u32; 3]> =
            skin.faces.iter().map(|[a, b, c]| [image[a], image[c], image[b]]).collect();
        skin.faces.extend(other);
        let mut pinned: Vec<u32> = self.pinned.iter().flat_map(|id| [*id, image[id]]).collect();
        pinned.sort_unstable();
        pinned.dedup();
        BaseMesh { skin, pinned }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::skin::area_vector;
    use std::collections::BTreeSet;

    /// Every directed edge once, and its opposite too.
    fn is_closed(skin: &Skin) -> bool {
        let mut edges = BTreeSet::new();
        skin.faces
            .iter()
            .all(|&[a, b, c]| [(a, b), (b, c), (c, a)].into_iter().all(|edge| edges.insert(edge)))
            && edges.iter().all(|&(a, b)| edges.contains(&(b, a)))
    }

    #[test]
    fn the_base_is_a_closed_sphere_of_modest_valences() {
        let skin = head_base().skin;
        assert!(is_closed(&skin));
        assert_eq!((skin.faces.len(), skin.positions.len()), (168, 86));
        // Closed with E = 3F/2, so V − E + F = V − F/2.
        assert_eq!(skin.positions.len() - skin.faces.len() / 2, 2);
        for (id, neighbours) in skin.neighbours().iter().enumerate() {
            assert!((4..=8).contains(&neighbours.len()), "vertex {id}: valence {}", neighbours.len());
        }
    }

    #[test]
    fn subdivision_keeps_it_closed_and_counts_as_expected() {
        let mut skin = head_base().skin;
        let (v0, f0) = (skin.positions.len(), skin.faces.len());
        for level in 1..=3 {
            skin = skin.subdivided();
            let side = 1usize << level;
            let expected = v0 + f0 * 3 / 2 * (side - 1) + f0 * (side - 1) * (side - 2) / 2;
            assert_eq!(
                (skin.positions.len(), skin.faces.len()),
                (expected, f0 * side * side),
                "level {level}"
            );
            assert!(is_closed(&skin), "level {level}");
        }
        assert!(skin.neighbours()[v0..].iter().all(|list| list.len() == 6));
    }

    #[test]
    fn faces_look_outwards() {
        let skin = head_base().skin;
        let six_volumes = skin.faces.iter().map(|&f| skin.corners(f)[0].dot(area_vector(skin.corners(f))));
        assert!(six_volumes.sum::<f64>() > 0.0);
    }

    #[test]
    fn halves_are_mirror_images() {
        let skin = head_base().skin;
        assert!(skin.positions.iter().all(|position| skin.positions.contains(&position.mirrored())));
    }
}
