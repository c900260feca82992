//! Polygons into triangles.
//!
//! A triangle stays as it is. A quadrilateral is cut along its shorter diagonal if either would do, else
//! along the one that stays inside. A larger polygon is clipped ear by ear (Meisters 1975, *Polygons have
//! ears*) in the plane of its area vector, so concave ones are covered without folds. A polygon of `n`
//! corners always gives `n − 2` triangles with its own winding and no new vertices.
//!
//! Degenerate and self-crossing polygons have no right answer; they get triangles all the same.

use glam::{DVec2, DVec3};

use super::{Defect, LARGEST_COUNT, Parsed, Place, with_room};

/// Containment tests that ear clipping may spend on one file, a few seconds' worth; clipping `n` corners
/// takes up to about `n²`. Past it polygons are fanned: we choose to accept folded faces in a file of
/// absurd polygons rather than let it hold the program for hours.
const EAR_TEST_BUDGET: u64 = 1 << 30;

/// The polygons of a file in the making. While all are triangles they are kept as the mesh has them, once.
pub(super) struct Polygons {
    triangles: Vec<[u32; 3]>,
    /// Corners and arities from the first polygon on that is none.
    corners: Vec<u32>,
    arities: Vec<u32>,
}

impl Polygons {
    /// Room for so many triangles.
    pub(super) fn with_room(count: usize) -> Parsed<Self> {
        Ok(Self { triangles: with_room(count)?, corners: Vec::new(), arities: Vec::new() })
    }

    /// Adds a polygon with three corners at least.
    pub(super) fn push(&mut self, polygon: &[u32]) {
        match *polygon {
            [a, b, c] if self.arities.is_empty() => self.triangles.push([a, b, c]),
            _ => {
                self.corners.extend_from_slice(polygon);
                self.arities.push(polygon.len() as u32);
            }
        }
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.triangles.len() + self.arities.len()
    }

    /// How many corners each has.
    pub(super) fn arities(&self) -> impl Iterator<Item = u32> {
        std::iter::repeat_n(3, self.triangles.len()).chain(self.arities.iter().copied())
    }

    /// All as triangles, as [`triangulate`] cuts them.
    pub(super) fn into_triangles(self, positions: &[[f64; 3]]) -> Parsed<Vec<[u32; 3]>> {
        let Self { triangles: mut faces, corners, arities } = self;
        if arities.is_empty() {
            return Ok(faces);
        }
        let cut = triangulate(positions, &corners, &arities)?;
        if faces.len() as u64 + cut.len() as u64 > LARGEST_COUNT {
            return Err((Place::Whole, Defect::TooMany { what: "faces" }));
        }
        faces.try_reserve_exact(cut.len()).map_err(|_| (Place::Whole, Defect::OutOfMemory))?;
        faces.extend(cut);
        Ok(faces)
    }
}

/// Cuts the polygons whose corners stand one after another in `corners`, `arities[i]` for polygon `i`,
/// into triangles. Every corner must be an index into `positions`; every arity at least 3.
pub(super) fn triangulate(positions: &[[f64; 3]], corners: &[u32], arities: &[u32]) -> Parsed<Vec<[u32; 3]>> {
    let triangles: u64 = arities.iter().map(|&arity| u64::from(arity.saturating_sub(2))).sum();
    if triangles > LARGEST_COUNT {
        return Err((Place::Whole, Defect::TooMany { what: "faces" }));
    }
    let mut faces = with_room(triangles as usize)?;
    let mut budget = EAR_TEST_BUDGET;
    let mut rest = corners;
    for &arity in arities {
        let (polygon, after) = rest.split_at(arity as usize);
        rest = after;
        match *polygon {
            [a, b, c] => faces.push([a, b, c]),
            [a, b, c, d] => faces.extend(cut_quadrilateral(positions, [a, b, c, d])),
            _ => clip_ears(positions, polygon, &mut budget, &mut faces),
        }
    }
    Ok(faces)
}

fn position(positions: &[[f64; 3]], vertex: u32) -> DVec3 {
    DVec3::from(positions[vertex as usize])
}

/// Twice the polygon's area vector (Newell's formula), relative to its first corner.
fn area_vector(points: &[DVec3]) -> DVec3 {
    let origin = points[0];
    points.windows(2).map(|pair| (pair[0] - origin).cross(pair[1] - origin)).sum()
}

fn cut_quadrilateral(positions: &[[f64; 3]], corners: [u32; 4]) -> [[u32; 3]; 2] {
    let points = corners.map(|vertex| position(positions, vertex));
    let normal = area_vector(&points);
    // A diagonal stays inside if both triangles beside it face the way the polygon does.
    let faces_along =
        |a: usize, b: usize, c: usize| (points[b] - points[a]).cross(points[c] - points[a]).dot(normal) > 0.0;
    let first_inside = faces_along(0, 1, 2) && faces_along(0, 2, 3);
    let second_inside = faces_along(0, 1, 3) && faces_along(1, 2, 3);
    let first_shorter = points[0].distance_squared(points[2]) <= points[1].distance_squared(points[3]);
    let [a, b, c, d] = corners;
    if second_inside && !(first_inside && first_shorter) {
        [[a, b, d], [b, c, d]]
    } else {
        [[a, b, c], [a, c, d]]
    }
}

/// The polygon drawn in the plane across its area vector, counter-clockwise.
fn flattened(positions: &[[f64; 3]], polygon: &[u32]) -> Vec<DVec2> {
    let points: Vec<DVec3> = polygon.iter().map(|&vertex| position(positions, vertex)).collect();
    let normal = area_vector(&points).normalize_or(DVec3::Z);
    let right = normal.any_orthonormal_vector();
    let up = normal.cross(right);
    points.iter().map(|&point| point - points[0]).map(|arm| DVec2::new(arm.dot(right), arm.dot(up))).collect()
}

/// Twice the signed area of a triangle, positive when counter-clockwise.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

fn clip_ears(positions: &[[f64; 3]], polygon: &[u32], budget: &mut u64, faces: &mut Vec<[u32; 3]>) {
    let points = flattened(positions, polygon);
    let mut remaining: Vec<usize> = (0..polygon.len()).collect();
    let mut at = 0;
    let mut refused = 0;
    while remaining.len() > 3 && *budget > 0 {
        let count = remaining.len();
        at %= count;
        let ear = [remaining[(at + count - 1) % count], remaining[at], remaining[(at + 1) % count]];
        // After a whole round without an ear, the polygon crosses itself: clip what comes.
        if refused < count && !is_ear(&points, &remaining, ear, budget) {
            refused += 1;
            at += 1;
            continue;
        }
        faces.push(ear.map(|corner| polygon[corner]));
        remaining.remove(at);
        refused = 0;
    }
    // What is left, three corners or all that the budget did not reach, is fanned.
    let fan = remaining.windows(2).skip(1).map(|pair| [remaining[0], pair[0], pair[1]]);
    faces.extend(fan.map(|triangle| triangle.map(|corner| polygon[corner])));
}

/// Whether the triangle is convex and holds no other remaining corner. Corners that coincide with one of
/// its own do not block it, since polygons with bridged holes pass the same point twice.
fn is_ear(points: &[DVec2], remaining: &[usize], ear: [usize; 3], budget: &mut u64) -> bool {
    let [a, b, c] = ear.map(|corner| points[corner]);
    if turn(a, b, c) <= 0.0 {
        *budget = budget.saturating_sub(1);
        return false;
    }
    *budget = budget.saturating_sub(remaining.len() as u64);
    !remaining.iter().map(|&corner| points[corner]).any(|p| {
        p != a && p != b && p != c && turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(points: &[[f64; 3]]) -> Vec<[u32; 3]> {
        let corners: Vec<u32> = (0..points.len() as u32).collect();
        triangulate(points, &corners, &[points.len() as u32]).unwrap()
    }

    /// The areas of the triangles, signed by `normal`.
    fn areas(points: &[[f64; 3]], normal: DVec3) -> Vec<f64> {
        let area = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|vertex| DVec3::from(points[vertex as usize]));
            (b - a).cross(c - a).dot(normal) * 0.5
        };
        cut(points).iter().map(area).collect()
    }

    #[test]
    fn a_convex_quadrilateral_is_cut_along_its_shorter_diagonal() {
        let kite = [[0.0, 0.0, 0.0], [1.0, -0.5, 0.0], [4.0, 0.0, 0.0], [1.0, 0.5, 0.0]];
        assert_eq!(cut(&kite), [[0, 1, 3], [1, 2, 3]]);
        let turned = [kite[1], kite[2], kite[3], kite[0]];
        assert_eq!(cut(&turned), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn a_concave_quadrilateral_is_cut_at_its_reflex_corner() {
        // The dart's shorter diagonal lies outside it.
        let dart = [[0.0, 0.0, 0.0], [1.0, 0.3, 0.0], [0.8, 0.0, 0.0], [1.0, -0.3, 0.0]];
        let clockwise: Vec<_> = dart.iter().rev().copied().collect();
        assert!(areas(&clockwise, DVec3::Z).iter().all(|&area| area > 0.0));
        assert!(areas(&dart, -DVec3::Z).iter().all(|&area| area > 0.0));
    }

    #[test]
    fn a_corner_on_a_straight_side_makes_no_sliver() {
        let quadrilateral = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [1.0, 5.0, 0.0]];
        assert!(areas(&quadrilateral, DVec3::Z).iter().all(|&area| area > 1.0));
    }

    #[test]
    fn a_star_in_any_plane_is_covered_without_folds() {
        let corners = 24;
        let (right, up) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.48, 0.8, -0.36));
        let star = |index: u32| {
            let angle = f64::from(index) / f64::from(corners) * std::f64::consts::TAU;
            let radius = if index.is_multiple_of(2) { 1.0 } else { 0.15 };
            ((right * angle.cos() + up * angle.sin()) * radius + DVec3::splat(5.0)).to_array()
        };
        let points: Vec<[f64; 3]> = (0..corners).map(star).collect();
        let areas = areas(&points, right.cross(up));
        assert_eq!(areas.len(), corners as usize - 2);
        assert!(areas.iter().all(|&area| area > 0.0), "{areas:?}");
        let expected = 0.5 * f64::from(corners) * 0.15 * (std::f64::consts::TAU / f64::from(corners)).sin();
        assert!((areas.iter().sum::<f64>() - expected).abs() < 1e-12);
    }

    #[test]
    fn polygons_among_triangles_keep_their_places() {
        let positions: Vec<[f64; 3]> = (0..6).map(|k| [f64::from(k), f64::from(k * k), 0.0]).collect();
        let files: [&[&[u32]]; 4] =
            [&[&[0, 1, 2], &[2, 1, 3]], &[&[0, 1, 2], &[0, 1, 2, 3], &[3, 4, 5]], &[&[0, 1, 2, 3, 4]], &[]];
        for polygons in files {
            let mut together = Polygons::with_room(polygons.len()).unwrap();
            polygons.iter().for_each(|polygon| together.push(polygon));
            let arities: Vec<u32> = polygons.iter().map(|polygon| polygon.len() as u32).collect();
            let expected = triangulate(&positions, &polygons.concat(), &arities).unwrap();
            assert_eq!(together.into_triangles(&positions).unwrap(), expected);
        }
    }

    #[test]
    fn degenerate_polygons_keep_their_number_of_triangles() {
        assert_eq!(cut(&[[1.0; 3]; 7]).len(), 5);
        let bow = [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], [-1.0, 1.0, 0.0]];
        assert_eq!(cut(&bow).len(), 3);
    }

    #[test]
    fn an_absurd_polygon_is_fanned_when_the_budget_is_spent() {
        let points: Vec<[f64; 3]> = (0..50).map(|i| [f64::from(i), f64::from(i % 2), 0.0]).collect();
        let polygon: Vec<u32> = (0..50).collect();
        let mut faces = Vec::new();
        clip_ears(&points, &polygon, &mut 20, &mut faces);
        assert_eq!(faces.len(), 48);
    }
}
