//! Flattening small patches: the neighbourhood of an edge before and after its collapse, in one plane with one
//! outline.
//!
//! Both patches are laid out together by least squares conformal maps (Lévy, Petitjean, Ray, Maillot 2002), their
//! outlines being the same unknowns (Liu et al. 2021, *Surface multigrid via intrinsic prolongation*, section 4).
//! What comes back is checked: every triangle positive and not too thin, and the new vertex's fan winds round it once,
//! so outline and map are one to one.

use glam::{DVec2, DVec3};

/// A triangle is laid out as if at least this high over its longest side, so degenerate ones have a shape.
const LEAST_HEIGHT: f64 = 1e-3;

/// A patch before and after a change, with corners as local vertex numbers.
#[derive(Debug, Default, Clone)]
pub(super) struct Patches {
    /// Where the vertices are in space.
    pub(super) positions: Vec<DVec3>,
    /// The triangles before.
    pub(super) before: Vec<[u8; 3]>,
    /// The triangles after, all of them round `centre`.
    pub(super) after: Vec<[u8; 3]>,
    /// The vertex in the middle of the triangles after.
    pub(super) centre: u8,
    /// Whether `centre` lies on the boundary of the surface.
    pub(super) open: bool,
    /// Vertices to be laid on one straight line, the first and the last its ends.
    pub(super) straight: Vec<u8>,
}

/// One coordinate of one vertex: known, or the unknown of that number.
#[derive(Clone, Copy)]
enum Place {
    Known(f64),
    Unknown(usize),
}

/// Working memory, used again from patch to patch.
#[derive(Debug, Default, Clone)]
pub(super) struct Flattener {
    matrix: Vec<f64>,
    right: Vec<f64>,
    /// The plane position of each local vertex, after [`Flattener::flatten`] said yes.
    pub(super) plane: Vec<DVec2>,
}

impl Flattener {
    /// Lays the patches out in the plane. False if they cannot be laid out one to one with every angle's sine
    /// above `least_sine`.
    pub(super) fn flatten(&mut self, patches: &Patches, least_sine: f64) -> bool {
        let places = places(patches);
        let unknowns = places.iter().flatten().filter(|place| matches!(place, Place::Unknown(_))).count();
        self.matrix.clear();
        self.matrix.resize(unknowns * unknowns, 0.0);
        self.right.clear();
        self.right.resize(unknowns, 0.0);
        for triangle in patches.before.iter().chain(&patches.after) {
            self.add_triangle(unknowns, &places, triangle, &patches.positions);
        }
        if !solve_in_place(&mut self.matrix, &mut self.right, unknowns) {
            return false;
        }
        let value = |place: Place| match place {
            Place::Known(x) => x,
            Place::Unknown(k) => self.right[k],
        };
        self.plane.clear();
        self.plane.extend(places.iter().map(|&[x, y]| DVec2::new(value(x), value(y))));
        self.is_one_to_one(patches, least_sine)
    }

    /// Adds the conformal energy of one triangle: `|Σ W_k z_k|² / 2A`, `W_k` the side opposite corner k.
    fn add_triangle(&mut self, n: usize, places: &[[Place; 2]], triangle: &[u8; 3], positions: &[DVec3]) {
        let Some(sides) = opposite_sides(triangle.map(|v| positions[usize::from(v)])) else { return };
        // Rows: the real part Σ (Wx x − Wy y) and the imaginary part Σ (Wx y + Wy x).
        let mut rows = [[(Place::Known(0.0), 0.0); 6]; 2];
        for (k, side) in sides.iter().enumerate() {
            let [x, y] = places[usize::from(triangle[k])];
            rows[0][2 * k] = (x, side.x);
            rows[0][2 * k + 1] = (y, -side.y);
            rows[1][2 * k] = (y, side.x);
            rows[1][2 * k + 1] = (x, side.y);
        }
        for row in rows {
            let known: f64 = row.iter().map(|(p, w)| if let Place::Known(x) = p { x * w } else { 0.0 }).sum();
            for &(place, w) in &row {
                let Place::Unknown(i) = place else { continue };
                self.right[i] -= w * known;
                for &(other, w2) in &row {
                    if let Place::Unknown(j) = other
                        && j <= i
                    {
                        self.matrix[i * n + j] += w * w2;
                    }
                }
            }
        }
    }

    fn is_one_to_one(&self, patches: &Patches, least_sine: f64) -> bool {
        let at = |v: u8| self.plane[usize::from(v)];
        let sound = |t: &[u8; 3]| {
            let [a, b, c] = t.map(at);
            let doubled = (b - a).perp_dot(c - a);
            let sides = [a.distance_squared(b), b.distance_squared(c), c.distance_squared(a)];
            // The least angle's sine is twice the area over the two longest sides.
            let least = sides[0].min(sides[1]).min(sides[2]);
            let product = sides[0] * sides[1] * sides[2] / least;
            doubled > 0.0 && doubled * doubled > least_sine * least_sine * product
        };
        if !patches.before.iter().chain(&patches.after).all(sound) {
            return false;
        }
        let mut turn = 0.0;
        for t in &patches.after {
            let Some(k) = t.iter().position(|&v| v == patches.centre) else { return false };
            let (p, q) = (at(t[(k + 1) % 3]) - at(t[k]), at(t[(k + 2) % 3]) - at(t[k]));
            turn += libm::atan2(p.perp_dot(q), p.dot(q));
        }
        let whole = std::f64::consts::TAU;
        if patches.open { turn < whole - 1e-3 } else { (turn - whole).abs() < 1e-6 }
    }
}

/// The sides opposite the corners of a triangle laid flat, divided by the root of twice its area.
fn opposite_sides([a, b, c]: [DVec3; 3]) -> Option<[DVec2; 3]> {
    let (ab, ac) = (b - a, c - a);
    let longest = ab.length_squared().max(ac.length_squared()).max(b.distance_squared(c)).sqrt();
    let base = ab.length().max(LEAST_HEIGHT * longest);
    if !base.is_finite() || base <= 0.0 {
        return None;
    }
    let doubled = ab.cross(ac).length().max(LEAST_HEIGHT * longest * longest);
    let along = if ab.length() > 0.0 { ab.dot(ac) / base } else { 0.0 };
    let (p, q, r) = (DVec2::ZERO, DVec2::new(base, 0.0), DVec2::new(along, doubled / base));
    let scale = 1.0 / doubled.sqrt();
    Some([(r - q) * scale, (p - r) * scale, (q - p) * scale])
}

/// Which coordinates are known: two vertices are pinned, and a straight line is the x axis.
fn places(patches: &Patches) -> Vec<[Place; 2]> {
    let count = patches.positions.len();
    let mut known = vec![[None; 2]; count];
    if let (Some(&first), Some(&last)) = (patches.straight.first(), patches.straight.last()) {
        patches.straight.iter().for_each(|&v| known[usize::from(v)][1] = Some(0.0));
        let length = patches.positions[usize::from(first)].distance(patches.positions[usize::from(last)]);
        known[usize::from(first)][0] = Some(0.0);
        known[usize::from(last)][0] = Some(length.max(f64::MIN_POSITIVE));
    } else {
        let (p, q) = far_apart(patches);
        known[p] = [Some(0.0); 2];
        known[q] = [Some(patches.positions[p].distance(patches.positions[q])), Some(0.0)];
    }
    let mut unknowns = 0;
    let mut place = |known: Option<f64>| match known {
        Some(x) => Place::Known(x),
        None => {
            unknowns += 1;
            Place::Unknown(unknowns - 1)
        }
    };
    known.into_iter().map(|[x, y]| [place(x), place(y)]).collect()
}

/// Two vertices of the outline far from one another.
fn far_apart(patches: &Patches) -> (usize, usize) {
    let outline: Vec<usize> = (0..patches.positions.len())
        .filter(|&v| v != usize::from(patches.centre) && patches.after.iter().any(|t| t.contains(&(v as u8))))
        .collect();
    let farthest = |from: DVec3| {
        let distance = |v: &&usize| patches.positions[**v].distance_squared(from);
        outline.iter().max_by(|v, w| distance(v).total_cmp(&distance(w))).copied().unwrap_or(0)
    };
    let p = farthest(patches.positions[usize::from(patches.centre)]);
    (p, farthest(patches.positions[p]))
}

/// Solves a symmetric positive definite system, its lower triangle given, by Cholesky's method; false if it is not
/// definite.
fn solve_in_place(matrix: &mut [f64], right: &mut [f64], n: usize) -> bool {
    for i in 0..n {
        for j in 0..=i {
            let (head, row_i) = matrix.split_at_mut(i * n);
            let inner: f64 = if j < i {
                let row_j = &head[j * n..j * n + j];
                row_i[..j].iter().zip(row_j).map(|(a, b)| a * b).sum()
            } else {
                row_i[..j].iter().map(|a| a * a).sum()
            };
            let rest = row_i[j] - inner;
            if j < i {
                row_i[j] = rest / head[j * n + j];
            } else {
                // Not definite, to rounding: the layout is not determined.
                if rest.is_nan() || rest <= 1e-14 * row_i[i] || rest <= 0.0 {
                    return false;
                }
                row_i[i] = rest.sqrt();
            }
        }
    }
    for i in 0..n {
        let inner: f64 = (0..i).map(|j| matrix[i * n + j] * right[j]).sum();
        right[i] = (right[i] - inner) / matrix[i * n + i];
    }
    for i in (0..n).rev() {
        let inner: f64 = (i + 1..n).map(|j| matrix[j * n + i] * right[j]).sum();
        right[i] = (right[i] - inner) / matrix[i * n + i];
    }
    right.iter().all(|x| x.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat hexagon with two vertices inside, and the same outline round one.
    fn hexagon(lift: f64) -> Patches {
        let mut positions: Vec<DVec3> = (0..6)
            .map(|k| {
                let angle = f64::from(k) * std::f64::consts::FRAC_PI_3;
                DVec3::new(angle.cos(), angle.sin(), 0.0)
            })
            .collect();
        positions.extend([
            DVec3::new(0.3, 0.0, lift),
            DVec3::new(-0.3, 0.0, -lift),
            DVec3::new(0.05, 0.0, 0.0),
        ]);
        let before =
            vec![[0, 1, 6], [1, 7, 6], [1, 2, 7], [2, 3, 7], [3, 4, 7], [4, 6, 7], [4, 5, 6], [5, 0, 6]];
        let after = (0..6u8).map(|k| [k, (k + 1) % 6, 8]).collect();
        Patches { positions, before, after, centre: 8, open: false, straight: Vec::new() }
    }

    #[test]
    fn a_flat_patch_keeps_its_shape() {
        let patches = hexagon(0.0);
        let mut flattener = Flattener::default();
        assert!(flattener.flatten(&patches, 0.05));
        for v in 0..9 {
            for w in 0..v {
                let plane = flattener.plane[v].distance(flattener.plane[w]);
                let space = patches.positions[v].distance(patches.positions[w]);
                assert!((plane - space).abs() < 1e-9, "{v} {w}: {plane} {space}");
            }
        }
    }

    #[test]
    fn a_bent_patch_is_laid_out_without_overlap() {
        let mut flattener = Flattener::default();
        assert!(flattener.flatten(&hexagon(0.4), 0.05));
    }

    #[test]
    fn a_folded_patch_is_refused() {
        let mut patches = hexagon(0.0);
        patches.after[2].swap(0, 1);
        assert!(!Flattener::default().flatten(&patches, 0.05));
    }

    #[test]
    fn a_straight_line_stays_straight() {
        // The upper half: boundary 3, 5, 4, 0 before and 3, 6, 0 after.
        let whole = hexagon(0.1);
        let patches = Patches {
            positions: [0, 1, 2, 3, 6, 7, 8].map(|v| whole.positions[v]).to_vec(),
            before: vec![[0, 1, 4], [1, 5, 4], [1, 2, 5], [2, 3, 5]],
            after: vec![[0, 1, 6], [1, 2, 6], [2, 3, 6]],
            centre: 6,
            open: true,
            straight: vec![3, 5, 4, 6, 0],
        };
        let mut flattener = Flattener::default();
        assert!(flattener.flatten(&patches, 0.05));
        assert!([3, 5, 4, 6, 0].iter().all(|&v: &usize| flattener.plane[v].y == 0.0));
        assert!(flattener.plane[5].x < flattener.plane[4].x);
    }
}
