//! The `.boz` wavelet file (docs/FORMAT.md): writing, reading whole or cut, checking.
//!
//! Order: preamble, `HEAD`, `BASE`, the embedded stream in `WAVE` chunks, `END!`, then ancillary chunks. Nothing before
//! the end marker depends on anything after it, so every prefix that holds the base mesh and its positions is a valid
//! model, as good as its bytes allow. After the marker the surface is whole, and a cut there costs only what stands
//! beside it. A reader refuses sizes it cannot hold before it allocates them. Ancillary chunks may stand anywhere after
//! `HEAD`; rewriting moves those it does not know to the end.

use super::FileError;
use super::chunk::{self, Chunk, Kind, Stop};
use super::header::{self, Header};
use super::held::surface_of;
use super::progressive::{Encoded, Granularity};
use super::progressive::{decode_base, decode_stream, encode_base, encode_stream};
use super::source_indices::{SOURCE, SourceIndices};
use crate::hierarchy::{BaseMesh, Hierarchy, Level, MOST_VERTICES};
use crate::surface::{Surface, SurfaceHash};
use crate::wavelet::Filters;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;

const HEAD: Kind = *b"HEAD";
const BASE: Kind = *b"BASE";
const WAVELETS: Kind = *b"WAVE";
const END: Kind = *b"END!";
const META: Kind = *b"META";
const KNOWN: [Kind; 4] = [HEAD, BASE, WAVELETS, END];

/// The first `WAVE` chunks have as many bytes of the stream or more; later ones grow with what is before them.
const LEAST: usize = 256;
/// No `WAVE` chunk has more.
const MOST: usize = 1 << 16;
/// Surfaces with more finest vertices are written for speed of reading, their large levels in few steps.
const FINE_UP_TO: usize = 1 << 17;

/// What a wavelet file says beside the surface. Not part of the surface's hash.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Metadata {
    /// The name of the file the surface was imported from.
    pub source: Option<String>,
    /// SHA-256 of that file.
    pub source_sha256: Option<String>,
}

/// A wavelet file's content.
#[derive(Debug, Clone)]
pub struct Model {
    /// The surface; of a partial file with zeros for what is missing.
    pub surface: Surface,
    /// For each public id the index of the vertex in the imported file, where that had subdivision connectivity.
    pub source: Option<Arc<SourceIndices>>,
    /// Where the surface came from.
    pub metadata: Metadata,
    /// Whether everything up to the end marker was there.
    pub complete: bool,
    /// How far the surface was from the whole at certain lengths of the file, coarse to fine; empty for a model that
    /// does not come from a file.
    pub curve: Vec<CurvePoint>,
    /// Whether the file ends inside a chunk after the end marker: the surface is whole, something beside it is lost.
    pub tail_cut: bool,
    /// The hash that the header states for the complete surface.
    pub stated_hash: SurfaceHash,
    /// Ancillary chunks this version does not know; they survive a rewrite.
    pub unknown: Vec<Chunk>,
}

/// A length of a wavelet file, and how far the surface that so many bytes hold is from the whole.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct CurvePoint {
    /// The first bytes of the file.
    pub bytes: usize,
    /// The root of the mean squared distance in model units, as the writer measured it; 0 where nothing is missing.
    pub error: f64,
}

impl Model {
    /// A model fresh from an import.
    pub fn new(surface: Surface, source: Option<SourceIndices>, metadata: Metadata) -> Self {
        let stated_hash = surface.hash();
        Self {
            surface,
            source: source.map(Arc::new),
            metadata,
            complete: true,
            curve: Vec::new(),
            tail_cut: false,
            stated_hash,
            unknown: Vec::new(),
        }
    }
}

/// Whether a path names a wavelet file.
pub fn is_wavelet_file(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("boz"))
}

/// Writes a wavelet file, every bit of the surface. Deterministic: equal models give equal bytes, at any number of
/// threads.
pub fn encode(model: &Model) -> Vec<u8> {
    in_pool(|| encode_parts(model, &stream_of(&model.surface), Parts::Many))
}

/// Into how many `WAVE` chunks a stream is cut. Each takes some 14 bytes; a part of one is of no use to a reader.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Parts {
    /// A chunk has at least a quarter and at most half of what is before it.
    Many,
    /// As much as is before it: for files that are small by choice.
    Few,
}

impl Parts {
    /// How many bytes of the stream a `WAVE` chunk has at least after so many, if there is a border.
    fn least(self, from: usize) -> usize {
        LEAST.max(if self == Parts::Many { from / 4 } else { 3 * from / 4 })
    }

    /// How many it has at most.
    fn most(self, from: usize) -> usize {
        LEAST.max(if self == Parts::Many { from / 2 } else { from + LEAST }).min(MOST)
    }
}

/// The file of a model whose surface a stream holds.
pub(super) fn encode_parts(model: &Model, stream: &Encoded, parts: Parts) -> Vec<u8> {
    let surface = &model.surface;
    let base = surface.hierarchy().base();
    let mut chunks = vec![
        Chunk::stored(HEAD, true, header::encode(surface, stream.telling)),
        Chunk::stored(BASE, true, encode_base(base.vertex_count(), base.faces(), &base.sharp_edges())),
    ];
    chunks.extend(wave_chunks(stream, parts));
    chunks.push(Chunk::stored(END, true, Vec::new()));
    if let Some(source) = &model.source {
        chunks.push(source.to_chunk());
    }
    if model.metadata != Metadata::default() {
        let metadata = serde_json::to_vec(&model.metadata).expect("metadata is plain data");
        chunks.push(Chunk::new(META, false, &metadata));
    }
    chunks.extend(model.unknown.iter().cloned());

    let mut file = chunk::preamble(chunk::VERSION).to_vec();
    chunks.iter().for_each(|chunk| chunk.write(&mut file));
    file
}

fn stream_of(surface: &Surface) -> Encoded {
    let vertices = surface.scaling(surface.finest()).len();
    encode_stream(surface, if vertices > FINE_UP_TO { Granularity::Coarse } else { Granularity::Fine })
}

/// The stream that is the best to cut.
pub(super) fn finest_stream(surface: &Surface) -> Encoded {
    encode_stream(surface, Granularity::Fine)
}

/// The stream in chunks, each with the error that it leaves: cut at borders where they are not too far apart.
fn wave_chunks(stream: &Encoded, parts: Parts) -> Vec<Chunk> {
    let mut chunks = Vec::new();
    let mut from = 0;
    for (at, &border) in stream.borders.iter().enumerate() {
        let last = at + 1 == stream.borders.len();
        // Of a long block a part is worth having too.
        while border.position - from > parts.most(from) {
            let to = from + parts.most(from);
            chunks.push(wave_chunk(&stream.bytes[from..to], stream.error_at(to)));
            from = to;
        }
        if last || border.position - from >= parts.least(from) {
            let to = if last { stream.bytes.len() } else { border.position };
            chunks.push(wave_chunk(&stream.bytes[from..to], border.error));
            from = to;
        }
    }
    chunks
}

/// The error, as the upper half of an `f32` in steps, and a part of the stream.
fn wave_chunk(bytes: &[u8], error: f64) -> Chunk {
    let upper = ((error as f32).to_bits() >> 16) as u16;
    Chunk::stored(WAVELETS, true, [&upper.to_le_bytes(), bytes].concat())
}

/// Reads a wavelet file from memory; `path` is for messages. Linear in the finest level. A file cut after its base
/// mesh gives a partial model.
///
/// # Errors
/// Damage, a file cut before its base mesh ends, features of a newer version, or a surface too large to hold.
pub fn decode(bytes: &[u8], path: &Path) -> Result<Model, FileError> {
    in_pool(|| Reader { bytes, path, at: 0, unknown: Vec::new() }.model())
}

/// Works on a thread of the pool: each of the many small parallel steps would else be handed over to one, and waited for.
fn in_pool<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    rayon::scope(|_| work())
}

struct Reader<'a> {
    bytes: &'a [u8],
    path: &'a Path,
    at: usize,
    /// Ancillary chunks passed on the way.
    unknown: Vec<Chunk>,
}

const RESTORE: &str = "restore the file from a copy";

impl Reader<'_> {
    fn error(&self, at: usize, what: impl Into<String>, mend: &'static str) -> FileError {
        FileError::Content {
            path: self.path.to_owned(),
            place: format!("byte {at}"),
            what: what.into(),
            mend,
        }
    }

    fn model(mut self) -> Result<Model, FileError> {
        let version = self.preamble()?;
        let (head_at, head) = self.required(HEAD)?;
        let head = head.into_stored().map_err(|what| self.error(head_at, what, RESTORE))?;
        let head = Header::decode(&head, version)
            .map_err(|what| self.error(head_at, what, "open it with the Bozzetto that wrote it"))?;
        let (hierarchy, base_at) = self.hierarchy(&head)?;
        let filters = Filters::new(&hierarchy, head.form.wavelet)
            .map_err(|e| self.error(base_at, e.to_string(), "import the model again"))?;
        let (stream, complete, curve) = self.stream(head.form.placement.step)?;
        let others = head
            .telling
            .coding
            .filters(&hierarchy, head.form.wavelet)
            .map_err(|e| self.error(head_at, e.to_string(), RESTORE))?;
        let weights = others.as_ref().unwrap_or(&filters);
        let Some(decoded) = decode_stream(&hierarchy, weights, head.telling, &stream) else {
            return Err(self.error(
                self.at,
                "the file ends before its base mesh does",
                "get the rest of the file",
            ));
        };
        if decoded.surplus {
            return Err(self.error(self.at, "the coefficients go on after their end", RESTORE));
        }
        let beyond =
            || self.error(PREAMBLE_END, "coefficients reach beyond the range of coordinates", RESTORE);
        let surface = surface_of(hierarchy, filters, head.form, decoded).ok_or_else(beyond)?;
        // Positions of a partial surface may overshoot where the missing detail would have held them back.
        if complete && !surface.is_within_limit() {
            return Err(beyond());
        }
        if complete && surface.hash() != head.hash {
            return Err(self.error(
                head_at,
                "the surface does not have the hash that its header states",
                RESTORE,
            ));
        }
        let mut model = Model {
            surface,
            source: None,
            metadata: Metadata::default(),
            complete,
            curve,
            tail_cut: false,
            stated_hash: head.hash,
            unknown: Vec::new(),
        };
        if complete {
            self.ancillary(&mut model)?;
        }
        model.unknown = self.unknown;
        Ok(model)
    }

    /// The version.
    fn preamble(&mut self) -> Result<u16, FileError> {
        let start = self.bytes.get(..chunk::PREAMBLE);
        if start.is_none_or(|start| start[..8] != chunk::MAGIC) {
            let mend = "give a .boz file, or import a mesh with `bozzetto import`";
            return Err(self.error(0, "this is not a Bozzetto wavelet file", mend));
        }
        let mut versions = chunk::OLDEST..=chunk::VERSION;
        let found = versions.find(|&version| start == Some(chunk::preamble(version).as_slice()));
        let mend = "open it with a newer Bozzetto";
        let version = found.ok_or_else(|| self.error(8, "the version is not known or damaged", mend))?;
        self.at = chunk::PREAMBLE;
        Ok(version)
    }

    /// The next chunk and where it began.
    fn next(&mut self) -> Result<Option<(usize, Chunk)>, FileError> {
        let at = self.at;
        match Chunk::read(&self.bytes[at..]) {
            Ok((chunk, length)) => {
                self.at += length;
                Ok(Some((at, chunk)))
            }
            Err(Stop::Cut) => Ok(None),
            Err(Stop::Damaged(what)) => Err(self.error(at, what, RESTORE)),
        }
    }

    /// The next critical chunk and where it began; ancillary ones before it are set aside.
    fn next_critical(&mut self) -> Result<Option<(usize, Chunk)>, FileError> {
        while let Some((at, chunk)) = self.next()? {
            if chunk.critical {
                return Ok(Some((at, chunk)));
            }
            if [SOURCE, META].contains(&chunk.kind) {
                let what = format!("a {} chunk stands before the end marker", letters(chunk.kind));
                return Err(self.error(at, what, RESTORE));
            }
            self.unknown.push(chunk);
        }
        Ok(None)
    }

    /// A chunk without which there is no model.
    fn required(&mut self, kind: Kind) -> Result<(usize, Chunk), FileError> {
        let mend = "get the rest of the file";
        match self.next_critical()? {
            None => Err(self.error(self.bytes.len(), "the file ends before its base mesh does", mend)),
            Some((at, chunk)) if !KNOWN.contains(&chunk.kind) => Err(self.not_known(at, chunk.kind)),
            Some((at, chunk)) if chunk.kind != kind => {
                let what = format!("a {} chunk stands where {} belongs", letters(chunk.kind), letters(kind));
                Err(self.error(at, what, RESTORE))
            }
            Some(found) => Ok(found),
        }
    }

    fn unpack(&self, at: usize, chunk: &Chunk, limit: u64) -> Result<Vec<u8>, FileError> {
        chunk.unpack(limit).map_err(|what| self.error(at, what, RESTORE))
    }

    fn hierarchy(&mut self, head: &Header) -> Result<(Hierarchy, usize), FileError> {
        let (at, chunk) = self.required(BASE)?;
        let bytes = chunk.into_stored().map_err(|what| self.error(at, what, RESTORE))?;
        let (faces, sharp) = decode_base(&bytes, head.vertices, head.faces as usize)
            .map_err(|what| self.error(at, what, RESTORE))?;
        if head.vertices as usize > 3 * faces.len() {
            return Err(self.error(at, "the base mesh has more vertices than corners", RESTORE));
        }
        let base = BaseMesh::new(head.vertices, faces, &sharp)
            .map_err(|e| self.error(at, format!("the base mesh is not one: {e}"), RESTORE))?;
        let hierarchy = Hierarchy::new(Arc::new(base), Level(head.levels))
            .filter(|h| h.layout(h.finest()).len() <= MOST_VERTICES)
            .ok_or_else(|| {
                self.error(at, "the surface has more than 67 million vertices", "export a coarser level")
            })?;
        Ok((hierarchy, at))
    }

    /// Gathers the stream up to the end marker; whether that was there; and the errors stated on the way.
    fn stream(&mut self, step: f64) -> Result<(Vec<u8>, bool, Vec<CurvePoint>), FileError> {
        let (mut stream, mut curve) = (Vec::new(), Vec::new());
        while let Some((at, chunk)) = self.next_critical()? {
            if chunk.kind != WAVELETS && chunk.kind != END {
                return Err(self.not_known(at, chunk.kind));
            }
            let is_end = chunk.kind == END;
            let payload = chunk.into_stored().map_err(|what| self.error(at, what, RESTORE))?;
            if is_end {
                if !payload.is_empty() {
                    return Err(self.error(at, "the end marker is not empty", RESTORE));
                }
                return Ok((stream, true, curve));
            }
            let Some((upper, bytes)) = payload.split_first_chunk() else {
                return Err(self.error(at, "a part of the coefficients is too short", RESTORE));
            };
            let error = f64::from(f32::from_bits(u32::from(u16::from_le_bytes(*upper)) << 16)) * step;
            if !(0.0..f64::INFINITY).contains(&error) {
                return Err(self.error(at, "a stated error is no distance", RESTORE));
            }
            stream.extend(bytes);
            curve.push(CurvePoint { bytes: self.at, error });
        }
        Ok((stream, false, curve))
    }

    fn ancillary(&mut self, model: &mut Model) -> Result<(), FileError> {
        let count = model.surface.hierarchy().layout(model.surface.finest()).len();
        while let Some((at, chunk)) = self.next()? {
            match chunk.kind {
                SOURCE => {
                    let source = SourceIndices::read(chunk, count);
                    let source = source.map_err(|what| self.error(at, what, RESTORE))?;
                    model.source = Some(Arc::new(source));
                }
                META => {
                    let raw = self.unpack(at, &chunk, 1 << 20)?;
                    model.metadata = serde_json::from_slice(&raw).map_err(|e| {
                        self.error(at, format!("the metadata is not readable ({e})"), RESTORE)
                    })?;
                }
                kind if chunk.critical => return Err(self.not_known(at, kind)),
                _ => self.unknown.push(chunk),
            }
        }
        model.tail_cut = self.at != self.bytes.len();
        Ok(())
    }

    fn not_known(&self, at: usize, kind: Kind) -> FileError {
        let what = format!("the critical chunk {} is not known here", letters(kind));
        self.error(at, what, "open it with a newer Bozzetto")
    }
}

const PREAMBLE_END: usize = chunk::PREAMBLE;

fn letters(kind: Kind) -> String {
    kind.iter().map(|&b| if b.is_ascii_graphic() { char::from(b) } else { '?' }).collect()
}
