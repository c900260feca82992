//! Large fans: the caps of cylinders and discs, whose hub sees every vertex of the rim.
//!
//! No collapse makes much of them, for what sees everything cannot go, and a base vertex with dozens of neighbours has a
//! poor surface around it and weights that take long to solve. So rings of ever fewer vertices are laid around the hub
//! before simplification. Guarantees: an oriented manifold of the same topology; vertices and edges outside the fans stay;
//! a smooth fan leaves its surface by no more than the angle between its faces allows, a flat one not at all.

use crate::mesh::{Connectivity, TriangleMesh, connectivity};
use glam::DVec3;
use rustc_hash::FxHashSet;

/// Fans of more faces are large.
const LARGEST: u32 = 16;
/// Rings are laid until a hub has no more.
const WANTED: u32 = 10;
/// How far from the hub a ring lies, of the way to what is around it.
const RING: f64 = 0.7;
/// Faces that are joined meet at no more than this angle, in degrees: sharper edges would be taken for creases.
const FLAT: f64 = 15.0;
/// The cosine above which faces lie in a plane: rings leave it by nothing that counts.
const PLANE: f64 = 1.0 - 1e-12;
/// No fan needs more rings: each halves what the hub sees.
const MOST_RINGS: usize = 24;

/// A mesh with rings in its large fans.
pub(super) struct Ringed {
    pub(super) mesh: TriangleMesh,
    pub(super) connectivity: Connectivity<'static>,
    /// Whether all these fans are flat: the surface is the same.
    pub(super) is_flat: bool,
}

/// Lays rings; `None` if there is no large fan that is smooth. Linear, for each ring.
pub(super) fn with_rings(mesh: &TriangleMesh, connectivity: &Connectivity) -> Option<Ringed> {
    let marked: FxHashSet<u32> = mesh.sharp_edges.iter().flatten().copied().collect();
    let mut begun = FxHashSet::default();
    let mut made: Option<Ringed> = None;
    for _ in 0..MOST_RINGS {
        let (now, around) =
            made.as_ref().map_or((mesh, connectivity), |made| (&made.mesh, &made.connectivity));
        let Some((mesh, least)) = one_ring_each(now, around, &marked, &mut begun) else { break };
        let built = Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone());
        let connectivity = built.expect("rings keep a manifold");
        let is_flat = least > PLANE && made.is_none_or(|made| made.is_flat);
        made = Some(Ringed { mesh, connectivity, is_flat });
    }
    made
}

/// Lays a ring around the hub of each large fan, but where two share faces around one of them alone; also the least cosine between
/// faces that were joined.
fn one_ring_each(
    mesh: &TriangleMesh,
    connectivity: &Connectivity,
    marked: &FxHashSet<u32>,
    begun: &mut FxHashSet<u32>,
) -> Option<(TriangleMesh, f64)> {
    let (mut replaced, mut least) = (FxHashSet::default(), 1.0f64);
    let mut fans = Vec::new();
    for hub in 0..mesh.positions.len() as u32 {
        let most = if begun.contains(&hub) { WANTED } else { LARGEST };
        if connectivity.outgoing(hub) == connectivity::NONE
            || connectivity.face_valence(hub) <= most
            || marked.contains(&hub)
        {
            continue;
        }
        let fan = Fan::around(connectivity, hub);
        let cosine = fan.least_cosine(mesh);
        if cosine < FLAT.to_radians().cos() || fan.faces.iter().any(|face| replaced.contains(face)) {
            continue;
        }
        least = least.min(cosine);
        begun.insert(hub);
        replaced.extend(fan.faces.iter().copied());
        fans.push(fan);
    }
    if fans.is_empty() {
        return None;
    }
    let kept = (0..).zip(&mesh.faces).filter(|(face, _)| !replaced.contains(face));
    let rest: Vec<[u32; 3]> = kept.map(|(_, &corners)| corners).collect();
    let (positions, sharp_edges) = (mesh.positions.clone(), mesh.sharp_edges.clone());
    let mut next = TriangleMesh { positions, sharp_edges, faces: Vec::new() };
    fans.iter().for_each(|fan| fan.lay_ring(&mut next));
    next.faces.extend(rest);
    Some((next, least))
}

/// The faces around a vertex.
struct Fan {
    hub: u32,
    /// Counter-clockwise.
    faces: Vec<u32>,
    /// What lies around the hub, counter-clockwise; of an open fan one more than faces.
    rim: Vec<u32>,
    closed: bool,
}

impl Fan {
    fn around(connectivity: &Connectivity, hub: u32) -> Self {
        let closed = !connectivity.is_boundary(hub);
        let spokes: Vec<u32> = connectivity.fan(hub).collect();
        let mut rim: Vec<u32> = spokes.iter().map(|&spoke| connectivity.target(spoke)).collect();
        if !closed && let Some(&last) = spokes.last() {
            rim.push(connectivity.origin(connectivity::previous(last)));
        }
        Self { hub, faces: spokes.into_iter().map(|spoke| spoke / 3).collect(), rim, closed }
    }

    /// Of the angles between faces that are two apart the cosine of the greatest.
    fn least_cosine(&self, mesh: &TriangleMesh) -> f64 {
        let normals: Vec<DVec3> = self
            .faces
            .iter()
            .map(|&face| {
                let [a, b, c] = mesh.faces[face as usize].map(|v| DVec3::from(mesh.positions[v as usize]));
                (b - a).cross(c - a).normalize_or_zero()
            })
            .collect();
        let count = normals.len();
        let pairs = if self.closed { count } else { count - 2 };
        (0..pairs).map(|at| normals[at].dot(normals[(at + 2) % count])).fold(1.0, f64::min)
    }

    /// Adds a ring on every other spoke, and the faces on both sides of it.
    fn lay_ring(&self, mesh: &mut TriangleMesh) {
        let Self { hub, rim, .. } = self;
        let (hub, count) = (*hub, rim.len());
        let mut spokes: Vec<usize> = (0..count).step_by(2).collect();
        if !self.closed && count.is_multiple_of(2) {
            spokes.push(count - 1);
        }
        let middle = DVec3::from(mesh.positions[hub as usize]);
        let first = mesh.positions.len() as u32;
        for &spoke in &spokes {
            let outside = DVec3::from(mesh.positions[rim[spoke] as usize]);
            mesh.positions.push(middle.lerp(outside, RING).to_array());
        }
        let ring = |at: usize| first + (at % spokes.len()) as u32;
        for at in 0..if self.closed { spokes.len() } else { spokes.len() - 1 } {
            let (from, to) = (spokes[at], spokes.get(at + 1).copied().unwrap_or(count));
            let [a, b] = [from, to].map(|spoke| rim[spoke % count]);
            let [r, s] = [ring(at), ring(at + 1)];
            if to - from == 2 {
                let between = rim[from + 1];
                mesh.faces.extend([[a, between, r], [between, b, s], [between, s, r]]);
            } else {
                mesh.faces.extend([[a, b, s], [a, s, r]]);
            }
            mesh.faces.push([hub, r, s]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A fan of so many faces, open or closed, with a hub so high.
    fn fan(faces: u32, closed: bool, height: f64) -> TriangleMesh {
        let around = if closed { faces } else { faces + 1 };
        let turn = if closed { std::f64::consts::TAU } else { 3.0 };
        let rim =
            (0..around).map(|k| turn * f64::from(k) / f64::from(faces)).map(|a| [a.cos(), a.sin(), 0.0]);
        let positions = std::iter::once([0.0, 0.0, height]).chain(rim).collect();
        TriangleMesh::new(positions, (0..faces).map(|k| [0, 1 + k, 1 + (k + 1) % around]).collect())
    }

    fn area(mesh: &TriangleMesh) -> DVec3 {
        let at = |v: u32| DVec3::from(mesh.positions[v as usize]);
        mesh.faces.iter().map(|&[a, b, c]| 0.5 * (at(b) - at(a)).cross(at(c) - at(a))).sum()
    }

    #[test]
    fn flat_fans_are_covered_again_by_small_ones() {
        for closed in [false, true] {
            for faces in [25, 26, 27, 28, 64, 99, 400, 1001] {
                let mesh = fan(faces, closed, 0.0);
                let count = mesh.positions.len() as u32;
                let before = Connectivity::build(count, mesh.faces.as_slice()).expect("a disk");
                let made = with_rings(&mesh, &before).expect("a large fan");
                let Ringed { mesh: ringed, connectivity: after, is_flat } = made;
                assert!(is_flat, "{faces} faces, closed: {closed}");
                let figures = |c: &Connectivity| {
                    (c.genus(), c.components(), c.boundary_loops(), c.euler_characteristic())
                };
                assert_eq!(figures(&after), figures(&before), "{faces} faces, closed: {closed}");
                let most = (0..after.vertex_count()).map(|v| after.face_valence(v)).max();
                assert!(most <= Some(WANTED), "{faces} faces, closed: {closed}: {most:?} at a vertex");
                assert!((area(&ringed) - area(&mesh)).length() < 1e-12, "{faces} faces, closed: {closed}");
                let upright =
                    |f: &[u32; 3]| area(&TriangleMesh::new(ringed.positions.clone(), vec![*f])).z > 0.0;
                assert!(ringed.faces.iter().all(upright), "{faces} faces, closed: {closed}: none lies over");
                assert_eq!(ringed.positions[..mesh.positions.len()], mesh.positions);
            }
        }
    }

    #[test]
    fn pleats_marks_and_small_fans_stay() {
        let rings = |mesh: &TriangleMesh| {
            let count = mesh.positions.len() as u32;
            with_rings(mesh, &Connectivity::build(count, mesh.faces.as_slice()).expect("a disk"))
                .map(|ringed| ringed.is_flat)
        };
        assert_eq!(rings(&fan(16, true, 0.0)), None);
        let mut pleated = fan(100, true, 0.0);
        pleated.positions.iter_mut().skip(1).step_by(2).for_each(|p| p[2] = 0.2);
        pleated.positions.iter_mut().skip(1).step_by(4).for_each(|p| p[2] = -0.2);
        assert_eq!(rings(&pleated), None);
        let mut marked = fan(100, true, 0.0);
        marked.sharp_edges = vec![[0, 7]];
        assert_eq!(rings(&marked), None);
        assert_eq!(rings(&fan(100, true, 0.5)), Some(false));
    }
}
