//! How far points lie from a surface, each by itself: what a map of the error is painted with.

use super::bounding_volumes::BoundingVolumes;
use super::{CompareError, TriangleMesh};
use rayon::prelude::*;

/// Points measured one after another by one thread; each query starts from the answer before it.
const CHUNK: usize = 512;
/// Points between two calls of the progress function: some hundredths of a second of work.
const STRIDE: usize = 32 * CHUNK;

/// The distance of every point to the surface, in model units. The same bits for any number of threads.
///
/// `progress` is called from the calling thread with a fraction from 0 to 1 and returns whether to go on.
/// Cost: O((points + faces) log faces), the points spread over rayon's current pool.
///
/// # Errors
/// The surface has no faces, or the progress function asked to stop.
///
/// # Panics
/// If a face refers to a vertex that does not exist.
pub fn distances_to(
    surface: &TriangleMesh,
    points: &[[f64; 3]],
    progress: &dyn Fn(f32) -> bool,
) -> Result<Vec<f64>, CompareError> {
    let check = |done: f32| if progress(done) { Ok(()) } else { Err(CompareError::Cancelled) };
    check(0.0)?;
    let tree = BoundingVolumes::build_while(surface, &mut || progress(0.0))
        .map_err(|_| CompareError::Cancelled)?
        .ok_or(CompareError::SecondEmpty)?;
    let mut distances = vec![0.0; points.len()];
    let (mut done, all) = (0, points.len() as f32);
    for (distances, points) in distances.chunks_mut(STRIDE).zip(points.chunks(STRIDE)) {
        distances.par_chunks_mut(CHUNK).zip(points.par_chunks(CHUNK)).for_each(|(distances, points)| {
            let mut cursor = tree.cursor();
            for (distance, &point) in distances.iter_mut().zip(points) {
                *distance = cursor.closest(point).squared_distance.sqrt();
            }
        });
        done += distances.len();
        check(done as f32 / all)?;
    }
    Ok(distances)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use std::cell::Cell;

    #[test]
    fn distances_are_those_of_single_queries() {
        let surface = shapes::subdivide(&shapes::torus(7, 9), 1);
        let points: Vec<[f64; 3]> = (0..3000)
            .map(|k| [f64::from(k % 17) * 0.2 - 1.6, f64::from(k % 23) * 0.15 - 1.6, f64::from(k % 5) * 0.3])
            .collect();
        let found = distances_to(&surface, &points, &|_| true).expect("faces");
        let tree = BoundingVolumes::build(&surface).expect("faces");
        for (point, found) in points.iter().zip(&found) {
            let expected = tree.closest(*point).squared_distance.sqrt();
            assert!((found - expected).abs() < 1e-14, "{point:?}: {found}, not {expected}");
        }
        let on_it = distances_to(&surface, &surface.positions, &|_| true).expect("faces");
        assert!(on_it.iter().all(|&d| d < 1e-14));
    }

    #[test]
    fn a_refusal_is_the_last_question() {
        let surface = shapes::subdivide(&shapes::octahedron(), 6);
        let points = surface.positions.repeat(3);
        let up_to = |last: usize| {
            let asked = Cell::new(0);
            let refuse = |_| {
                asked.set(asked.get() + 1);
                asked.get() <= last
            };
            (distances_to(&surface, &points, &refuse), asked.get())
        };
        let (done, all) = up_to(usize::MAX);
        assert!(done.is_ok() && all >= 6, "asked {all} times");
        for last in 0..all {
            assert_eq!(up_to(last), (Err(CompareError::Cancelled), last + 1));
        }
    }

    #[test]
    fn no_faces_is_a_sentence() {
        assert_eq!(distances_to(&TriangleMesh::default(), &[], &|_| true), Err(CompareError::SecondEmpty));
    }
}
