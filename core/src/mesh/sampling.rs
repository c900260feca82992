//! Points spread evenly over a surface.
//!
//! The area is cut into as many equal strata as there are samples, in face order, and one point is drawn
//! in each: lower variance than independent points, and neighbours in the sequence lie near one another.
//! A sample depends on the seed and its own number alone, so any split of the work gives the same points.

use glam::DVec3;

use super::{FaceIndex, TriangleMesh};

/// SplitMix64 (Steele, Lea, Flood 2014, *Fast splittable pseudorandom number generators*): a counter
/// passed through a mixing function, so any position of the sequence is reached at once.
#[derive(Clone, Debug)]
pub(crate) struct SplitMix64 {
    state: u64,
}

/// The odd step of the counter: 2^64 over the golden ratio.
const GOLDEN_STEP: u64 = 0x9e37_79b9_7f4a_7c15;

impl SplitMix64 {
    /// The generator that starts at position `position` of the sequence of `seed`.
    pub(crate) fn at(seed: u64, position: u64) -> Self {
        // The seed is mixed first, or neighbouring seeds would be one sequence shifted.
        Self { state: mix(seed).wrapping_add(position.wrapping_mul(GOLDEN_STEP)) }
    }

    /// The next 64 bits.
    pub(crate) fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(GOLDEN_STEP);
        mix(self.state)
    }

    /// The next number in [0, 1), a multiple of 2^-53.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }
}

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Random numbers a sample takes: its place in the stratum, and two for its place in the face.
const DRAWS: u64 = 3;

/// Area-uniform samples of a mesh. Where every face is degenerate, each counts alike.
#[derive(Clone, Debug)]
pub(crate) struct AreaSampler<'m> {
    mesh: &'m TriangleMesh,
    /// The area of the faces up to and including each.
    cumulative: Vec<f64>,
    samples: u64,
    seed: u64,
}

impl<'m> AreaSampler<'m> {
    /// Prepares `samples` points on a mesh that has faces. Cost: one pass over the faces.
    pub(crate) fn new(mesh: &'m TriangleMesh, samples: u64, seed: u64) -> Self {
        let areas = |face: u32| {
            let [a, b, c] = mesh.corners(FaceIndex(face)).map(DVec3::from);
            (b - a).cross(c - a).length() * 0.5
        };
        let faces = mesh.faces.len() as u32;
        let mut cumulative = running_sums((0..faces).map(areas));
        if cumulative.last().is_none_or(|&total| total <= 0.0) {
            cumulative = running_sums((0..faces).map(|_| 1.0));
        }
        Self { mesh, cumulative, samples, seed }
    }

    /// The samples of a range of numbers, in order, with the face each lies on.
    pub(crate) fn points_and_faces(
        &self,
        numbers: std::ops::Range<u64>,
    ) -> impl Iterator<Item = (DVec3, FaceIndex)> {
        let total = self.cumulative.last().copied().unwrap_or(0.0);
        let last = self.cumulative.len() - 1;
        let mut face: Option<usize> = None;
        numbers.map(move |number| {
            let mut random = SplitMix64::at(self.seed, number.wrapping_mul(DRAWS));
            let area = (number as f64 + random.unit()) / self.samples as f64 * total;
            // Strata ascend, so after the first search the face is found by walking on.
            let mut found =
                face.unwrap_or_else(|| self.cumulative.partition_point(|&sum| sum <= area)).min(last);
            while found < last && self.cumulative[found] <= area {
                found += 1;
            }
            face = Some(found);
            let [a, b, c] = self.mesh.corners(FaceIndex(found as u32)).map(DVec3::from);
            let (root, along) = (random.unit().sqrt(), random.unit());
            let point = a * (1.0 - root) + b * (root * (1.0 - along)) + c * (root * along);
            (point, FaceIndex(found as u32))
        })
    }
}

fn running_sums(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut sum = 0.0;
    values
        .map(|value| {
            sum += value;
            sum
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn two_squares() -> TriangleMesh {
        // Two right triangles; the second has three times the area of the first.
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -3.0, 0.0]];
        TriangleMesh::new(positions, vec![[0, 1, 2], [0, 3, 1]])
    }

    #[test]
    fn the_generator_matches_the_published_sequence() {
        // First outputs of SplitMix64 for the state 1234567.
        let mut random = SplitMix64 { state: 1_234_567 };
        let bits = [random.bits(), random.bits(), random.bits()];
        assert_eq!(bits, [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]);
    }

    #[test]
    fn samples_fall_in_proportion_to_area() {
        let mesh = two_squares();
        let points: Vec<DVec3> =
            AreaSampler::new(&mesh, 4000, 7).points_and_faces(0..4000).map(|(point, _)| point).collect();
        assert_eq!(points.iter().filter(|point| point.y > 0.0).count(), 1000);
        let mean_x = points.iter().map(|point| point.x).sum::<f64>() / 4000.0;
        assert!((mean_x - 1.0 / 3.0).abs() < 0.02, "mean x {mean_x}");
    }

    #[test]
    fn any_split_of_the_work_gives_the_same_points() {
        let mesh = two_squares();
        let sampler = AreaSampler::new(&mesh, 1000, 3);
        let whole: Vec<DVec3> = sampler.points_and_faces(0..1000).map(|(point, _)| point).collect();
        let parts: Vec<DVec3> = (0..10)
            .flat_map(|part| sampler.points_and_faces(part * 100..part * 100 + 100))
            .map(|(point, _)| point)
            .collect();
        assert_eq!(whole, parts);
    }

    #[test]
    fn a_mesh_without_area_is_sampled_too() {
        let mesh = TriangleMesh::new(vec![[2.0; 3]], vec![[0, 0, 0]; 3]);
        let points: Vec<DVec3> =
            AreaSampler::new(&mesh, 6, 1).points_and_faces(0..6).map(|(point, _)| point).collect();
        assert!(points.iter().all(|point| point.distance(DVec3::splat(2.0)) < 1e-14));
    }
}
