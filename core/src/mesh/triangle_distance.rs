//! The point of a triangle closest to a given point.
//!
//! The plane of the triangle answers where the point projects inside all three edges; otherwise the
//! answer lies on an edge that the point is outside of, because a convex region's closest boundary point
//! is on an edge visible from the query. Heights are measured along the normal from the nearest point of
//! the boundary, which keeps needle-shaped triangles as exact as others; barycentric coordinates would
//! lose digits with the square of the aspect ratio.
//!
//! Degenerate triangles (a segment or a point) have no normal, so every edge counts as visible and they
//! are answered from their edges alone.

use glam::DVec3;

/// Below this square of height over length a triangle counts as a needle.
const NEEDLE: f64 = 1e-2;

/// The closest point on triangle `corners` to `p`, and its squared distance from `p`.
///
/// Extents and distances must lie between 1e-70 and 1e70, so that their fourth powers neither vanish nor
/// overflow; a smaller triangle is treated as degenerate.
pub(crate) fn closest_on_triangle(p: DVec3, corners: &[DVec3; 3]) -> (DVec3, f64) {
    let [a, b, c] = *corners;
    let normal = (b - a).cross(c - a);
    let squared_normal = normal.length_squared();
    let sides = [(a, b), (b, c), (c, a)];
    let nearest_of = |candidates: [bool; 3]| {
        let chosen = sides.iter().zip(candidates).filter(|(_, candidate)| *candidate);
        chosen.fold((a, (p - a).length_squared()), |best, (&(start, end), _)| {
            nearer(best, on_edge(p, start, end))
        })
    };

    // An edge's outward direction within the plane is edge × normal. The borderline counts as outside, and
    // so does everything where the triangle is degenerate and the normal 0.
    let outside = sides.map(|(start, end)| (end - start).cross(normal).dot(p - start) >= 0.0);
    if outside.contains(&true) {
        return nearest_of(outside);
    }
    // The height is taken from a corner, or for a needle from the nearest point of the boundary: its normal is badly
    // known along the needle, and so short a lever makes that error harmless.
    let longest = (b - a).length_squared().max((c - a).length_squared());
    let foot = if squared_normal > NEEDLE * longest * longest {
        (a, (p - a).length_squared())
    } else {
        nearest_of([true; 3])
    };
    let height = (p - foot.0).dot(normal);
    let scale = height / squared_normal;
    nearer(foot, (p - normal * scale, height * scale))
}

/// The closest point to `p` on a segment.
fn on_edge(p: DVec3, start: DVec3, end: DVec3) -> (DVec3, f64) {
    let edge = end - start;
    let along = (p - start).dot(edge);
    let squared_length = edge.length_squared();
    // Both ends are tested without dividing, so an edge of length 0 is its start.
    let point = if along <= 0.0 {
        start
    } else if along >= squared_length {
        end
    } else {
        start + edge * (along / squared_length)
    };
    (point, (p - point).length_squared())
}

fn nearer(one: (DVec3, f64), other: (DVec3, f64)) -> (DVec3, f64) {
    if other.1 < one.1 { other } else { one }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RIGHT: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    #[test]
    fn every_region_of_a_triangle() {
        let cases = [
            ([0.25, 0.25, 2.0], [0.25, 0.25, 0.0]), // inside
            ([-1.0, -1.0, 0.0], [0.0, 0.0, 0.0]),   // corner a
            ([3.0, -1.0, 0.0], [1.0, 0.0, 0.0]),    // corner b
            ([-1.0, 3.0, 1.0], [0.0, 1.0, 0.0]),    // corner c
            ([0.5, -2.0, 0.0], [0.5, 0.0, 0.0]),    // edge ab
            ([1.0, 1.0, 0.0], [0.5, 0.5, 0.0]),     // edge bc
            ([-2.0, 0.25, -1.0], [0.0, 0.25, 0.0]), // edge ca
            ([0.25, 0.25, 0.0], [0.25, 0.25, 0.0]), // on the surface
        ];
        for (query, expected) in cases {
            let (point, squared) = closest_on_triangle(query.into(), &RIGHT);
            assert_eq!(point.to_array(), expected, "query {query:?}");
            assert_eq!(squared, (DVec3::from(query) - point).length_squared(), "query {query:?}");
        }
    }

    #[test]
    fn a_corner_is_at_distance_exactly_zero() {
        let corners = [[0.1, 0.7, 0.3], [1.9, 0.2, 0.77], [0.4, 1.3, 5.1]].map(DVec3::from);
        for corner in corners {
            assert_eq!(closest_on_triangle(corner, &corners), (corner, 0.0));
        }
    }

    #[test]
    fn degenerate_triangles_are_segments_or_points() {
        let p = DVec3::new(1.0, 2.0, 0.0);
        let segment = [DVec3::ZERO, DVec3::X * 3.0, DVec3::X * 2.0];
        assert_eq!(closest_on_triangle(p, &segment), (DVec3::X, 4.0));
        let folded = [DVec3::X * 3.0, DVec3::ZERO, DVec3::X * 3.0];
        assert_eq!(closest_on_triangle(p, &folded), (DVec3::X, 4.0));
        assert_eq!(closest_on_triangle(p, &[DVec3::ZERO; 3]), (DVec3::ZERO, 5.0));
    }

    #[test]
    fn a_needle_keeps_its_own_points() {
        let needle =
            [DVec3::new(0.1, 0.2, 0.3), DVec3::new(1.1, 0.7, 0.9), DVec3::new(0.6, 0.45 + 1e-9, 0.6)];
        let inside = needle[0] * 0.3 + needle[1] * 0.3 + needle[2] * 0.4;
        assert!(closest_on_triangle(inside, &needle).1.sqrt() < 1e-15);
    }
}
