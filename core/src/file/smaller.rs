//! Small files: as much of a surface as so many bytes hold, or as little as a distance allows.
//!
//! The embedded stream is cut; what a reader makes of the rest is a surface of its own, and the file is complete: it
//! states that surface's hash and has an end marker. Source indices and metadata are left out: they tell of the mesh that
//! the whole surface was made from, and at a kilobyte they cost more than detail does.

use super::held::surface_of;
use super::progressive::{Border, Encoded, decode_stream};
use super::wavelet_file::{Metadata, Model, Parts, encode_parts, finest_stream};
use crate::mesh::{CompareOptions, TriangleMesh, compare};
use crate::surface::Surface;
use crate::wavelet::Filters;
use std::ops::RangeInclusive;
use thiserror::Error;

/// How small a file is to be.
#[derive(Debug, Clone, Copy)]
pub enum Size<'a> {
    /// At most so many bytes.
    Bytes(usize),
    /// As few bytes as bring the surface so near to a mesh, in decibels: `−20 log10` of the larger root mean square
    /// distance over the mesh's diagonal.
    Psnr(f64, &'a TriangleMesh),
}

/// Why there is no such file.
#[derive(Debug, Error, Clone, Copy, PartialEq)]
pub enum NoSuchFile {
    /// The base mesh alone needs more.
    #[error("the base mesh alone takes {least} bytes; ask for that many or more")]
    TooSmall {
        /// What the least file takes.
        least: usize,
    },
    /// Even the whole surface is not as near.
    #[error("the whole surface is at {best:.2} dB; ask for less, or import with more levels or base faces")]
    NotThatNear {
        /// How near it is.
        best: f64,
    },
}

/// A wavelet file of at most that size, and the surface in it. Cost: writing the whole, and reading and, for a distance,
/// measuring a part some six times.
///
/// # Errors
/// No file can be that small, or none that near.
pub fn encode_smaller(model: &Model, size: Size) -> Result<(Vec<u8>, Model), NoSuchFile> {
    let stream = finest_stream(&model.surface);
    let least = stream.borders[0].position;
    match size {
        Size::Bytes(bytes) => {
            let mut cut = stream.bytes.len().min(bytes.max(least));
            loop {
                let (file, smaller) = cut_to(model, &stream, cut);
                if file.len() <= bytes {
                    return Ok((file, smaller));
                }
                if cut == least {
                    return Err(NoSuchFile::TooSmall { least: file.len() });
                }
                cut = cut.saturating_sub(file.len() - bytes).max(least);
            }
        }
        Size::Psnr(wanted, mesh) => {
            let found = |cut: usize| {
                let (file, smaller) = cut_to(model, &stream, cut);
                (psnr(mesh, &smaller.surface), (file, smaller))
            };
            let error = 10f64.powf(-wanted / 20.0) * mesh.diagonal() / model.surface.form().placement.step;
            let cuts = least..=stream.bytes.len();
            shortest(cuts, first_within(&stream, error), wanted, found)
                .map_err(|best| NoSuchFile::NotThatNear { best })
        }
    }
}

/// About how many bytes of a stream bring the error that it tells of down to so many steps.
fn first_within(stream: &Encoded, error: f64) -> usize {
    let (mut low, mut high) = (stream.borders[0].position, stream.bytes.len());
    while low < high {
        let middle = low.midpoint(high);
        match stream.error_at(middle) > error {
            true => low = middle + 1,
            false => high = middle,
        }
    }
    low
}

/// What is found at the shortest cut, to a five-hundredth, that is as near as wanted, or how near the longest is. Growing
/// steps from a guess bracket it; the line through the bracket's ends tells where to look next, or, where one end has
/// stayed, the middle.
fn shortest<T>(
    cuts: RangeInclusive<usize>,
    guess: usize,
    wanted: f64,
    found: impl Fn(usize) -> (f64, T),
) -> Result<T, f64> {
    let mut below: Option<(usize, f64)> = None;
    let mut above: Option<(usize, f64, T)> = None;
    let (mut at, mut step) = (guess, 1 + guess / 16);
    let (mut was_near, mut stays) = (None, 0);
    loop {
        let (near, what) = found(at);
        stays = if was_near == Some(near >= wanted) { stays + 1 } else { 0 };
        was_near = Some(near >= wanted);
        if near >= wanted {
            above = Some((at, near, what));
        } else {
            below = Some((at, near));
        }
        at = match (&below, &above) {
            (Some((low, near)), None) if low == cuts.end() => return Err(*near),
            (Some((low, _)), None) => (low + step).min(*cuts.end()),
            (None, Some((high, ..))) if high > cuts.start() => high.saturating_sub(step).max(*cuts.start()),
            (Some((low, low_near)), Some((high, high_near, _))) if high - low > 1 + high / 500 => {
                let share = if stays < 2 { (wanted - low_near) / (high_near - low_near) } else { 0.5 };
                let middle = low + ((high - low) as f64 * share) as usize;
                middle.clamp(low + 1, high - 1)
            }
            _ => break,
        };
        step *= 2;
    }
    above.map(|(_, _, what)| what).ok_or(f64::NEG_INFINITY)
}

/// The file that holds the first bytes of a stream, and the surface that these hold.
fn cut_to(model: &Model, stream: &Encoded, length: usize) -> (Vec<u8>, Model) {
    let surface = &model.surface;
    let bytes = stream.bytes[..length].to_vec();
    let hierarchy = surface.hierarchy().as_ref().clone();
    let filters = Filters::new(&hierarchy, surface.form().wavelet).expect("they were solved before");
    let others =
        stream.telling.coding.filters(&hierarchy, surface.form().wavelet).expect("they were solved before");
    let decoded = decode_stream(&hierarchy, others.as_ref().unwrap_or(&filters), stream.telling, &bytes)
        .expect("the base positions are there");
    let held = surface_of(hierarchy, filters, surface.form().clone(), decoded).expect("a surface holds it");
    let mut borders: Vec<Border> = stream.borders.iter().copied().filter(|b| b.position < length).collect();
    borders.push(Border { position: length, error: stream.error_at(length) });
    let mut smaller = Model::new(held, None, Metadata::default());
    smaller.unknown.clone_from(&model.unknown);
    let parts = if length == stream.bytes.len() { Parts::Many } else { Parts::Few };
    (encode_parts(&smaller, &Encoded { telling: stream.telling, bytes, borders }, parts), smaller)
}

fn psnr(mesh: &TriangleMesh, surface: &Surface) -> f64 {
    let options = CompareOptions::default();
    match compare(mesh, &surface.to_mesh(surface.finest()), &options, &|_| true) {
        Ok(found) => found.psnr.unwrap_or(f64::INFINITY),
        // A surface without extent has no distance worth a name.
        Err(_) => 0.0,
    }
}
