//! A point of the parameter domain: where on the base mesh something lies, whatever the surface's shape.

use super::{Layout, Level, Site, Subtriangle};

/// A point of a base face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Address {
    /// The base face.
    pub face: u32,
    /// Barycentric coordinates of the face's second and third corner, from 0 to 1; the first has the rest.
    pub at: [f64; 2],
}

impl Address {
    /// The point of a triangle of a level with weights of its three corners, sum 1.
    pub fn within(triangle: Subtriangle, level: Level, weights: [f64; 3]) -> Self {
        let n = f64::from(level.segments());
        let corners = triangle.corners();
        let mix = |c: usize| {
            let [a, b, d] = corners.map(|corner| f64::from(corner[c]));
            (weights[0] * a + weights[1] * b + weights[2] * d) / n
        };
        Self { face: triangle.face, at: [mix(0), mix(1)] }
    }

    /// The triangle of a level that holds the point, and the weights of its corners.
    pub fn triangle(&self, level: Level) -> (Subtriangle, [f64; 3]) {
        let n = level.segments();
        let [x, y] = self.at.map(|t| t * f64::from(n));
        let r = (y.max(0.0) as u32).min(n - 1);
        let i = (x.max(0.0) as u32).min(n - 1 - r);
        let (u, v) = (x - f64::from(i), y - f64::from(r));
        let down = u + v > 1.0 && i + r + 1 < n;
        let weights = if down { [1.0 - v, u + v - 1.0, 1.0 - u] } else { [1.0 - u - v, u, v] };
        (Subtriangle { face: self.face, i, r, down }, weights)
    }

    /// The vertices of a level around the point with their hat functions' values there.
    pub fn corners(&self, layout: &Layout) -> [(Site, f64); 3] {
        let (triangle, weights) = self.triangle(layout.level());
        let n = layout.segments();
        let places = triangle.corners();
        std::array::from_fn(|k| {
            let [i, r] = places[k];
            (layout.site_at(self.face, [n - i - r, i, r]), weights[k])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_found_again_at_every_level() {
        let (triangle, weights) = (Subtriangle { face: 3, i: 5, r: 2, down: true }, [0.5, 0.25, 0.25]);
        let address = Address::within(triangle, Level(4), weights);
        assert_eq!(address.triangle(Level(4)), (triangle, weights));
        assert_eq!(address.triangle(Level(3)).0, triangle.parent());
        let corner = Address { face: 0, at: [0.0, 1.0] };
        assert_eq!(
            corner.triangle(Level(2)),
            (Subtriangle { face: 0, i: 0, r: 3, down: false }, [0.0, 0.0, 1.0])
        );
    }
}
