//! Quadric error metrics (Garland & Heckbert 1997, *Surface simplification using quadric error metrics*).

use glam::{DMat3, DVec3};

/// A quadratic function of a point, `x·Ax + 2 b·x + c`: a weighted sum of squared distances to planes and points.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Quadric {
    /// xx, xy, xz, yy, yz, zz of `A`.
    a: [f64; 6],
    b: DVec3,
    c: f64,
}

impl Quadric {
    /// `weight` times the squared distance to the plane through `point` with unit normal `normal`.
    pub(super) fn plane(normal: DVec3, point: DVec3, weight: f64) -> Self {
        let (n, w) = (normal, weight);
        let d = -n.dot(point);
        Self {
            a: [w * n.x * n.x, w * n.x * n.y, w * n.x * n.z, w * n.y * n.y, w * n.y * n.z, w * n.z * n.z],
            b: n * (w * d),
            c: w * d * d,
        }
    }

    /// `weight` times the squared distance to `point`.
    pub(super) fn point(point: DVec3, weight: f64) -> Self {
        Self {
            a: [weight, 0.0, 0.0, weight, 0.0, weight],
            b: point * -weight,
            c: weight * point.length_squared(),
        }
    }

    /// The sum of two.
    pub(super) fn plus(&self, other: &Self) -> Self {
        Self { a: std::array::from_fn(|k| self.a[k] + other.a[k]), b: self.b + other.b, c: self.c + other.c }
    }

    /// That of the mirror image in the plane x = 0.
    pub(super) fn mirrored(&self) -> Self {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        Self { a: [xx, -xy, -xz, yy, yz, zz], b: self.b.with_x(-self.b.x), c: self.c }
    }

    /// The value at a point; not below 0.
    pub(super) fn at(&self, x: DVec3) -> f64 {
        (x.dot(self.matrix() * x) + 2.0 * self.b.dot(x) + self.c).max(0.0)
    }

    /// The point of least value, if `A` can be inverted.
    fn minimum(&self) -> Option<DVec3> {
        let x = self.matrix().inverse() * -self.b;
        x.is_finite().then_some(x)
    }

    /// The point of least value if it is nearer than 1.5 lengths to the middle of the segment from `p` to `q`, else that
    /// on the segment.
    pub(super) fn minimum_near(&self, p: DVec3, q: DVec3) -> DVec3 {
        let near = |x: &DVec3| x.distance((p + q) * 0.5) <= 1.5 * p.distance(q);
        self.minimum().filter(near).unwrap_or_else(|| self.minimum_between(p, q))
    }

    /// The least value on the segment from `p` to `q`, and where.
    pub(super) fn minimum_between(&self, p: DVec3, q: DVec3) -> DVec3 {
        let along = q - p;
        let bend = along.dot(self.matrix() * along);
        let slope = along.dot(self.matrix() * p + self.b);
        let t = if bend > 0.0 { (-slope / bend).clamp(0.0, 1.0) } else { 0.5 };
        p + along * t
    }

    fn matrix(&self) -> DMat3 {
        let [xx, xy, xz, yy, yz, zz] = self.a;
        DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_planes_meet_in_the_minimum() {
        let corner = DVec3::new(0.3, -2.0, 1.5);
        let normals = [DVec3::X, DVec3::Y, DVec3::new(0.6, 0.0, 0.8)];
        let sum =
            normals.iter().fold(Quadric::default(), |sum, &n| sum.plus(&Quadric::plane(n, corner, 2.0)));
        let least = sum.minimum().expect("the planes are independent");
        assert!(least.distance(corner) < 1e-12);
        assert!(sum.at(least) < 1e-12);
        assert!((sum.at(corner + DVec3::Y) - 2.0).abs() < 1e-12);
        assert!((Quadric::point(corner, 3.0).at(corner + DVec3::X * 2.0) - 12.0).abs() < 1e-12);
    }

    #[test]
    fn the_least_value_on_a_segment() {
        let plane = Quadric::plane(DVec3::X, DVec3::new(0.25, 9.0, 0.0), 1.0);
        let at = plane.minimum_between(DVec3::ZERO, DVec3::X);
        assert!((at.x - 0.25).abs() < 1e-12);
    }
}
