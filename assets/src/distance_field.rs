//! Signed distance fields: primitives, smooth blends, and the projection of points onto a field's zero set.
//!
//! Guarantees: every primitive is negative inside, positive outside, zero on its surface, and continuous.
//!
//! Non-guarantees: values away from the surface are estimates (an ellipsoid's, a blend's), so a projection divides by
//! the gradient's length and iterates rather than trusting one step.

use crate::vector::{Vec3, vec3};

/// A sphere.
pub fn sphere(p: Vec3, centre: Vec3, radius: f64) -> f64 {
    (p - centre).length() - radius
}

/// An axis-aligned ellipsoid, to first order: exact on the surface, its gradient of length one there.
pub fn ellipsoid(p: Vec3, centre: Vec3, radii: Vec3) -> f64 {
    let offset = p - centre;
    let unit = offset.divided(radii);
    let (reach, slope) = (unit.length(), unit.divided(radii).length());
    // At the very centre the estimate is 0/0; the shortest radius is the distance there.
    if slope < 1e-9 { -radii.x.min(radii.y).min(radii.z) } else { reach * (reach - 1.0) / slope }
}

/// A tube from `a` to `b` whose radius runs linearly from `radii.0` to `radii.1`.
///
/// Measured to the nearest axis point, not along the cone's normal: a slight underestimate on steep tapers.
pub fn tapered_capsule(p: Vec3, a: Vec3, b: Vec3, radii: (f64, f64)) -> f64 {
    let axis = b - a;
    let along = ((p - a).dot(axis) / axis.dot(axis)).clamp(0.0, 1.0);
    (p - a - axis * along).length() - (radii.0 + (radii.1 - radii.0) * along)
}

/// The union of two fields, rounded within `k` of where they meet.
pub fn smooth_union(a: f64, b: f64, k: f64) -> f64 {
    let h = (k - (a - b).abs()).max(0.0) / k;
    a.min(b) - h * h * k * 0.25
}

/// What both fields have in common, rounded within `k` of where they meet.
pub fn smooth_intersection(a: f64, b: f64, k: f64) -> f64 {
    -smooth_union(-a, -b, k)
}

/// `a` with `b` taken away, rounded within `k` of the cut.
pub fn smooth_subtraction(a: f64, b: f64, k: f64) -> f64 {
    smooth_intersection(a, -b, k)
}

/// 0 below `low`, 1 above `high`, a cubic between.
pub fn smoothstep(low: f64, high: f64, value: f64) -> f64 {
    let t = ((value - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A bell of height one around zero that vanishes from `width` on.
pub fn bell(value: f64, width: f64) -> f64 {
    let t = (value / width).abs();
    if t >= 1.0 { 0.0 } else { (1.0 - t * t) * (1.0 - t * t) }
}

/// The gradient of `field` at `p` by four samples at the corners of a small tetrahedron.
///
/// The step of 1e-4 sits far below any feature (1e-2) and far above rounding (1e-16 / 1e-4).
pub fn gradient(field: &(impl Fn(Vec3) -> f64 + ?Sized), p: Vec3) -> Vec3 {
    const STEP: f64 = 1e-4;
    let corners = [vec3(1.0, -1.0, -1.0), vec3(-1.0, -1.0, 1.0), vec3(-1.0, 1.0, -1.0), vec3(1.0, 1.0, 1.0)];
    let mut sum = Vec3::default();
    for corner in corners {
        sum += corner * field(p + corner * STEP);
    }
    sum * (0.25 / STEP)
}

/// Moves `p` onto the zero set of `field` by Newton steps along the gradient, each at most `longest`.
///
/// Stops within 1e-7 of the surface or after 24 steps; where the gradient vanishes the point stays.
pub fn project(field: &(impl Fn(Vec3) -> f64 + ?Sized), mut p: Vec3, longest: f64) -> Vec3 {
    for _ in 0..24 {
        let value = field(p);
        if value.abs() < 1e-7 {
            break;
        }
        let slope = gradient(field, p);
        let steepness = slope.length();
        if steepness < 1e-6 {
            break;
        }
        let step = (value / steepness).clamp(-longest, longest);
        p = p - slope * (step / steepness);
    }
    p
}

#[cfg(test)]
mod tests {
    use super::*;

    const PROBES: [Vec3; 4] =
        [vec3(0.9, 0.1, -0.3), vec3(-0.2, 1.4, 0.4), vec3(0.1, -0.1, 0.9), vec3(-0.7, -0.6, -0.5)];

    fn potato(p: Vec3) -> f64 {
        let body = ellipsoid(p, vec3(0.1, 0.0, 0.0), vec3(0.8, 1.1, 0.6));
        let bump = tapered_capsule(p, vec3(0.0, 0.5, 0.2), vec3(0.3, 0.9, 0.8), (0.3, 0.1));
        smooth_subtraction(smooth_union(body, bump, 0.2), sphere(p, vec3(-0.9, 0.0, 0.0), 0.3), 0.1)
    }

    #[test]
    fn projection_lands_on_the_surface() {
        for probe in PROBES {
            let landed = project(&potato, probe, 0.1);
            assert!(potato(landed).abs() < 1e-6, "{landed:?}");
        }
    }

    #[test]
    fn gradients_point_outwards_with_length_near_one() {
        for probe in PROBES {
            let landed = project(&potato, probe, 0.1);
            let slope = gradient(&potato, landed);
            assert!((slope.length() - 1.0).abs() < 0.2, "{slope:?}");
            assert!(potato(landed + slope * 0.01) > 0.0 && potato(landed - slope * 0.01) < 0.0);
        }
    }

    #[test]
    fn blends_keep_their_distance() {
        assert_eq!(smooth_union(1.0, 3.0, 0.5), 1.0);
        assert!(smooth_union(1.0, 1.0, 0.4) < 1.0);
        assert!(smooth_intersection(1.0, 1.0, 0.4) > 1.0);
        assert_eq!(smooth_subtraction(-1.0, 2.0, 0.5), -1.0);
    }
}
