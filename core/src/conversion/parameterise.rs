//! The map from a base mesh to the surface it was simplified from, kept as a sequence of small flat ones.
//!
//! Every change of the mesh replaces some faces by others; both lie one to one over the same region of a plane
//! (Liu et al. 2021). A face's number is never used again, so a point on a face knows by it the change that made the
//! face, and is carried back change by change until its face is one of the input (Lee et al. 1998, MAPS, in reverse).
//!
//! Guarantees: one to one up to rounding; points on a boundary stay on it.

use glam::DVec2;

/// A point on a surface: a face and barycentric coordinates in it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct OnFace {
    /// The face.
    pub(super) face: u32,
    /// Weights of its corners, not negative, with sum 1.
    pub(super) weights: [f64; 3],
}

/// A weight below this counts as 0: points on an edge stay on it, whatever the rounding.
const ON_EDGE: f64 = 1e-11;

/// A face that a change took away or made: its number and the plane places of its corners, counted from the change's
/// first.
#[derive(Debug, Clone, Copy)]
struct FlatFace {
    face: u32,
    corners: [u8; 3],
}

/// Where a change's places begin in [`Parameterisation::plane`], and its faces in [`Parameterisation::faces`]: those
/// before, then those after.
#[derive(Debug, Clone, Copy)]
struct Change {
    plane: u32,
    before: u32,
    after: u32,
    #[cfg(test)]
    end: u32,
}

/// The changes between the input and the base mesh.
#[derive(Debug, Clone, Default)]
pub(super) struct Parameterisation {
    input_faces: u32,
    plane: Vec<DVec2>,
    faces: Vec<FlatFace>,
    changes: Vec<Change>,
    /// For each face that is not of the input, its entry in `faces` and the change that made it.
    made: Vec<(u32, u32)>,
}

impl Parameterisation {
    /// No change yet over a mesh of so many faces.
    pub(super) fn new(input_faces: u32) -> Self {
        Self { input_faces, ..Self::default() }
    }

    /// Records a change: faces with corners as indices into `plane`. The faces after are numbered on from the last
    /// face ever made.
    pub(super) fn record(
        &mut self,
        plane: &[DVec2],
        before: impl Iterator<Item = (u32, [u8; 3])>,
        after: impl Iterator<Item = [u8; 3]>,
    ) {
        let origin = self.plane.len() as u32;
        self.plane.extend_from_slice(plane);
        let start = self.faces.len() as u32;
        self.faces.extend(before.map(|(face, corners)| FlatFace { face, corners }));
        let middle = self.faces.len() as u32;
        for corners in after {
            let face = self.input_faces + self.made.len() as u32;
            self.made.push((self.faces.len() as u32, self.changes.len() as u32));
            self.faces.push(FlatFace { face, corners });
        }
        self.changes.push(Change {
            plane: origin,
            before: start,
            after: middle,
            #[cfg(test)]
            end: self.faces.len() as u32,
        });
    }

    /// The point of the input surface that a point of any later mesh stands for. Cost: one step for each change it
    /// lies in, about 60 over 50,000 collapses.
    pub(super) fn back(&self, mut point: OnFace) -> OnFace {
        while point.face >= self.input_faces {
            let (entry, change) = self.made[(point.face - self.input_faces) as usize];
            let change = self.changes[change as usize];
            let plane = &self.plane[change.plane as usize..];
            let at = in_plane(plane, self.faces[entry as usize], point.weights);
            point = find(plane, &self.faces[change.before as usize..change.after as usize], at);
        }
        point
    }

    /// The other way through one change, for points on faces it took away.
    #[cfg(test)]
    fn forth(&self, change: usize, point: OnFace) -> Option<OnFace> {
        let change = self.changes[change];
        let before = &self.faces[change.before as usize..change.after as usize];
        let from = before.iter().find(|f| f.face == point.face)?;
        let plane = &self.plane[change.plane as usize..];
        let at = in_plane(plane, *from, point.weights);
        Some(find(plane, &self.faces[change.after as usize..change.end as usize], at))
    }

    /// The number of changes.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.changes.len()
    }
}

fn in_plane(plane: &[DVec2], face: FlatFace, weights: [f64; 3]) -> DVec2 {
    let [a, b, c] = face.corners.map(|v| plane[usize::from(v)]);
    a * weights[0] + b * weights[1] + c * weights[2]
}

/// The face that holds a point of the plane, or the nearest to holding it.
fn find(plane: &[DVec2], faces: &[FlatFace], at: DVec2) -> OnFace {
    let mut best = OnFace { face: faces[0].face, weights: [1.0, 0.0, 0.0] };
    let mut least = f64::NEG_INFINITY;
    for candidate in faces {
        let [a, b, c] = candidate.corners.map(|v| plane[usize::from(v)] - at);
        let parts = [b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)];
        let sum = parts[0] + parts[1] + parts[2];
        let smallest = parts[0].min(parts[1]).min(parts[2]);
        // The least weight is their quotient: no division is needed to see that it is less.
        if smallest > least * sum {
            least = smallest / sum;
            best = OnFace { face: candidate.face, weights: parts.map(|part| part / sum) };
            if smallest >= 0.0 {
                break;
            }
        }
    }
    let clamped = best.weights.map(|w| if w < ON_EDGE { 0.0 } else { w });
    let sum: f64 = clamped.iter().sum();
    OnFace { face: best.face, weights: clamped.map(|w| w / sum) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::conversion::simplify::tests::simplified;
    use crate::mesh::shapes;

    fn spread(k: u32) -> [f64; 3] {
        let (u, v) = (f64::from(k * 7 % 11) / 11.0 + 0.03, f64::from(k * 5 % 13) / 13.0 + 0.02);
        let (u, v) = if u + v > 1.0 { (1.0 - u.min(0.99), 1.0 - v.min(0.99)) } else { (u, v) };
        let sum = 1.0 + u + v;
        [1.0 / sum, u / sum, v / sum]
    }

    #[test]
    fn there_and_back_through_every_change() {
        for (name, mesh) in shapes::awkward() {
            let (map, _) = simplified(&shapes::subdivide(&mesh, 3), 30);
            for change in 0..map.len() {
                let Change { plane, before, after, .. } = map.changes[change];
                let plane = &map.plane[plane as usize..];
                for k in before..after {
                    let start = OnFace { face: map.faces[k as usize].face, weights: spread(k) };
                    let there = map.forth(change, start).expect("the change took the face away");
                    let (entry, made_by) = map.made[(there.face - map.input_faces) as usize];
                    assert_eq!(made_by as usize, change);
                    let at = in_plane(plane, map.faces[entry as usize], there.weights);
                    let again = find(plane, &map.faces[before as usize..after as usize], at);
                    assert_eq!(again.face, start.face, "{name}: change {change}");
                    for c in 0..3 {
                        assert!(
                            (again.weights[c] - start.weights[c]).abs() < 1e-7,
                            "{name}: change {change}"
                        );
                    }
                }
            }
        }
    }
}
