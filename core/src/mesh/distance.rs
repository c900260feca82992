//! How far two surfaces lie apart.
//!
//! Both directions are measured, since the distance from A to B says nothing of parts that only B has
//! (Cignoni, Rocchini, Scopigno 1998, *Metro*): each surface is sampled evenly by area, and the exact
//! closest point of the other is found for every sample; for the maximum, every vertex that a face uses
//! is measured as well, and faces with points that are far are searched (see [`peaks`]).
//!
//! Guarantees: distances to the other surface are exact to rounding; the result is the same to the last
//! bit for any number of threads (fixed chunks, reduced in order) and on every platform (`+ − × ÷ sqrt`).
//! Non-guarantees: mean and rms carry sampling noise, and the maximum may miss a peak inside a face
//! of which no sample and no vertex is far.

mod peaks;

use std::borrow::Cow;
use std::cell::Cell;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;

use self::peaks::{Found, MOST_QUERIES, PROMISING, peak_of_face, promising_faces};
use super::bounding_volumes::BoundingVolumes;
use super::sampling::AreaSampler;
use super::triangle_mesh::TriangleMesh;

/// Points measured one after another by one thread; each query starts from the answer before it.
const CHUNK: usize = 1024;
/// Faces searched one after another by one thread.
const FACES: usize = 8;
/// Chunks handed out between two calls of the progress function: some hundredths of a second of work.
const CHUNKS_PER_STEP: usize = 16;

/// Distances up to this fraction of the largest coordinate are rounding and count as 0, so that a surface
/// compared with itself is at distance 0. Without it seven scans and models of 6 k to 100 k faces are at up
/// to 8e-16 of their diagonal from themselves. We choose to accept that differences this small go unseen;
/// a step of the integer document is some 2^24 times larger.
const ROUNDING: f64 = 1.0 / (1u64 << 48) as f64;

/// The least and greatest bounding-box diagonals whose fourth powers are safe in `f64`.
const DIAGONALS: Range<f64> = 1e-60..1e60;

/// How [`compare`] measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CompareOptions {
    /// Samples on each surface; 0 counts as 1. Default 200,000.
    pub samples: usize,
    /// The seed of the samples' places. Default 1.
    pub seed: u64,
}

impl Default for CompareOptions {
    fn default() -> Self {
        Self { samples: 200_000, seed: 1 }
    }
}

/// Distances from one surface to another, as fractions of the first mesh's bounding-box diagonal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct OneWay {
    /// The mean over the samples.
    pub mean: f64,
    /// The root of the mean square over the samples.
    pub rms: f64,
    /// The greatest over the samples, the vertices that faces use, and the faces that were searched.
    pub max: f64,
}

/// What [`compare`] found. Serialised, it holds the keys that reports have.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// From the first mesh to the second.
    pub a_to_b: OneWay,
    /// From the second mesh to the first.
    pub b_to_a: OneWay,
    /// The larger of the two root mean squares, as a fraction of the diagonal.
    pub rms: f64,
    /// The larger of the two maxima, as a fraction of the diagonal.
    pub max: f64,
    /// `-20 log10(rms)` in decibels; `None`, in JSON `null`, stands for infinity, when `rms` is 0.
    pub psnr: Option<f64>,
    /// The diagonal of the box around the vertices that the first mesh's faces use, in model units.
    pub diagonal: f64,
}

/// Why two meshes were not compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// The first mesh has no faces.
    #[error("the first mesh has no faces, so there is no surface to measure; give a mesh with faces")]
    FirstEmpty,
    /// The second mesh has no faces.
    #[error("the second mesh has no faces, so there is no surface to measure; give a mesh with faces")]
    SecondEmpty,
    /// The first mesh's bounding box has a diagonal of 0 or beyond all measure.
    #[error(
        "the first mesh's bounding-box diagonal is 0 or out of range, and distances are divided by it; \
         give a mesh with an extent between 1e-60 and 1e60"
    )]
    NoExtent,
    /// The progress function asked to stop.
    #[error("the comparison was cancelled before it was done; run it again for a result")]
    Cancelled,
}

/// Measures the distance between two surfaces both ways.
///
/// `progress` is called from the calling thread, with a fraction from 0 to 1, some dozens of times a second;
/// when it returns `false` the comparison ends with [`CompareError::Cancelled`].
/// Cost: O((samples + vertices) log faces + faces), spread over rayon's current pool.
///
/// Panics if a face refers to a vertex that does not exist.
pub fn compare(
    a: &TriangleMesh,
    b: &TriangleMesh,
    options: &CompareOptions,
    progress: &dyn Fn(f32) -> bool,
) -> Result<Comparison, CompareError> {
    compare_with(a, None, b, options, progress)
}

/// [`compare`] with the first mesh's tree, where there is one.
pub(crate) fn compare_with(
    a: &TriangleMesh,
    tree_a: Option<&BoundingVolumes>,
    b: &TriangleMesh,
    options: &CompareOptions,
    progress: &dyn Fn(f32) -> bool,
) -> Result<Comparison, CompareError> {
    let bounds = a.bounds().ok_or(CompareError::FirstEmpty)?;
    let other_bounds = b.bounds().ok_or(CompareError::SecondEmpty)?;
    let diagonal = bounds.diagonal();
    if !DIAGONALS.contains(&diagonal) {
        return Err(CompareError::NoExtent);
    }
    let coordinates = [bounds.min, bounds.max, other_bounds.min, other_bounds.max];
    let largest = coordinates.iter().flatten().fold(0.0f64, |largest, x| largest.max(x.abs()));

    let meter = Meter {
        samples: options.samples.max(1),
        rounding: largest * ROUNDING,
        diagonal,
        total: (2 * options.samples.max(1) + used_vertices(a).len() + used_vertices(b).len()) as f32,
        done: Cell::new(0),
        progress,
    };
    meter.advance(0)?;
    // One after the other, so that every question is asked on this thread and their number is always the same.
    let build =
        |mesh| BoundingVolumes::build_while(mesh, &mut || progress(0.0)).map_err(|_| CompareError::Cancelled);
    let tree_a = match tree_a {
        Some(tree) => Cow::Borrowed(tree),
        None => Cow::Owned(build(a)?.ok_or(CompareError::FirstEmpty)?),
    };
    let tree_b = build(b)?.ok_or(CompareError::SecondEmpty)?;
    let a_to_b = meter.one_way(a, &tree_b, options.seed)?;
    let b_to_a = meter.one_way(b, &tree_a, options.seed.wrapping_add(1))?;

    let rms = a_to_b.rms.max(b_to_a.rms);
    let psnr = (rms > 0.0).then(|| -20.0 * rms.log10());
    Ok(Comparison { a_to_b, b_to_a, rms, max: a_to_b.max.max(b_to_a.max), psnr, diagonal })
}

/// The vertices that faces use, ascending.
fn used_vertices(mesh: &TriangleMesh) -> Vec<u32> {
    let mut used = vec![false; mesh.positions.len()];
    mesh.faces.iter().flatten().for_each(|&vertex| used[vertex as usize] = true);
    (0u32..).zip(used).filter_map(|(vertex, used)| used.then_some(vertex)).collect()
}

/// What the points of a chunk, or of many, add up to; distances in model units.
#[derive(Default)]
struct Tally {
    sum: f64,
    sum_of_squares: f64,
    max: f64,
    /// The points that are far; of one chunk some more.
    far: Vec<Found>,
}

impl Tally {
    fn add(&mut self, other: Self) {
        self.sum += other.sum;
        self.sum_of_squares += other.sum_of_squares;
        let least = PROMISING * self.max.max(other.max);
        if other.max > self.max {
            self.max = other.max;
            self.far.retain(|found| found.distance >= least);
        }
        self.far.extend(other.far.into_iter().filter(|found| found.distance >= least));
    }
}

/// Measures points one after another, each from the answer before it; with each its face's or its own index.
fn tally(target: &BoundingVolumes, rounding: f64, points: impl Iterator<Item = (DVec3, u32)>) -> Tally {
    let mut cursor = target.cursor();
    let mut tally = Tally::default();
    for (point, index) in points {
        let squared = cursor.closest(point.to_array()).squared_distance;
        let distance = squared.sqrt();
        if distance > rounding {
            tally.sum += distance;
            tally.sum_of_squares += squared;
            tally.max = tally.max.max(distance);
            if distance >= PROMISING * tally.max {
                tally.far.push(Found { distance, index });
            }
        }
    }
    tally
}

/// The settings and the progress of one comparison.
struct Meter<'p> {
    samples: usize,
    /// Distances up to this are rounding, in model units.
    rounding: f64,
    diagonal: f64,
    /// Points to measure in all.
    total: f32,
    /// Points measured so far.
    done: Cell<usize>,
    progress: &'p dyn Fn(f32) -> bool,
}

impl Meter<'_> {
    fn one_way(
        &self,
        source: &TriangleMesh,
        target: &BoundingVolumes,
        seed: u64,
    ) -> Result<OneWay, CompareError> {
        let rounding = self.rounding;
        let sampler = AreaSampler::new(source, self.samples as u64, seed);
        let at_samples = self.in_chunks(self.samples, |numbers| {
            let points = sampler.points_and_faces(numbers.start as u64..numbers.end as u64);
            tally(target, rounding, points.map(|(point, face)| (point, face.0)))
        })?;
        let used = used_vertices(source);
        let at_vertices = self.in_chunks(used.len(), |numbers| {
            let vertices = used[numbers].iter();
            let at = |&vertex: &u32| (DVec3::from(source.positions[vertex as usize]), vertex);
            tally(target, rounding, vertices.map(at))
        })?;
        let sampled = at_samples.max.max(at_vertices.max);
        let most = self.samples.div_ceil(MOST_QUERIES);
        let faces = promising_faces(source, &at_samples.far, &at_vertices.far, sampled, most);
        let in_faces = self.in_chunks_of(FACES, faces.len(), 0, |numbers| {
            let peaks = faces[numbers].iter().map(|&face| peak_of_face(source, face, target, sampled));
            Tally { max: peaks.fold(0.0, f64::max), ..Tally::default() }
        })?;
        let count = self.samples as f64;
        Ok(OneWay {
            mean: at_samples.sum / count / self.diagonal,
            rms: (at_samples.sum_of_squares / count).sqrt() / self.diagonal,
            max: sampled.max(in_faces.max) / self.diagonal,
        })
    }

    /// Measures `count` points in fixed chunks and adds the chunks up in order.
    fn in_chunks(
        &self,
        count: usize,
        chunk: impl Fn(Range<usize>) -> Tally + Sync,
    ) -> Result<Tally, CompareError> {
        self.in_chunks_of(CHUNK, count, 1, chunk)
    }

    /// The same in chunks of a given size; each counts as so much progress.
    fn in_chunks_of(
        &self,
        size: usize,
        count: usize,
        progress: usize,
        chunk: impl Fn(Range<usize>) -> Tally + Sync,
    ) -> Result<Tally, CompareError> {
        let mut total = Tally::default();
        let chunks = count.div_ceil(size);
        for first in (0..chunks).step_by(CHUNKS_PER_STEP) {
            let step = first..(first + CHUNKS_PER_STEP).min(chunks);
            let range = |index: usize| index * size..((index + 1) * size).min(count);
            let points = range(step.end - 1).end - range(step.start).start;
            let tallies: Vec<Tally> = step.into_par_iter().map(|index| chunk(range(index))).collect();
            tallies.into_iter().for_each(|tally| total.add(tally));
            self.advance(points * progress)?;
        }
        Ok(total)
    }

    /// Reports `points` more points as measured.
    fn advance(&self, points: usize) -> Result<(), CompareError> {
        let done = self.done.get() + points;
        self.done.set(done);
        if (self.progress)(done as f32 / self.total) { Ok(()) } else { Err(CompareError::Cancelled) }
    }
}

#[cfg(test)]
mod tests;
