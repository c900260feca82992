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
/// measuring a part some fifteen times.
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
                (psnr(mesh, &smaller.surface), file, smaller)
            };
            // Doubling, then halving: a prefix costs what it is long.
            let (mut low, mut high, mut step) = (0, least, least);
            let mut result = found(high);
            while result.0 < wanted {
                if high == stream.bytes.len() {
                    return Err(NoSuchFile::NotThatNear { best: result.0 });
                }
                low = high;
                high = stream.bytes.len().min(high + step);
                step *= 2;
                result = found(high);
            }
            while high - low > 1 + high / 500 && high > least {
                let middle = low.midpoint(high);
                let nearer = found(middle);
                if nearer.0 >= wanted {
                    (result, high) = (nearer, middle);
                } else {
                    low = middle;
                }
            }
            Ok((result.1, result.2))
        }
    }
}

/// The file that holds the first bytes of a stream, and the surface that these hold.
fn cut_to(model: &Model, stream: &Encoded, length: usize) -> (Vec<u8>, Model) {
    let surface = &model.surface;
    let bytes = stream.bytes[..length].to_vec();
    let hierarchy = surface.hierarchy().as_ref().clone();
    let filters = Filters::new(&hierarchy, surface.form().wavelet).expect("they were solved before");
    let others = stream.coding.filters(&hierarchy, surface.form().wavelet).expect("they were solved before");
    let decoded = decode_stream(&hierarchy, others.as_ref().unwrap_or(&filters), stream.coding, &bytes)
        .expect("the base positions are there");
    let held = surface_of(hierarchy, filters, surface.form().clone(), decoded).expect("a surface holds it");
    let mut borders: Vec<Border> = stream.borders.iter().copied().filter(|b| b.position < length).collect();
    borders.push(Border { position: length, error: stream.error_at(length) });
    let mut smaller = Model::new(held, None, Metadata::default());
    smaller.unknown.clone_from(&model.unknown);
    let parts = if length == stream.bytes.len() { Parts::Many } else { Parts::Few };
    (encode_parts(&smaller, &Encoded { coding: stream.coding, bytes, borders }, parts), smaller)
}

fn psnr(mesh: &TriangleMesh, surface: &Surface) -> f64 {
    let options = CompareOptions::default();
    match compare(mesh, &surface.to_mesh(surface.finest()), &options, &|_| true) {
        Ok(found) => found.psnr.unwrap_or(f64::INFINITY),
        // A surface without extent has no distance worth a name.
        Err(_) => 0.0,
    }
}
