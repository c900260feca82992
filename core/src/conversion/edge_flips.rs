//! Flips of base edges: valences nearer to six, fewer slivers. Each flip is recorded as a flat map of its two faces,
//! unfolded about the edge, which changes no length.

use super::collapse::quality;
use super::parameterise::Parameterisation;
use super::working_mesh::WorkingMesh;
use glam::{DVec2, DVec3};

/// Passes over all edges at most; most gain is in the first two.
const PASSES: usize = 6;
/// What one step of squared valence excess is worth, in quality of the worse face.
const VALENCE_VALUE: f64 = 0.03;
/// Least cosine between the normals of two faces whose edge may be flipped: across a sharper bend the surface would
/// be cut short.
const LEAST_COSINE: f64 = 0.8;
/// Least sine of the angles of the unfolded faces.
const LEAST_SINE: f64 = 0.1;

/// Flips edges while that makes the mesh better. `O(n)` a pass.
pub(super) fn flip_edges(mesh: &mut WorkingMesh, map: &mut Parameterisation) {
    for _ in 0..PASSES {
        let faces: Vec<u32> = mesh.live_faces().collect();
        let mut flips = 0;
        for f in faces {
            for k in 0..3 {
                if mesh.is_live(f) {
                    let face = mesh.face(f);
                    flips += usize::from(try_flip(mesh, map, face[k], face[(k + 1) % 3], 0.02));
                }
            }
        }
        if flips == 0 {
            break;
        }
    }
}

/// Frees boundary vertices that have one face only, which no collapse can remove, by flipping the edge opposite.
pub(super) fn open_ears(mesh: &mut WorkingMesh, map: &mut Parameterisation) {
    for v in 0..mesh.positions.len() as u32 {
        if mesh.is_on_curve(v) && !mesh.is_boundary(v) && !mesh.is_corner(v) {
            open_crease(mesh, map, v);
        }
        if let &[f] = mesh.star(v) {
            let face = mesh.face(f);
            let k = face.iter().position(|&w| w == v).expect("a star's face holds its vertex");
            try_flip(mesh, map, face[(k + 1) % 3], face[(k + 2) % 3], f64::NEG_INFINITY);
        }
    }
}

/// Flips the edge opposite a vertex of a sharp curve that has one face only on a side.
fn open_crease(mesh: &mut WorkingMesh, map: &mut Parameterisation, v: u32) {
    let ends = mesh.crease_ends(v);
    let ear = mesh.star(v).iter().map(|&f| mesh.face(f)).find(|face| ends.iter().all(|w| face.contains(w)));
    if let Some(face) = ear {
        let k = face.iter().position(|&w| w == v).expect("a star's face holds its vertex");
        try_flip(mesh, map, face[(k + 1) % 3], face[(k + 2) % 3], f64::NEG_INFINITY);
    }
}

/// Flips the edge from `a` to `b` if it gains at least `least_gain` and the faces unfold to a convex quadrilateral.
fn try_flip(mesh: &mut WorkingMesh, map: &mut Parameterisation, a: u32, b: u32, least_gain: f64) -> bool {
    let [Some(left), Some(right)] = mesh.sides(a, b) else { return false };
    let [c, d] =
        [left, right].map(|f| mesh.face(f).into_iter().find(|&v| v != a && v != b).expect("a corner"));
    if mesh.sides(c, d) != [None; 2] || mesh.is_crease(a, b) || (mesh.is_seam(c) && mesh.is_seam(d)) {
        return false;
    }
    // Between two sharp edges stay the faces that are there, for wide angles need more than one.
    let closes = |v: u32| mesh.is_crease(v, c) && mesh.is_crease(v, d);
    if closes(a) || closes(b) {
        return false;
    }
    let [pa, pb, pc, pd] = [a, b, c, d].map(|v| mesh.positions[v as usize]);
    let (n, m) = ((pb - pa).cross(pc - pa), (pa - pb).cross(pd - pb));
    if least_gain.is_finite() && n.dot(m) < LEAST_COSINE * n.length() * m.length() {
        return false;
    }
    let excess = |v: u32, change: i64| {
        let ideal = if mesh.is_boundary(v) && !mesh.is_seam(v) { 4 } else { 6 };
        let off = mesh.valence_with(v, (mesh.star(v).len() as i64 + change) as usize) as i64 - ideal;
        // One vertex of the seam stands beside two of any other.
        (off * off) as f64 * if mesh.is_seam(v) { 0.5 } else { 1.0 }
    };
    let valences = excess(a, 0) + excess(b, 0) + excess(c, 0) + excess(d, 0)
        - (excess(a, -1) + excess(b, -1) + excess(c, 1) + excess(d, 1));
    // Two faces at a boundary vertex, three at any other; four neighbours are better.
    if [a, b].iter().any(|&v| mesh.valence_with(v, mesh.star(v).len() - 1) < 3) {
        return false;
    }
    let worse = |one: [DVec3; 3], other: [DVec3; 3]| quality(one).min(quality(other));
    let gain = worse([pc, pa, pd], [pd, pb, pc]) - worse([pa, pb, pc], [pb, pa, pd]);
    if gain + VALENCE_VALUE * valences < least_gain {
        return false;
    }
    let Some(plane) = unfold([pa, pb, pc, pd]) else { return false };
    // Corners in the order of the faces as they are stored.
    let local = |v: u32| [a, b, c, d].iter().position(|&w| w == v).expect("one of the four") as u8;
    let before = [left, right].map(|f| (f, mesh.face(f).map(local)));
    map.record(&plane, before.into_iter(), [[2, 0, 3], [3, 1, 2]].into_iter());
    mesh.replace(&[left, right], &[[c, a, d], [d, b, c]]);
    true
}

/// The four corners of two faces in one plane, if both pairs of triangles are sound there.
fn unfold([a, b, c, d]: [DVec3; 4]) -> Option<[DVec2; 4]> {
    let along = b - a;
    let length = along.length();
    let place = |p: DVec3, side: f64| {
        DVec2::new((p - a).dot(along) / length, side * along.cross(p - a).length() / length)
    };
    let plane = [DVec2::ZERO, DVec2::new(length, 0.0), place(c, 1.0), place(d, -1.0)];
    let sound = [[0, 1, 2], [1, 0, 3], [2, 0, 3], [3, 1, 2]].into_iter().all(|[i, j, k]: [usize; 3]| {
        let (p, q, r) = (plane[i], plane[j], plane[k]);
        let sides = [p.distance_squared(q), q.distance_squared(r), r.distance_squared(p)];
        let least = sides[0].min(sides[1]).min(sides[2]);
        let doubled = (q - p).perp_dot(r - p);
        doubled > 0.0 && doubled * doubled * least > LEAST_SINE * LEAST_SINE * sides[0] * sides[1] * sides[2]
    });
    sound.then_some(plane)
}
