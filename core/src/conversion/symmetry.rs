//! The mirror plane of a nearly symmetric surface, and how nearly it is one.
//!
//! Most of the surface tells where the plane is: distances beyond a scale count no more than the scale, which falls from
//! step to step (after Blake & Zisserman 1987, graduated non-convexity), so a part that is on one side only has little
//! say. How nearly the surface is symmetric is told by all of it.

use super::remesh::RemeshError;
use super::simplify::Cancelled;
use crate::mesh::{AreaSampler, BoundingVolumes, TriangleMesh};
use glam::DVec3;
use rayon::prelude::*;

/// A coordinate axis of the model, as its file has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Axis {
    /// The x axis: left and right are mirrored where y is up.
    X,
    /// The y axis.
    Y,
    /// The z axis.
    Z,
}

impl Axis {
    /// All of them.
    pub const ALL: [Axis; 3] = [Axis::X, Axis::Y, Axis::Z];

    /// Its place among the coordinates.
    pub fn index(self) -> usize {
        self as usize
    }
}

impl std::fmt::Display for Axis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(["x", "y", "z"][self.index()])
    }
}

/// Points of the surface whose mirror images are looked up, and how many at a time.
const SAMPLES: u64 = 8_192;
const CHUNK: u64 = 256;
/// A surface is nearly symmetric if its mirror image lies no further from it than this, root mean square over the
/// bounding-box diagonal. A head 0.004 off has 2.6 times the error that it has without symmetry, a bear 0.013 off five times, a
/// figure in a pose, 0.015 off, thirty times; made models are below 0.003.
pub(super) const NEARLY: f64 = 0.01;
/// Planes the search begins at, evenly over the bounding box, and the points looked up for each.
const PLANES: u32 = 24;
const FEW: u64 = 1_024;
/// What counts of a distance at most, over the diagonal: when planes to begin at are compared, step by step, and when the
/// one found is compared with 0 and the middle.
const WIDEST: f64 = 0.05;
const SCALES: [f64; 4] = [0.05, 0.02, 0.007, 0.002];
const COMPARED: f64 = 0.02;
/// Times the plane is moved at each scale to where the surface and its image lie more nearly on one another.
const SHIFTS: usize = 6;
/// A plane is better than another if its distances are below this part of the other's.
const BETTER: f64 = 0.95;

/// How a surface lies beside its mirror image.
#[derive(Debug, Clone, Copy, Default)]
struct Beside {
    /// Mean square of the distances, and of those cut at a scale.
    whole: f64,
    cut: f64,
    /// How far the plane should move, by the distances below the scale.
    shift: f64,
}

/// Where the plane across an axis lies in which a surface is mirrored onto itself most nearly: 0 or the middle of the bounding
/// box if no other is better by much. `go_on` is asked often. Cost: a tree, and some 200,000 queries at most.
///
/// # Errors
/// There is no surface, it is not nearly symmetric, or `go_on` answered no.
pub(super) fn mirror_plane(
    mesh: &TriangleMesh,
    axis: Axis,
    go_on: &dyn Fn() -> bool,
) -> Result<f64, RemeshError> {
    let k = axis.index();
    let bounds = mesh.bounds().ok_or(RemeshError::Empty)?;
    let tree = BoundingVolumes::build_while(mesh, &mut || go_on()).map_err(|_| Cancelled)?;
    let image =
        Image { tree: tree.ok_or(RemeshError::Empty)?, sampler: AreaSampler::new(mesh, SAMPLES, 1), k };
    let beside = |plane: f64, scale: f64, samples: u64| {
        if go_on() { Ok(image.beside(plane, scale * bounds.diagonal(), samples)) } else { Err(Cancelled) }
    };
    let (low, high) = (bounds.min[k], bounds.max[k]);
    let middle = low * 0.5 + high * 0.5;
    // A model made in its plane is not moved out of it by what is uneven about it.
    let made = if (low..=high).contains(&0.0) { vec![0.0, middle] } else { vec![middle] };
    let spread = (0..PLANES).map(|n| low + (high - low) * (f64::from(n) + 0.5) / f64::from(PLANES));
    let (mut plane, mut least) = (middle, f64::INFINITY);
    for start in made.iter().copied().chain(spread) {
        let cut = beside(start, WIDEST, FEW)?.cut;
        if cut < BETTER * least {
            (plane, least) = (start, cut);
        }
    }
    for scale in SCALES {
        let mut best = beside(plane, scale, SAMPLES)?;
        for _ in 0..SHIFTS {
            let shifted = plane + best.shift;
            let then = beside(shifted, scale, SAMPLES)?;
            if then.cut > BETTER * best.cut {
                break;
            }
            (plane, best) = (shifted, then);
        }
    }
    let mut best = beside(plane, COMPARED, SAMPLES)?;
    for other in made.into_iter().rev() {
        let then = beside(other, COMPARED, SAMPLES)?;
        if BETTER * then.cut <= best.cut {
            (plane, best) = (other, then);
        }
    }
    let rms = best.whole.sqrt() / bounds.diagonal();
    if rms <= NEARLY { Ok(plane) } else { Err(RemeshError::NotSymmetric { axis, rms }) }
}

/// A surface whose mirror images are looked up.
struct Image<'m> {
    tree: BoundingVolumes,
    sampler: AreaSampler<'m>,
    /// The axis across the planes.
    k: usize,
}

impl Image<'_> {
    /// How every so many samples' images lie in a plane.
    fn beside(&self, plane: f64, scale: f64, samples: u64) -> Beside {
        let k = self.k;
        let stride = (SAMPLES / samples) as usize;
        let of_chunk = |chunk: u64| {
            let mut cursor = self.tree.cursor();
            let mut sums = [0.0; 4];
            for (point, _) in
                self.sampler.points_and_faces(chunk * CHUNK..(chunk + 1) * CHUNK).step_by(stride)
            {
                let mut image = point.to_array();
                image[k] = 2.0 * plane - image[k];
                let way = DVec3::from(cursor.closest(image).point) - DVec3::from(image);
                let squared = way.length_squared();
                sums[0] += squared;
                sums[1] += squared.min(scale * scale);
                if squared > 0.0 && squared <= scale * scale {
                    sums[2] += way[k];
                    sums[3] += way[k] * way[k] / squared;
                }
            }
            sums
        };
        let sums: Vec<[f64; 4]> = (0..SAMPLES / CHUNK).into_par_iter().map(of_chunk).collect();
        let [whole, cut, along, slope] =
            std::array::from_fn(|c| sums.iter().map(|sums| sums[c]).sum::<f64>());
        Beside {
            whole: whole / samples as f64,
            cut: cut / samples as f64,
            shift: if slope > 0.0 { 0.5 * along / slope } else { 0.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn lumpy(shift: f64) -> TriangleMesh {
        let mut mesh = shapes::subdivide(&shapes::octahedron(), 5);
        for p in &mut mesh.positions {
            let [x, y, z] = DVec3::from(*p).normalize().to_array();
            let lump = 1.0 + 0.2 * (3.0 * y).sin() + 0.1 * (5.0 * x.abs() + 2.0 * z).cos();
            *p = [lump * x + shift, lump * y, 1.5 * lump * z];
        }
        mesh
    }

    fn plane(mesh: &TriangleMesh, axis: Axis) -> Result<f64, RemeshError> {
        mirror_plane(mesh, axis, &|| true)
    }

    #[test]
    fn the_plane_is_found_wherever_it_is() {
        for shift in [0.0, 0.001, 17.0, -400.0] {
            let plane = plane(&lumpy(shift), Axis::X).expect("it is symmetric");
            assert!((plane - shift).abs() < 1e-9, "{plane} for {shift}");
        }
    }

    /// The middle of the box lies 0.4 off the plane because of a horn on one side.
    #[test]
    fn a_horn_on_one_side_hardly_moves_the_plane() {
        let mut mesh = lumpy(3.0);
        let far =
            (0..mesh.positions.len()).max_by(|&a, &b| mesh.positions[a][0].total_cmp(&mesh.positions[b][0]));
        mesh.positions[far.expect("vertices")][0] += 0.8;
        let plane = plane(&mesh, Axis::X).expect("it is nearly symmetric");
        assert!((plane - 3.0).abs() < 1e-2, "{plane}");
    }

    /// Rings that hang on one side, small and large, move the middle of the box by up to half the body's width.
    #[test]
    fn a_ring_on_one_side_hardly_moves_the_plane() {
        for (size, off) in [(0.06, 1.1), (0.1, 1.3), (0.02, 2.2)] {
            let mut ring = shapes::torus(16, 24);
            ring.positions.iter_mut().for_each(|p| *p = [p[0] * size + off - 3.0, p[1] * size, p[2] * size]);
            let mesh = shapes::together(&[lumpy(0.0), ring]);
            let mesh = TriangleMesh {
                positions: mesh.positions.iter().map(|p| [p[0] + 3.0, p[1], p[2]]).collect(),
                ..mesh
            };
            let found = plane(&mesh, Axis::X);
            let found = found.unwrap_or_else(|error| panic!("ring {size} at {off}: {error}"));
            assert!((found - 3.0).abs() < 2e-3, "ring {size} at {off}: {found}");
        }
    }

    #[test]
    fn what_is_not_symmetric_is_refused_with_how_far_it_is_off() {
        let mut mesh = lumpy(0.0);
        mesh.positions.iter_mut().for_each(|p| p[0] += 0.5 * p[1] * p[1]);
        match plane(&mesh, Axis::X) {
            Err(RemeshError::NotSymmetric { axis: Axis::X, rms }) => {
                assert!(rms > NEARLY && rms < 0.2, "{rms}")
            }
            other => panic!("{other:?}"),
        }
        assert!(plane(&mesh, Axis::Z).is_err(), "lumps differ along z");
    }

    #[test]
    fn the_search_ends_at_every_answer_no() {
        let mesh = lumpy(0.0);
        let asked = std::cell::Cell::new(0);
        let up_to = |last: u32| {
            asked.set(0);
            mirror_plane(&mesh, Axis::X, &|| asked.replace(asked.get() + 1) < last)
        };
        up_to(u32::MAX).expect("it is symmetric");
        let all = asked.get();
        assert!(all > 20, "{all}");
        for last in 0..all {
            assert_eq!(up_to(last), Err(RemeshError::Cancelled), "question {last}");
            assert_eq!(asked.get(), last + 1, "nothing is asked after the answer no");
        }
    }
}
