//! How good triangles and base meshes are, in numbers.

use bozzetto_core::hierarchy::BaseMesh;
use bozzetto_core::mesh::{FaceIndex, TriangleMesh};
use glam::DVec3;

/// The width of a bin of the histogram of angles, in degrees.
pub(super) const BIN: f64 = 5.0;
/// Bins up to 60 degrees, which the smallest angle of a triangle cannot exceed.
const BINS: usize = 12;
/// Triangles whose smallest angle is above this count as well shaped, in degrees.
pub(super) const WELL_SHAPED: f64 = 15.0;

/// The smallest angles of a mesh's triangles.
pub(super) struct Angles {
    /// How many lie in each bin of [`BIN`] degrees.
    pub(super) counts: [usize; BINS],
    /// The share above [`WELL_SHAPED`] degrees, 0 to 1.
    pub(super) well_shaped: f64,
    /// The smallest of all, in degrees.
    pub(super) least: f64,
}

impl Angles {
    /// Measures all triangles. A triangle without area has an angle of 0.
    pub(super) fn of(mesh: &TriangleMesh) -> Self {
        let mut angles = Self { counts: [0; BINS], well_shaped: 0.0, least: 60.0 };
        let mut good = 0usize;
        for face in 0..mesh.faces.len() as u32 {
            let angle = smallest_angle(mesh.corners(FaceIndex(face)));
            angles.counts[((angle / BIN) as usize).min(BINS - 1)] += 1;
            angles.least = angles.least.min(angle);
            good += usize::from(angle > WELL_SHAPED);
        }
        angles.well_shaped = good as f64 / mesh.faces.len().max(1) as f64;
        angles
    }
}

/// In degrees, 0 to 60.
fn smallest_angle(corners: [[f64; 3]; 3]) -> f64 {
    let [a, b, c] = corners.map(DVec3::from);
    let angle = |at: DVec3, p: DVec3, q: DVec3| {
        let (u, v) = (p - at, q - at);
        u.cross(v).length().atan2(u.dot(v)).to_degrees()
    };
    let least = angle(a, b, c).min(angle(b, c, a)).min(angle(c, a, b));
    if least.is_finite() { least } else { 0.0 }
}

/// How many base vertices have which valence.
pub(super) struct Valences {
    /// Valence, vertices inside, vertices on the boundary; ascending, none without vertices.
    pub(super) rows: Vec<(usize, usize, usize)>,
    /// The share of regular vertices, 0 to 1.
    pub(super) regular: f64,
}

impl Valences {
    /// Counts a base mesh's vertices.
    pub(super) fn of(base: &BaseMesh) -> Self {
        let mut counts = std::collections::BTreeMap::<usize, (usize, usize)>::new();
        let mut regular = 0usize;
        for vertex in 0..base.vertex_count() {
            let fan = base.fan(vertex);
            let (inside, boundary) = counts.entry(fan.corners.len()).or_default();
            *(if fan.closed { inside } else { boundary }) += 1;
            regular += usize::from(base.is_regular(vertex));
        }
        Self {
            rows: counts
                .into_iter()
                .map(|(valence, (inside, boundary))| (valence, inside, boundary))
                .collect(),
            regular: regular as f64 / f64::from(base.vertex_count().max(1)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bozzetto_core::mesh::shapes;

    #[test]
    fn angles_fall_into_their_bins() {
        let equal = Angles::of(&shapes::octahedron());
        assert_eq!((equal.counts[11], equal.well_shaped), (8, 1.0));
        let right = Angles::of(&shapes::triangle());
        assert_eq!(right.counts.iter().position(|&n| n == 1), Some(9), "45 degrees");
        let needle = TriangleMesh::new(
            vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.05, 0.0], [2.0, 0.0, 0.0]],
            vec![[0, 1, 2], [0, 1, 3]],
        );
        let thin = Angles::of(&needle);
        assert_eq!((thin.counts[0], thin.well_shaped, thin.least), (2, 0.0, 0.0));
    }

    #[test]
    fn valences_are_counted_inside_and_on_the_boundary() {
        let mesh = shapes::disc(7);
        let base = BaseMesh::new(8, mesh.faces, &[]).expect("a base mesh");
        let found = Valences::of(&base);
        assert_eq!(found.rows, [(2, 0, 7), (7, 1, 0)]);
        assert_eq!(found.regular, 0.0);
        let mesh = shapes::torus(4, 3);
        let base = BaseMesh::new(12, mesh.faces, &[]).expect("a base mesh");
        assert_eq!((Valences::of(&base).rows, Valences::of(&base).regular), (vec![(6, 12, 0)], 1.0));
    }
}
