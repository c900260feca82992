//! The last faces that are turned over: where fits and smoothing left one, its corners are tried at other places near by.
//!
//! A descent by pattern search, one vertex at a time: of some thirty places around it the vertex takes the one where the
//! faces at it are turned least, as long as they stay near the input. What more is asked of a fit (even distances,
//! even spacing) was done before; a handful of faces is left, seldom hundreds.
//!
//! Guarantees: no step leaves the faces that it changes worse together; vertices slide along the sharp edge or the boundary
//! they lie on; far from turned faces all stay; the same input gives the same result; so much work is done at most, on
//! whatever input.

use super::fitted::Fitted;
use super::mend::twice_area_over_longest;
use super::patch::{POINTS, blend};
use super::pulls::Pulls;
use super::simplify::Cancelled;
use super::target::{TURNED, Target};
use crate::mesh::{ClosestPointCursor, closest_on_triangle};
use glam::DVec3;
use std::collections::VecDeque;

/// Rounds over the turned faces.
const ROUNDS: usize = 12;
/// The surroundings of so many faces that stay turned are shaken at most; they descend so many times from there.
const MOST_SHAKEN: usize = 16;
const SHAKES: [Shake; 8] = [
    Shake { rings: 2, drag: false, jolt: 0.0, smoothings: 2 },
    Shake { rings: 2, drag: false, jolt: 0.0, smoothings: 10 },
    Shake { rings: 4, drag: true, jolt: 0.0, smoothings: 1 },
    Shake { rings: 4, drag: true, jolt: 0.0, smoothings: 6 },
    Shake { rings: 1, drag: false, jolt: 0.5, smoothings: 0 },
    Shake { rings: 1, drag: false, jolt: 1.0, smoothings: 1 },
    Shake { rings: 2, drag: false, jolt: 0.5, smoothings: 0 },
    Shake { rings: 2, drag: false, jolt: 1.0, smoothings: 2 },
];
const DESCENTS: usize = 4;
/// Triangles and boxes looked at are so many at most, two seconds' worth: where the input's triangles lie through one
/// another, or are long and thin, a closest point takes hundreds of looks.
pub(super) const MOST_LOOKS: u64 = 30_000_000;
/// A face counts as well turned from this cosine to the input's normal on.
const UPRIGHT: f64 = 0.3;
/// A face is no sliver from this on; see [`twice_area_over_longest`].
const STOUT: f64 = 0.1;
/// What it is worth that the middle of a face is not twice as far from the input as it may be.
const FAR: f64 = 0.3;
/// Faces that are changed lie no further from the input, and the input from them, than before or than so many root mean
/// squares of the fit, within these bounds over the diagonal.
const REACH: f64 = 10.0;
const REACHES: [f64; 2] = [2e-4, 1e-3];
/// What is shaken may lie as far off as this, if the fit does somewhere.
const SHAKEN: f64 = 2e-3;

/// Where a vertex may go: to the faces and the corners of a cube.
const WAYS: [DVec3; 14] = {
    const fn way(x: f64, y: f64, z: f64) -> DVec3 {
        DVec3::new(x, y, z)
    }
    [
        way(1.0, 0.0, 0.0),
        way(-1.0, 0.0, 0.0),
        way(0.0, 1.0, 0.0),
        way(0.0, -1.0, 0.0),
        way(0.0, 0.0, 1.0),
        way(0.0, 0.0, -1.0),
        way(1.0, 1.0, 1.0),
        way(1.0, 1.0, -1.0),
        way(1.0, -1.0, 1.0),
        way(1.0, -1.0, -1.0),
        way(-1.0, 1.0, 1.0),
        way(-1.0, 1.0, -1.0),
        way(-1.0, -1.0, 1.0),
        way(-1.0, -1.0, -1.0),
    ]
};

/// What is done to the vertices so many edges from a face.
struct Shake {
    rings: usize,
    /// Whether they first follow the corner that is furthest from its neighbours, the nearer the more: one that keeps its
    /// place may lie outside all of them, and smoothing alone does not bring them round it.
    drag: bool,
    /// Whether each is then put somewhere else at random, so many edges away at most.
    jolt: f64,
    smoothings: usize,
}

/// What turned faces are undone on.
pub(super) struct Unfolding<'a> {
    pub(super) target: &'a Target<'a>,
    pub(super) fitted: &'a Fitted,
    /// The true places of the vertices.
    pub(super) places: &'a [DVec3],
    /// How the fit lay.
    pub(super) pulls: &'a Pulls,
    /// How many triangles and boxes may be looked at; when those are spent, what is turned stays so.
    pub(super) looks: u64,
}

/// What is asked again and again.
struct Near<'a> {
    cursor: ClosestPointCursor<'a>,
    /// The samples of the target by the face of the fit that each was closest to.
    starts: Vec<u32>,
    order: Vec<u32>,
    /// Distances from samples to triangles of the fit that were taken.
    compared: u64,
    most: u64,
}

impl Near<'_> {
    fn looked_at(&self) -> u64 {
        self.cursor.looked_at() + self.compared
    }

    /// Whether no more may be looked at.
    fn is_spent(&self) -> bool {
        self.looked_at() >= self.most
    }

    fn samples(&self, face: u32) -> &[u32] {
        let face = face as usize;
        &self.order[self.starts[face] as usize..self.starts[face + 1] as usize]
    }
}

impl Unfolding<'_> {
    /// Tries to turn faces back; `turned` are those that are turned over, ascending. Cost: about a millisecond for each of
    /// them and round, some fifty for each that stays.
    ///
    /// # Errors
    /// `go_on` answered no.
    pub(super) fn run(
        &self,
        positions: &mut [DVec3],
        turned: &[u32],
        go_on: &dyn Fn() -> bool,
    ) -> Result<(), Cancelled> {
        let mut near = self.near();
        let mut left: Vec<u32> = turned.to_vec();
        let mut stuck = Vec::new();
        for _ in 0..ROUNDS {
            let mut moved = Vec::new();
            for &f in &left {
                if !go_on() {
                    return Err(Cancelled);
                }
                if self.is_turned(f, positions, &mut near) {
                    let before = moved.len();
                    let corners = self.fitted.pattern.faces()[f as usize];
                    moved.extend(corners.iter().filter(|&&v| self.improve(v as usize, positions, &mut near)));
                    stuck.extend((moved.len() == before).then_some(f));
                }
            }
            // What turned one face back may have turned another over that was less so.
            left = self.turned_at(&moved, positions, &mut near);
            if left.is_empty() {
                break;
            }
        }
        stuck.append(&mut left);
        stuck.sort_unstable();
        stuck.dedup();
        let mut stuck = VecDeque::from(stuck);
        let mut tries = MOST_SHAKEN;
        while tries > 0
            && let Some(f) = stuck.pop_front()
        {
            if self.is_turned(f, positions, &mut near) {
                tries -= 1;
                let moved = self.shake(f, positions, &mut near, go_on)?;
                let others = self.turned_at(&moved, positions, &mut near);
                stuck.extend(others.into_iter().filter(|&other| other != f));
            }
        }
        Ok(())
    }

    /// The faces with corners among some vertices that are turned over, ascending.
    fn turned_at(&self, vertices: &[u32], positions: &[DVec3], near: &mut Near) -> Vec<u32> {
        let mut faces = self.faces_of(vertices);
        faces.retain(|&f| self.is_turned(f, positions, near));
        faces
    }

    fn near(&self) -> Near<'_> {
        let (starts, order) = self.pulls.by_face(self.fitted.pattern.faces().len());
        Near { cursor: self.target.tree.cursor(), starts, order, compared: 0, most: self.looks }
    }

    /// Smooths the surroundings of a face and descends from there, wider and wider until the face is turned back; leaves
    /// them as they were where that is no better. Returns the vertices that may have moved.
    fn shake(
        &self,
        face: u32,
        positions: &mut [DVec3],
        near: &mut Near,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Vec<u32>, Cancelled> {
        // No further than the fit is somewhere: so the greatest distance stays.
        let reach = self.reach().max(self.pulls.max.min(SHAKEN));
        let mut moved = Vec::new();
        for (k, Shake { rings, drag, jolt, smoothings }) in SHAKES.into_iter().enumerate() {
            if near.is_spent() {
                break;
            }
            let around = self.around_face(face, rings);
            let before: Vec<DVec3> = around.iter().map(|&v| positions[v as usize]).collect();
            let faces = self.faces_of(&around);
            let allowed = self.greatest(&faces, positions, near).max(reach);
            let least = self.badness(&faces, positions, near);
            if drag {
                self.drag(face, rings, positions, near);
            }
            if jolt > 0.0 {
                self.jolt(&around, jolt, u64::from(face) << 8 | k as u64, positions, near);
            }
            for _ in 0..smoothings {
                self.smooth(&around, positions, near);
            }
            for _ in 0..DESCENTS {
                if !go_on() {
                    return Err(Cancelled);
                }
                let moved = around.iter().filter(|&&v| self.improve(v as usize, positions, near)).count();
                if moved == 0 {
                    break;
                }
            }
            let badness = self.badness(&faces, positions, near);
            if badness >= least || self.greatest(&faces, positions, near) > allowed {
                around.iter().zip(&before).for_each(|(&v, &at)| positions[v as usize] = at);
            } else {
                moved.extend(around);
                if !self.is_turned(face, positions, near) {
                    break;
                }
            }
        }
        Ok(moved)
    }

    /// The vertices at most so many edges from a face, ascending.
    fn around_face(&self, face: u32, rings: usize) -> Vec<u32> {
        let pattern = &self.fitted.pattern;
        let mut around = pattern.faces()[face as usize].to_vec();
        for _ in 0..rings {
            around = around.iter().flat_map(|&v| pattern.neighbours(v as usize)).copied().collect();
            around.sort_unstable();
            around.dedup();
        }
        around
    }

    fn faces_of(&self, vertices: &[u32]) -> Vec<u32> {
        let corners = vertices.iter().flat_map(|&v| self.fitted.pattern.corners(v as usize));
        let mut faces: Vec<u32> = corners.map(|corner| corner / 3).collect();
        faces.sort_unstable();
        faces.dedup();
        faces
    }

    /// Lets the vertices round one corner of a face follow it, those next to it until it lies in the middle of them.
    fn drag(&self, face: u32, rings: usize, positions: &mut [DVec3], near: &mut Near) {
        let off = |v: u32| positions[v as usize] - self.middle(v as usize, positions);
        let corners = self.fitted.pattern.faces()[face as usize].map(|v| (off(v), v));
        let furthest = corners.into_iter().max_by(|a, b| a.0.length().total_cmp(&b.0.length()));
        let (way, corner) = furthest.expect("three corners");
        let mut seen = vec![corner];
        let mut from = 0;
        for ring in 1..=rings {
            let to = seen.len();
            for at in from..to {
                for &v in self.fitted.pattern.neighbours(seen[at] as usize) {
                    if !seen.contains(&v) {
                        seen.push(v);
                    }
                }
            }
            let share = 1.0 - (ring - 1) as f64 / rings as f64;
            for &v in &seen[to..] {
                self.settle(v as usize, positions[v as usize] + way * share, positions, near);
            }
            from = to;
        }
    }

    /// Every vertex somewhere else, so many edges away at most; the same for the same seed.
    fn jolt(&self, around: &[u32], edges: f64, seed: u64, positions: &mut [DVec3], near: &mut Near) {
        let mut state = seed;
        let mut random = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut bits = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((bits ^ (bits >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        for &v in around {
            let v = v as usize;
            let way = DVec3::new(random(), random(), random()) * (edges * self.mean_edge(v, positions));
            self.settle(v, positions[v] + way, positions, near);
        }
    }

    fn mean_edge(&self, v: usize, positions: &[DVec3]) -> f64 {
        let near = self.fitted.pattern.neighbours(v);
        near.iter().map(|&w| positions[w as usize].distance(positions[v])).sum::<f64>() / near.len() as f64
    }

    /// Every vertex halfway to the middle of its neighbours.
    fn smooth(&self, around: &[u32], positions: &mut [DVec3], near: &mut Near) {
        for &v in around {
            let v = v as usize;
            let there = positions[v].midpoint(self.middle(v, positions));
            self.settle(v, there, positions, near);
        }
    }

    fn middle(&self, v: usize, positions: &[DVec3]) -> DVec3 {
        let near = self.fitted.pattern.neighbours(v);
        near.iter().map(|&w| positions[w as usize]).sum::<DVec3>() / near.len() as f64
    }

    /// Puts a vertex on the input next to a place, as far as it may go there.
    fn settle(&self, v: usize, place: DVec3, positions: &mut [DVec3], near: &mut Near) {
        let place = near.cursor.closest(place.to_array()).point.into();
        positions[v] = self.allowed(v, positions[v], place);
    }

    fn reach(&self) -> f64 {
        (REACH * self.pulls.rms).clamp(REACHES[0], REACHES[1])
    }

    fn faces_at(&self, v: usize) -> Vec<u32> {
        self.fitted.pattern.corners(v).iter().map(|corner| corner / 3).collect()
    }

    /// Moves a vertex where the faces at it are turned less, as long as anything may be looked at; whether it moved.
    fn improve(&self, v: usize, positions: &mut [DVec3], near: &mut Near) -> bool {
        if near.is_spent() {
            return false;
        }
        let before = positions[v];
        let faces = self.faces_at(v);
        let least = self.badness(&faces, positions, near);
        if least == 0.0 {
            return false;
        }
        let allowed = self.greatest(&faces, positions, near).max(self.reach());
        let mut tried: Vec<(f64, DVec3)> = Vec::new();
        for place in self.around(v, positions) {
            let place = self.allowed(v, before, place);
            positions[v] = place;
            let badness = self.badness(&faces, positions, near);
            if badness < least - 1e-6 {
                tried.push((badness, place));
            }
        }
        tried.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, place) in tried {
            positions[v] = place;
            if self.greatest(&faces, positions, near) <= allowed {
                return true;
            }
        }
        positions[v] = before;
        false
    }

    /// Where a vertex that would go to another place may go: along its sharp edge, or the boundary of the input.
    fn allowed(&self, v: usize, from: DVec3, to: DVec3) -> DVec3 {
        let to = if self.fitted.along_boundary[v].is_some() { self.target.on_boundary(to) } else { to };
        self.fitted.held.put(v, from, to)
    }

    /// Places to try for a vertex.
    fn around(&self, v: usize, positions: &[DVec3]) -> Vec<DVec3> {
        let at = positions[v];
        let mean = self.middle(v, positions);
        let length = self.mean_edge(v, positions);
        let mut places: Vec<DVec3> = [0.25, 0.5, 1.0].iter().map(|t| at.lerp(mean, *t)).collect();
        places.extend([0.5, 1.0].iter().map(|t| at.lerp(self.places[v], *t)));
        for way in WAYS {
            places.extend([0.12, 0.4].iter().map(|t| at + way.normalize() * (length * t)));
        }
        places
    }

    fn corners(&self, face: u32, positions: &[DVec3]) -> [DVec3; 3] {
        self.fitted.pattern.faces()[face as usize].map(|v| positions[v as usize])
    }

    fn is_turned(&self, face: u32, positions: &[DVec3], near: &mut Near) -> bool {
        self.target.is_turned(self.corners(face, positions), &mut near.cursor)
    }

    /// How many faces are turned over, and how far the others are from being upright, stout and within reach.
    fn badness(&self, faces: &[u32], positions: &[DVec3], near: &mut Near) -> f64 {
        let reach = self.reach();
        let of_face = |&f: &u32| {
            let corners = self.corners(f, positions);
            let (cosine, distance) = self.target.beside(corners, &mut near.cursor);
            let stout = twice_area_over_longest(corners);
            f64::from(u8::from(cosine <= TURNED))
                + (UPRIGHT - cosine).max(0.0)
                + (STOUT - stout).max(0.0)
                + FAR * (distance / reach - 1.0).clamp(0.0, 1.0)
        };
        faces.iter().map(of_face).sum()
    }

    /// The greatest distance of faces from the input, and of the input from them: of the samples that were closest to one of
    /// them, from all around.
    fn greatest(&self, faces: &[u32], positions: &[DVec3], near: &mut Near) -> f64 {
        let pattern = &self.fitted.pattern;
        let forth = faces
            .iter()
            .flat_map(|&f| POINTS.map(|weights| blend(self.corners(f, positions), weights)))
            .map(|point| near.cursor.closest(point.to_array()).squared_distance)
            .fold(0.0, f64::max);
        let mut around: Vec<u32> = faces
            .iter()
            .flat_map(|&f| pattern.faces()[f as usize])
            .flat_map(|v| pattern.corners(v as usize))
            .map(|corner| corner / 3)
            .collect();
        around.sort_unstable();
        around.dedup();
        let triangles: Vec<[DVec3; 3]> = around.iter().map(|&f| self.corners(f, positions)).collect();
        let samples = faces.iter().map(|&f| near.samples(f).len()).sum::<usize>();
        near.compared += (samples * triangles.len()) as u64;
        let back = |&sample: &u32| {
            let point = self.target.samples[sample as usize];
            triangles.iter().map(|t| closest_on_triangle(point, t).1).fold(f64::INFINITY, f64::min)
        };
        let back = faces.iter().flat_map(|&f| near.samples(f)).map(back).fold(0.0, f64::max);
        forth.max(back).sqrt()
    }
}

#[cfg(test)]
mod tests;
