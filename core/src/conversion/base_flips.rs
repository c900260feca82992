//! Flips of base edges by what the finest level shows of the surface, not by chords.
//!
//! An edge is worth flipping where its two faces, measured over all their parts, would be nearer to equilateral the
//! other way (the condition of Delaunay in the mean metric of each), or where valences gain.

use super::domain::{Domain, sorted};
use super::lattice::{Flipped, Lattice, Places};
use super::warp::row_index;
use crate::hierarchy::{BaseMesh, EdgeSide};
use rustc_hash::{FxHashMap, FxHashSet};

/// Shape of a base face in the mean over its parts, each counting the same whatever its size.
#[derive(Debug, Clone, Copy)]
struct Shape {
    /// Squared lengths of the sides opposite each corner, up to a common factor.
    squares: [f64; 3],
}

/// What a step of squared valence excess is worth.
const VALENCE_VALUE: f64 = 0.05;
/// Least gain of a flip.
const LEAST_GAIN: f64 = 0.05;

/// The lattice over a base mesh with better edges; `None` if no edge is worth a flip. Each face takes part in one flip
/// at most. Linear.
pub(super) fn flipped(lattice: &Lattice, domain: &Domain, places: &Places) -> Option<Lattice> {
    let (base, seam) = (lattice.hierarchy.base(), &domain.seam);
    let shapes: Vec<Shape> = (0..base.faces().len()).map(|f| shape(lattice, places, f)).collect();
    let mut valences: Vec<i64> = (0..base.vertex_count()).map(|v| base.fan(v).corners.len() as i64).collect();
    let mut gains: Vec<(f64, u32)> = (0..base.edges().len() as u32)
        .filter_map(|e| Some((gain(base, seam, &shapes, &valences, e)?, e)))
        .filter(|(gain, _)| *gain > LEAST_GAIN)
        .collect();
    gains.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let mut used = vec![false; base.faces().len()];
    let mut made: FxHashSet<[u32; 2]> = FxHashSet::default();
    let mut old = FxHashMap::default();
    let mut faces: Vec<[u32; 3]> = Vec::new();
    for (_, e) in gains {
        let Some(flip) = flip(base, seam, e) else { continue };
        let [c, d] = flip.apexes;
        let key = [c.min(d), c.max(d)];
        if flip.faces.iter().any(|&f| used[f as usize])
            || made.contains(&key)
            || gain(base, seam, &shapes, &valences, e).is_none_or(|gain| gain <= LEAST_GAIN)
        {
            continue;
        }
        made.insert(key);
        flip.faces.iter().for_each(|&f| used[f as usize] = true);
        let [a, b] = flip.ends;
        for (v, change) in [(a, -1), (b, -1), (c, 1), (d, 1)] {
            valences[v as usize] += change;
        }
        for face in [[c, a, d], [d, b, c]] {
            old.insert(sorted(face), flip);
            faces.push(face);
        }
    }
    if old.is_empty() {
        return None;
    }
    faces.extend(base.faces().iter().zip(&used).filter(|(_, used)| !**used).map(|(f, _)| *f));
    let next =
        BaseMesh::new(base.vertex_count(), faces, &base.sharp_edges()).expect("flips keep a base mesh");
    lattice.rebased(domain, next, &old)
}

/// The two faces of an edge and what it would become; `None` for curves, and where the other diagonal exists or would join
/// two vertices of the seam.
fn flip(base: &BaseMesh, seam: &[bool], e: u32) -> Option<Flipped> {
    if base.is_sharp(e) {
        return None;
    }
    let [Some(left), Some(right)] = base.sides(e) else { return None };
    let apex = |side: EdgeSide| base.faces()[side.face as usize][(usize::from(side.k) + 2) % 3];
    let [c, d] = [apex(left), apex(right)];
    // Oriented: the left face runs from the first end to the second.
    let a = base.faces()[left.face as usize][usize::from(left.k)];
    let b = base.faces()[left.face as usize][(usize::from(left.k) + 1) % 3];
    // Between two sharp edges stay the faces that are there, for wide angles need more than one.
    let sharp = |side: EdgeSide, step: usize| {
        base.is_sharp(base.face_edges(side.face)[(usize::from(side.k) + step) % 3])
    };
    if sharp(left, 2) && sharp(right, 1) || sharp(left, 1) && sharp(right, 2) {
        return None;
    }
    let joined = base.fan(c).corners.iter().any(|&(f, _)| base.faces()[f as usize].contains(&d));
    let bridge = seam[c as usize] && seam[d as usize];
    (c != d && !joined && !bridge).then_some(Flipped {
        ends: [a, b],
        apexes: [c, d],
        faces: [left.face, right.face],
    })
}

/// What flipping an edge gains; `None` where it cannot be flipped.
fn gain(base: &BaseMesh, seam: &[bool], shapes: &[Shape], valences: &[i64], e: u32) -> Option<f64> {
    let Flipped { ends: [a, b], apexes: [c, d], faces: [left, right] } = flip(base, seam, e)?;
    let open = |v: u32| !base.fan(v).closed;
    let least = |v: u32| if open(v) { 3 } else { 5 };
    if [a, b].iter().any(|&v| valences[v as usize] < least(v)) {
        return None;
    }
    let excess = |v: u32, change: i64| {
        let off = valences[v as usize] + change - if open(v) { 3 } else { 6 };
        (off * off) as f64
    };
    let valence = [a, b].map(|v| excess(v, 0) - excess(v, -1)).iter().sum::<f64>()
        + [c, d].map(|v| excess(v, 0) - excess(v, 1)).iter().sum::<f64>();
    let square = |f: u32, v: u32| {
        let k = base.faces()[f as usize].iter().position(|&w| w == v).expect("a corner");
        shapes[f as usize].squares[k]
    };
    // Squared sides of the diamond; the common edge is the mean of what both faces say.
    let (ab1, ab2) = (square(left, c), square(right, d));
    let cotangent = |opposite: f64, p: f64, q: f64| {
        let doubled = (4.0 * p * q - (p + q - opposite) * (p + q - opposite)).max(1e-12 * p * q).sqrt();
        (p + q - opposite) / doubled
    };
    let sum =
        cotangent(ab1, square(left, a), square(left, b)) + cotangent(ab2, square(right, a), square(right, b));
    Some((-sum).clamp(-2.0, 4.0) + VALENCE_VALUE * valence)
}

fn shape(lattice: &Lattice, places: &Places, face: usize) -> Shape {
    let n = lattice.layout().segments() as i32;
    let slots = lattice.face_slots(face);
    let at = |i: i32, r: i32| places.at[slots[row_index(n, [0, i, r])] as usize];
    let mut squares = [0.0; 3];
    for r in 0..n {
        for i in 0..n - r {
            let (a, b, c) = (at(i, r), at(i + 1, r), at(i, r + 1));
            let area = (b - a).cross(c - a).length();
            if area > 0.0 {
                squares[0] += b.distance_squared(c) / area;
                squares[1] += c.distance_squared(a) / area;
                squares[2] += a.distance_squared(b) / area;
            }
        }
    }
    Shape { squares }
}

#[cfg(test)]
mod tests;
