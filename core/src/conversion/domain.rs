//! The simplified mesh as a domain: points of it, how nearby ones are blended, and where they are on the input.
//!
//! Every face is equilateral, whatever it looks like in space. Guarantees: the map to the input is one to one up to
//! rounding (see `parameterise`), so whatever is one to one over the domain is so over the input.

use super::curves::Curves;
use super::parameterise::{OnFace, Parameterisation};
use super::working_mesh::WorkingMesh;
use crate::hierarchy::{BaseMesh, Fan, NotABaseMesh};
use glam::DVec2;
use rustc_hash::FxHashMap;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_3, PI, TAU};
use std::sync::Arc;

/// A point of the domain: a face and barycentric coordinates in it, with sum 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Address {
    pub(super) face: u32,
    pub(super) b: [f64; 3],
}

/// Height of an equilateral triangle of side 1.
pub(super) const HEIGHT: f64 = 0.866_025_403_784_438_6;
/// Faces looked over at most between two that do not touch.
const FARTHEST: usize = 64;
/// Least pointedness (see [`WorkingMesh::pointedness`]) of a tip.
const TIP: f64 = 0.55;
/// Edges crossed at most on the way to the face that holds a point.
const CROSSINGS: usize = 8;

/// The simplified mesh and its map to the input.
#[derive(Debug)]
pub(super) struct Domain<'m> {
    /// Its faces, as a base mesh; vertices in the order of the working mesh.
    pub(super) base: Arc<BaseMesh>,
    /// For each face its number in the working mesh, and which corner of that each of its corners is.
    working: Vec<(u32, [u8; 3])>,
    /// For each vertex whether it keeps its place.
    pub(super) pinned: Vec<bool>,
    /// For each vertex whether it is the tip of something that evening must not leave behind.
    pub(super) tips: Vec<bool>,
    /// For each vertex whether it lies on the seam of half a mesh.
    pub(super) seam: Vec<bool>,
    /// Its boundary and sharp edges.
    pub(super) curves: Curves,
    map: &'m Parameterisation,
}

impl<'m> Domain<'m> {
    /// The live faces of a mesh.
    ///
    /// # Errors
    /// They are no base mesh, which simplification prevents.
    pub(super) fn new(mesh: &WorkingMesh, map: &'m Parameterisation) -> Result<Self, NotABaseMesh> {
        let mut number = vec![u32::MAX; mesh.positions.len()];
        mesh.live_faces().flat_map(|f| mesh.face(f)).for_each(|v| number[v as usize] = 0);
        let mut count = 0;
        for number in number.iter_mut().filter(|number| **number == 0) {
            *number = count;
            count += 1;
        }
        let numbered = |f: u32| mesh.face(f).map(|v| number[v as usize]);
        let live = (0..number.len() as u32).filter(|&v| number[v as usize] != u32::MAX);
        let sharp: Vec<[u32; 2]> = live
            .clone()
            .flat_map(|v| mesh.crease_ends(v).iter().filter(move |&&w| v < w).map(move |&w| [v, w]))
            .map(|ends| ends.map(|v| number[v as usize]))
            .collect();
        let pinned: Vec<bool> = live.clone().map(|v| mesh.is_corner(v)).collect();
        let seam = live.clone().map(|v| mesh.is_seam(v)).collect();
        let tips = tips(mesh, live);
        let base = BaseMesh::new(count, mesh.live_faces().map(numbered).collect(), &sharp)?;
        let by_corners: FxHashMap<[u32; 3], u32> =
            mesh.live_faces().map(|f| (sorted(numbered(f)), f)).collect();
        let working = base
            .faces()
            .iter()
            .map(|&face| {
                let f = by_corners[&sorted(face)];
                let own = numbered(f);
                (f, face.map(|v| own.iter().position(|&w| w == v).expect("the same corners") as u8))
            })
            .collect();
        let curves = Curves::new(&base, &pinned);
        Ok(Self { base: Arc::new(base), working, pinned, tips, seam, curves, map })
    }

    /// The point of the input. Cost: that of [`Parameterisation::back`].
    pub(super) fn on_input(&self, address: Address) -> OnFace {
        let (face, corners) = self.working[address.face as usize];
        let mut weights = [0.0; 3];
        for (corner, b) in corners.into_iter().zip(address.b) {
            weights[usize::from(corner)] = b;
        }
        self.map.back(OnFace { face, weights })
    }

    /// The weighted mean of addresses near one another: in the plane of two faces unfolded, or of a vertex's faces
    /// spread to a full turn (half a one on the boundary). `None` if they are not near.
    pub(super) fn blend(&self, parts: &[(f64, Address)]) -> Option<Address> {
        if let Some(address) = self.blend_in_one_face(parts) {
            return Some(address);
        }
        let mut own = [(0.0, parts.first()?.1); 3];
        let parts = self.on_one_side(parts, &mut own);
        let home = parts.first()?.1.face;
        let other = parts.iter().map(|part| part.1.face).find(|&face| face != home);
        let third = parts.iter().any(|part| part.1.face != home && Some(part.1.face) != other);
        if !third && let Some(address) = self.blend_unfolded(home, parts) {
            return settle(&self.base, address);
        }
        let shared = |&v: &u32| parts.iter().all(|part| self.base.faces()[part.1.face as usize].contains(&v));
        let Some(v) = self.base.faces()[home as usize].into_iter().find(shared) else {
            return settle(&self.base, self.blend_far(home, parts)?);
        };
        let mean = parts
            .iter()
            .fold(DVec2::ZERO, |sum, &(weight, address)| sum + self.spread_round(v, address) * weight);
        settle(&self.base, self.spread_back(v, mean))
    }

    /// Blends where one face holds all the addresses, those on its border too whose own chart is another's.
    fn blend_in_one_face(&self, parts: &[(f64, Address)]) -> Option<Address> {
        let mut means = [(u32::MAX, 0.0); 3];
        for &(weight, address) in parts {
            let corners = self.base.faces()[address.face as usize];
            for (v, b) in corners.into_iter().zip(address.b).filter(|(_, b)| *b != 0.0) {
                let mean = means.iter_mut().find(|mean| mean.0 == v || mean.0 == u32::MAX)?;
                *mean = (v, mean.1 + weight * b);
            }
        }
        let holds = |face: u32| {
            let corners = self.base.faces()[face as usize];
            means.iter().all(|&(v, _)| v == u32::MAX || corners.contains(&v))
        };
        let home = parts.first()?.1.face;
        let beside = (0..3).filter_map(|k| Some(self.base.across(home, k)?.face));
        let face = std::iter::once(home).chain(beside).find(|&face| holds(face))?;
        let of = |v: u32| means.iter().find(|mean| mean.0 == v).map_or(0.0, |mean| mean.1);
        Some(Address { face, b: self.base.faces()[face as usize].map(of) })
    }

    /// The same addresses, those on sharp edges in the chart of the face that one of the others is inside of: blends
    /// must not go round a corner.
    fn on_one_side<'p>(
        &self,
        parts: &'p [(f64, Address)],
        own: &'p mut [(f64, Address); 3],
    ) -> &'p [(f64, Address)] {
        let inside = |part: &&(f64, Address)| part.1.b.iter().all(|&b| b > 0.0);
        let marked = |part: &(f64, Address)| {
            self.base.faces()[part.1.face as usize].iter().any(|&v| self.base.sharp_valence(v) > 0)
        };
        let Some(&(_, home)) = parts.iter().find(inside).filter(|_| parts.iter().any(marked)) else {
            return parts;
        };
        let corners = self.base.faces()[home.face as usize];
        for (part, &(weight, address)) in own.iter_mut().zip(parts) {
            let there = self.base.faces()[address.face as usize];
            let of = |v: u32| there.iter().position(|&w| w == v).map_or(0.0, |k| address.b[k]);
            let held = (0..3).all(|k| address.b[k] == 0.0 || corners.contains(&there[k]));
            *part = (weight, if held { Address { face: home.face, b: corners.map(of) } } else { address });
        }
        &own[..parts.len()]
    }

    fn blend_unfolded(&self, home: u32, parts: &[(f64, Address)]) -> Option<Address> {
        let mut b = [0.0; 3];
        for &(weight, address) in parts {
            let there = if address.face == home {
                address
            } else {
                let mut beyond = (0..3).filter_map(|k| across(&self.base, address, k));
                beyond.find(|beyond| beyond.face == home)?
            };
            (0..3).for_each(|k| b[k] += weight * there.b[k]);
        }
        Some(Address { face: home, b })
    }

    /// Blends over the shortest rows of faces between: where the lattice is coarser than the domain.
    fn blend_far(&self, home: u32, parts: &[(f64, Address)]) -> Option<Address> {
        // Faces reached, with the one and the edge they were reached by, nearest first.
        let mut reached = vec![(home, 0, 0usize)];
        let mut at = 0;
        while at < reached.len().min(FARTHEST) {
            for k in 0..3u8 {
                if let Some(side) = self.base.across(reached[at].0, k)
                    && reached.iter().all(|r| r.0 != side.face)
                {
                    reached.push((side.face, at, usize::from(side.k)));
                }
            }
            at += 1;
        }
        let mut b = [0.0; 3];
        for &(weight, mut address) in parts {
            let mut at = reached.iter().position(|r| r.0 == address.face)?;
            while at > 0 {
                address = across(&self.base, address, reached[at].2)?;
                at = reached[at].1;
            }
            (0..3).for_each(|k| b[k] += weight * address.b[k]);
        }
        Some(Address { face: home, b })
    }

    /// A point of a face of `v` in the plane of its faces.
    fn spread_round(&self, v: u32, address: Address) -> DVec2 {
        let fan = self.base.fan(v);
        let at = fan.corners.iter().position(|&(f, _)| f == address.face).expect("a face of the vertex");
        let corner = usize::from(fan.corners[at].1);
        let (p, q) = (address.b[(corner + 1) % 3], address.b[(corner + 2) % 3]);
        let local = DVec2::new(p + 0.5 * q, HEIGHT * q);
        let length = local.length();
        if length == 0.0 {
            return DVec2::ZERO;
        }
        let angle = angle_in_fan(&self.base, v, at, libm::atan2(local.y, local.x) / FRAC_PI_3);
        DVec2::new(libm::cos(angle), libm::sin(angle)) * length
    }

    /// The other way: coordinates may be negative where the point is beyond the vertex's faces.
    fn spread_back(&self, v: u32, place: DVec2) -> Address {
        let fan = self.base.fan(v);
        let turn = libm::atan2(place.y, place.x);
        let turn = match (turn < 0.0, fan.closed) {
            (true, true) => turn + TAU,
            // Outside of the boundary: onto the nearer side.
            (true, false) => {
                if turn < -FRAC_PI_2 {
                    PI
                } else {
                    0.0
                }
            }
            _ => turn,
        };
        let (at, part) = place_in_fan(&self.base, v, turn);
        let (face, corner) = (fan.corners[at].0, usize::from(fan.corners[at].1));
        in_sector(face, corner, place.length(), part * FRAC_PI_3)
    }

    /// [`Domain::blend`] for addresses on one curve, along it.
    pub(super) fn blend_on_curve(&self, parts: &[(f64, Address)]) -> Option<Address> {
        self.curves.blend(&self.base, parts)
    }
}

/// Which of the vertices are tips: pointed, and more so than their neighbours.
fn tips(mesh: &WorkingMesh, live: impl Iterator<Item = u32>) -> Vec<bool> {
    let pointed = |v: u32| {
        let mut near = Vec::new();
        mesh.neighbours(v, &mut near);
        if mesh.is_on_curve(v) && !mesh.is_only_seam(v) { 0.0 } else { mesh.pointedness(v, &near) }
    };
    let tip = |v: u32| {
        let own = pointed(v);
        let mut near = Vec::new();
        mesh.neighbours(v, &mut near);
        own > TIP && near.iter().all(|&w| (pointed(w), v) < (own, w))
    };
    live.map(tip).collect()
}

/// The same point in the chart of the face beyond edge `k`; `None` on the boundary.
fn across(base: &BaseMesh, Address { face, b }: Address, k: usize) -> Option<Address> {
    let side = base.across(face, k as u8)?;
    let (opposite, other) = ((k + 2) % 3, usize::from(side.k));
    let mut beyond = [0.0; 3];
    beyond[other] = b[(k + 1) % 3] + b[opposite];
    beyond[(other + 1) % 3] = b[k] + b[opposite];
    beyond[(other + 2) % 3] = -b[opposite];
    Some(Address { face: side.face, b: beyond })
}

/// The same point in the face that holds it; a point beyond the boundary is put on it.
fn settle(base: &BaseMesh, mut address: Address) -> Option<Address> {
    for _ in 0..CROSSINGS {
        let least = (0..3).min_by(|&i, &j| address.b[i].total_cmp(&address.b[j])).unwrap_or(0);
        if address.b[least] >= 0.0 {
            return Some(address);
        }
        match across(base, address, (least + 1) % 3) {
            Some(beyond) => address = beyond,
            None => {
                address.b[least] = 0.0;
                let sum: f64 = address.b.iter().sum();
                address.b = address.b.map(|x| x / sum);
            }
        }
    }
    None
}

/// Where a straight way from a point of a face ends, when the faces round its nearest corner are unfolded; `None`
/// beyond the boundary.
pub(super) fn end_of_way(base: &BaseMesh, from: Address, way: [f64; 3]) -> Option<Address> {
    let to = Address { face: from.face, b: std::array::from_fn(|k| from.b[k] + way[k]) };
    if to.b.iter().all(|&b| b >= 0.0) {
        return Some(to);
    }
    let corner = (0..3).max_by(|&i, &j| from.b[i].total_cmp(&from.b[j])).unwrap_or(0);
    let v = base.faces()[from.face as usize][corner];
    let fan = base.fan(v);
    let at = fan.corners.iter().position(|&(f, _)| f == from.face).expect("a face of its corner");
    let (p, q) = (to.b[(corner + 1) % 3], to.b[(corner + 2) % 3]);
    let local = DVec2::new(p + 0.5 * q, HEIGHT * q);
    let sectors = libm::atan2(local.y, local.x) / FRAC_PI_3;
    let whole = sectors.floor();
    let count = fan.corners.len() as i64;
    let next = at as i64 + whole as i64;
    let next = if fan.closed { next.rem_euclid(count) } else { next };
    let &(face, corner) = fan.corners.get(usize::try_from(next).ok()?)?;
    let address = in_sector(face, usize::from(corner), local.length(), (sectors - whole) * FRAC_PI_3);
    if address.b.iter().all(|&b| b >= 0.0) {
        return Some(address);
    }
    // Past the side opposite the corner.
    let beyond = across(base, address, (usize::from(corner) + 1) % 3)?;
    beyond.b.iter().all(|&b| b >= 0.0).then_some(beyond)
}

/// The point of a face at a distance from a corner, at an angle from the side that leaves it.
fn in_sector(face: u32, corner: usize, length: f64, angle: f64) -> Address {
    let q = (length * libm::sin(angle) / HEIGHT).max(0.0);
    let p = (length * libm::cos(angle) - 0.5 * q).max(0.0);
    let mut b = [0.0; 3];
    b[(corner + 1) % 3] = p;
    b[(corner + 2) % 3] = q;
    b[corner] = 1.0 - p - q;
    Address { face, b }
}

/// The angle of a vertex's faces when together they make a full turn, or half a one on the boundary.
fn sector(fan: &Fan) -> f64 {
    (if fan.closed { TAU } else { PI }) / fan.corners.len() as f64
}

/// The angle at part of the way through a face of a vertex's fan. Faces take equal parts of a full turn, or half a one
/// on the boundary; where sharp edges meet, those between two of them share equal parts, so that a curve is straight.
pub(super) fn angle_in_fan(base: &BaseMesh, v: u32, at: usize, part: f64) -> f64 {
    match wedge(base, v, at) {
        None => (at as f64 + part) * sector(base.fan(v)),
        Some((start, width)) => start + part * width,
    }
}

/// The angle that a face of a vertex's fan takes.
pub(super) fn width_in_fan(base: &BaseMesh, v: u32, at: usize) -> f64 {
    wedge(base, v, at).map_or_else(|| sector(base.fan(v)), |(_, width)| width)
}

/// The face of a vertex's fan at an angle from 0 on, and which part of it is before that: [`angle_in_fan`] the other way.
pub(super) fn place_in_fan(base: &BaseMesh, v: u32, angle: f64) -> (usize, f64) {
    let count = base.fan(v).corners.len();
    let mut last = None;
    for at in 0..count {
        let Some((start, width)) = wedge(base, v, at) else { break };
        let part = (angle - start) / width;
        if (0.0..=1.0).contains(&part) {
            return (at, part);
        }
        last = Some(at);
    }
    if let Some(at) = last {
        return (at, 1.0);
    }
    let sectors = angle / sector(base.fan(v));
    let at = (sectors as usize).min(count - 1);
    (at, sectors - at as f64)
}

/// Where a face of a fan begins and how wide it is, if two or more sharp edges meet inside the surface.
fn wedge(base: &BaseMesh, v: u32, at: usize) -> Option<(f64, f64)> {
    let (fan, marks) = (base.fan(v), base.sharp_valence(v));
    if marks < 2 || !fan.closed {
        return None;
    }
    let count = fan.corners.len();
    let begins = |at: usize| {
        let (face, corner) = fan.corners[at % count];
        base.is_sharp(base.face_edges(face)[usize::from(corner)])
    };
    let first = (0..count).find(|&at| begins(at))?;
    let steps = (at + count - first) % count;
    let number = (0..=steps).filter(|&k| begins(first + k)).count() - 1;
    let before = (0..=steps).rev().find(|&k| begins(first + k))?;
    let after = (steps + 1..=count).find(|&k| begins(first + k))?;
    let whole = TAU / f64::from(marks);
    let width = whole / (after - before) as f64;
    Some((number as f64 * whole + (steps - before) as f64 * width, width))
}

/// The corners of a face in ascending order.
pub(super) fn sorted(mut face: [u32; 3]) -> [u32; 3] {
    face.sort_unstable();
    face
}

#[cfg(test)]
pub(super) mod tests;
