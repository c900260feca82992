//! Decimation of a closed mesh by edge collapses in the order of their quadric error (Garland and Heckbert 1997), as
//! scanning programs do it: dense where the surface bends, sparse where it is flat, with valences of every kind.
//!
//! Guarantees: closed, oriented and simplicial stays so, as does the genus; the same mesh gives the same result.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use crate::skin::{Skin, area_vector, evenness};
use crate::vector::{Vec3, vec3};

/// Least evenness of a face that a collapse may leave, unless it was worse before.
const LEAST_EVEN: f64 = 0.25;
/// Least cosine between a face's normal before and after a collapse.
const LEAST_COSINE: f64 = 0.4;
/// Weight of the distance from the edge's middle, against that of the planes: it orders collapses where all is flat.
const MIDDLE_WEIGHT: f64 = 1e-3;

/// The squared distance from planes, as `p·A·p + 2 b·p + c`, weighted.
#[derive(Debug, Clone, Copy, Default)]
struct Quadric {
    diagonal: Vec3,
    off_diagonal: Vec3,
    linear: Vec3,
    constant: f64,
    weight: f64,
}

impl Quadric {
    /// The face's plane, weighted by its area times `importance`.
    fn of_face(corners: [Vec3; 3], importance: f64) -> Self {
        let doubled = area_vector(corners);
        let (n, weight) = (doubled.normalised(), 0.5 * doubled.length() * importance);
        let offset = -n.dot(corners[0]);
        Self {
            diagonal: vec3(n.x * n.x, n.y * n.y, n.z * n.z) * weight,
            off_diagonal: vec3(n.y * n.z, n.z * n.x, n.x * n.y) * weight,
            linear: n * (offset * weight),
            constant: offset * offset * weight,
            weight,
        }
    }

    fn plus(self, other: Self) -> Self {
        Self {
            diagonal: self.diagonal + other.diagonal,
            off_diagonal: self.off_diagonal + other.off_diagonal,
            linear: self.linear + other.linear,
            constant: self.constant + other.constant,
            weight: self.weight + other.weight,
        }
    }

    fn times(&self, p: Vec3) -> Vec3 {
        let (d, o) = (self.diagonal, self.off_diagonal);
        vec3(
            d.x * p.x + o.z * p.y + o.y * p.z,
            o.z * p.x + d.y * p.y + o.x * p.z,
            o.y * p.x + o.x * p.y + d.z * p.z,
        )
    }

    fn at(&self, p: Vec3) -> f64 {
        self.times(p).dot(p) + 2.0 * self.linear.dot(p) + self.constant
    }

    /// Where the quadric with a little pull towards `middle` is least: always one place, never far off.
    fn least(&self, middle: Vec3) -> Vec3 {
        let pull = 1e-2 * self.weight;
        let held = Self { diagonal: self.diagonal + vec3(pull, pull, pull), ..*self };
        let rhs = middle * pull - self.linear;
        let [a, b, c] =
            [vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0), vec3(0.0, 0.0, 1.0)].map(|axis| held.times(axis));
        let volume = a.dot(b.cross(c));
        vec3(rhs.dot(b.cross(c)), a.dot(rhs.cross(c)), a.dot(b.cross(rhs))) * (1.0 / volume)
    }
}

/// An edge in the queue, as it was when both ends had these stamps.
struct Candidate {
    cost: f64,
    ends: [u32; 2],
    stamps: [u32; 2],
    place: Vec3,
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then(self.ends.cmp(&other.ends))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Candidate {}

struct Decimator {
    skin: Skin,
    quadrics: Vec<Quadric>,
    stars: Vec<Vec<u32>>,
    stamps: Vec<u32>,
    queue: BinaryHeap<Reverse<Candidate>>,
}

/// Collapses edges until `target` faces are left or none can go; `importance` is what squared distance weighs at a
/// place. The mesh must be closed and manifold.
pub fn decimate(skin: &Skin, target: usize, importance: &dyn Fn(Vec3) -> f64) -> Skin {
    let count = skin.positions.len();
    let mut stars = vec![Vec::with_capacity(8); count];
    let mut quadrics = vec![Quadric::default(); count];
    for (f, face) in (0u32..).zip(&skin.faces) {
        let corners = skin.corners(*face);
        let quadric =
            Quadric::of_face(corners, importance((corners[0] + corners[1] + corners[2]) * (1.0 / 3.0)));
        for &v in face {
            stars[v as usize].push(f);
            quadrics[v as usize] = quadrics[v as usize].plus(quadric);
        }
    }
    let queue = BinaryHeap::with_capacity(3 * skin.faces.len());
    let mut decimator = Decimator { skin: skin.clone(), quadrics, stars, stamps: vec![0; count], queue };
    for face in &skin.faces {
        (0..3)
            .map(|k| [face[k], face[(k + 1) % 3]])
            .filter(|[a, b]| a < b)
            .for_each(|ends| decimator.offer(ends));
    }
    let mut left = skin.faces.len();
    while left > target {
        let Some(Reverse(candidate)) = decimator.queue.pop() else { break };
        let current = candidate.ends.map(|v| decimator.stamps[v as usize]);
        if candidate.stamps == current && decimator.collapse(&candidate) {
            left -= 2;
        }
    }
    decimator.finish()
}

impl Decimator {
    fn offer(&mut self, ends: [u32; 2]) {
        let [a, b] = ends.map(|v| v as usize);
        let sum = self.quadrics[a].plus(self.quadrics[b]);
        let (p, q) = (self.skin.positions[a], self.skin.positions[b]);
        let middle = (p + q) * 0.5;
        let place = sum.least(middle);
        let length = (q - p).dot(q - p);
        let cost = sum.at(place).max(0.0) + MIDDLE_WEIGHT * sum.weight * length;
        let stamps = [self.stamps[a], self.stamps[b]];
        self.queue.push(Reverse(Candidate { cost, ends, stamps, place }));
    }

    fn neighbours(&self, v: u32) -> Vec<u32> {
        let corners = self.stars[v as usize].iter().flat_map(|&f| self.skin.faces[f as usize]);
        let mut neighbours: Vec<u32> = corners.filter(|&w| w != v).collect();
        neighbours.sort_unstable();
        neighbours.dedup();
        neighbours
    }

    /// Makes the edge one vertex, if that keeps the mesh simplicial and its faces sound.
    fn collapse(&mut self, candidate: &Candidate) -> bool {
        let [kept, gone] = candidate.ends;
        let (round_kept, round_gone) = (self.neighbours(kept), self.neighbours(gone));
        let common = round_kept.iter().filter(|w| round_gone.binary_search(w).is_ok()).count();
        if common != 2 || round_kept.len() + round_gone.len() < 8 {
            return false;
        }
        let both = |face: [u32; 3]| face.contains(&kept) && face.contains(&gone);
        for &f in self.stars[kept as usize].iter().chain(&self.stars[gone as usize]) {
            let face = self.skin.faces[f as usize];
            if both(face) {
                continue;
            }
            let before = self.skin.corners(face);
            let moved = |v: u32| v == kept || v == gone;
            let after = std::array::from_fn(|k| if moved(face[k]) { candidate.place } else { before[k] });
            let cosine = area_vector(before).normalised().dot(area_vector(after).normalised());
            if cosine < LEAST_COSINE || evenness(after) < LEAST_EVEN.min(evenness(before)) {
                return false;
            }
        }
        let retired: Vec<u32> = self.stars[gone as usize]
            .iter()
            .copied()
            .filter(|&f| both(self.skin.faces[f as usize]))
            .collect();
        for f in retired {
            for v in self.skin.faces[f as usize] {
                self.stars[v as usize].retain(|&g| g != f);
            }
        }
        for f in std::mem::take(&mut self.stars[gone as usize]) {
            self.skin.faces[f as usize].iter_mut().filter(|v| **v == gone).for_each(|v| *v = kept);
            self.stars[kept as usize].push(f);
        }
        self.skin.positions[kept as usize] = candidate.place;
        self.quadrics[kept as usize] = self.quadrics[kept as usize].plus(self.quadrics[gone as usize]);
        self.stamps[kept as usize] += 1;
        self.stamps[gone as usize] += 1;
        for w in self.neighbours(kept) {
            self.offer([kept.min(w), kept.max(w)]);
        }
        true
    }

    /// What is left, vertices and faces in the order of their first use.
    fn finish(self) -> Skin {
        let mut live = vec![false; self.skin.faces.len()];
        self.stars.iter().flatten().for_each(|&f| live[f as usize] = true);
        let mut number = vec![u32::MAX; self.skin.positions.len()];
        let mut left = Skin::default();
        for (face, _) in self.skin.faces.iter().zip(live).filter(|(_, live)| *live) {
            left.faces.push(face.map(|v| {
                if number[v as usize] == u32::MAX {
                    number[v as usize] = left.positions.len() as u32;
                    left.positions.push(self.skin.positions[v as usize]);
                }
                number[v as usize]
            }));
        }
        left
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bozzetto_core::mesh::{Connectivity, shapes};

    #[test]
    fn a_decimated_torus_is_a_torus_of_that_many_faces() {
        let torus = shapes::torus(40, 60);
        let positions = torus.positions.iter().map(|&[x, y, z]| vec3(x, y, z)).collect();
        let skin = decimate(&Skin { positions, faces: torus.faces }, 700, &|_| 1.0);
        assert_eq!(skin.faces.len(), 700);
        let surface =
            Connectivity::build(skin.positions.len() as u32, skin.faces.clone()).expect("a manifold");
        assert_eq!((surface.genus(), surface.components(), surface.boundary_loops()), (1, 1, 0));
        for p in &skin.positions {
            let off = (p.x.hypot(p.y) - 1.0).hypot(p.z) - 0.4;
            assert!(off.abs() < 0.02, "{p:?} is {off} off the torus");
        }
    }
}
