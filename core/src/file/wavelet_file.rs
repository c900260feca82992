//! The `.boz` wavelet file (docs/FORMAT.md): writing, reading whole or cut, checking.
//!
//! Order: preamble, `HEAD`, `BASE`, `SCAL`, `WAVE` blocks coarse to fine, `END!`, then ancillary chunks. Nothing
//! before the end marker depends on anything after it, so every prefix that holds the base mesh is a valid model;
//! coefficients that are missing count as zero. After the marker the surface is whole, and a cut there costs only what
//! stands beside it. A reader refuses sizes it cannot hold before it allocates them. Ancillary chunks may stand
//! anywhere after `HEAD`; rewriting moves those it does not know to the end.

use super::FileError;
use super::blocks::{self, BLOCK};
use super::chunk::{self, Chunk, Kind, Stop};
use super::header::{self, Header};
use crate::hierarchy::{BaseMesh, Hierarchy, Level, PublicId};
use crate::surface::{Surface, SurfaceHash, Vector, within_limit};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;

const HEAD: Kind = *b"HEAD";
const BASE: Kind = *b"BASE";
const SCALING: Kind = *b"SCAL";
const WAVELETS: Kind = *b"WAVE";
const END: Kind = *b"END!";
const SOURCE: Kind = *b"SRCE";
const META: Kind = *b"META";
const KNOWN: [Kind; 5] = [HEAD, BASE, SCALING, WAVELETS, END];

/// The most vertices that are opened: 2^26, about 2 GB in memory.
pub const MOST_VERTICES: u32 = 1 << 26;

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
    pub source: Option<Arc<Vec<u32>>>,
    /// Where the surface came from.
    pub metadata: Metadata,
    /// Whether everything up to the end marker was there.
    pub complete: bool,
    /// Whether the file ends inside a chunk after the end marker: the surface is whole, something beside it is lost.
    pub tail_cut: bool,
    /// The hash that the header states for the complete surface.
    pub stated_hash: SurfaceHash,
    /// Ancillary chunks this version does not know; they survive a rewrite.
    pub unknown: Vec<Chunk>,
}

impl Model {
    /// A model fresh from an import.
    pub fn new(surface: Surface, source: Option<Vec<u32>>, metadata: Metadata) -> Self {
        let stated_hash = surface.hash();
        Self {
            surface,
            source: source.map(Arc::new),
            metadata,
            complete: true,
            tail_cut: false,
            stated_hash,
            unknown: Vec::new(),
        }
    }
}

/// Writes a wavelet file. Deterministic: equal models give equal bytes, at any number of threads.
pub fn encode(model: &Model) -> Vec<u8> {
    let surface = &model.surface;
    let mut chunks = vec![
        Chunk::new(HEAD, true, &header::encode(surface)),
        Chunk::new(BASE, true, &header::encode_base(surface.hierarchy().base())),
    ];
    let mut coarsest = Vec::new();
    blocks::encode(surface.scaling(Level::BASE), &mut coarsest);
    chunks.push(Chunk::new(SCALING, true, &coarsest));
    let starts: Vec<(u8, usize)> = (0..surface.finest().0)
        .flat_map(|j| (0..surface.wavelets(Level(j)).len()).step_by(BLOCK).map(move |first| (j, first)))
        .collect();
    let block = |&(j, first): &(u8, usize)| {
        let details = surface.wavelets(Level(j));
        let details = &details[first..details.len().min(first + BLOCK)];
        let mut raw = vec![j, 0, 0, 0];
        raw.extend((first as u32).to_le_bytes());
        blocks::encode(details, &mut raw);
        Chunk::new(WAVELETS, true, &raw)
    };
    chunks.extend(starts.par_iter().map(block).collect::<Vec<_>>());
    chunks.push(Chunk::new(END, true, &surface.hash().0));
    if let Some(source) = &model.source {
        let raw: Vec<u8> = source.iter().flat_map(|v| v.to_le_bytes()).collect();
        chunks.push(Chunk::new(SOURCE, false, &raw));
    }
    let metadata = serde_json::to_vec(&model.metadata).expect("metadata is plain data");
    chunks.push(Chunk::new(META, false, &metadata));
    chunks.extend(model.unknown.iter().cloned());

    let mut file = chunk::preamble().to_vec();
    chunks.iter().for_each(|chunk| chunk.write(&mut file));
    file
}

/// Reads a wavelet file from memory; `path` is for messages. Linear in the finest level. A file cut after its base
/// mesh gives a partial model.
///
/// # Errors
/// Damage, a file cut before its base mesh ends, features of a newer version, or a surface too large to hold.
pub fn decode(bytes: &[u8], path: &Path) -> Result<Model, FileError> {
    Reader { bytes, path, at: 0, unknown: Vec::new() }.model()
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
        self.preamble()?;
        let (head_at, head) = self.required(HEAD)?;
        let head = Header::decode(&self.unpack(head_at, &head, 1 << 16)?)
            .map_err(|what| self.error(head_at, what, "open it with the Bozzetto that wrote it"))?;
        let (hierarchy, base_at) = self.hierarchy(&head)?;
        let (at, scaling) = self.required(SCALING)?;
        let coarsest = blocks::decode(&self.unpack(at, &scaling, 12 * u64::from(head.vertices))?)
            .filter(|values| values.len() == head.vertices as usize)
            .ok_or_else(|| self.error(at, "the base positions do not match the base mesh", RESTORE))?;

        let mut wavelets: Vec<Vec<Vector>> =
            (0..head.levels).map(|j| vec![[0; 3]; hierarchy.layout(Level(j)).odd_len() as usize]).collect();
        let complete = self.blocks(&mut wavelets, head.hash)?;
        let beyond =
            || self.error(PREAMBLE_END, "coefficients reach beyond the range of coordinates", RESTORE);
        // Before synthesis, whose sums are exact within the limit only.
        if !coarsest.iter().chain(wavelets.iter().flatten()).flatten().all(|&x| within_limit(x)) {
            return Err(beyond());
        }
        let surface = Surface::from_coefficients(hierarchy, head.form, coarsest, wavelets)
            .map_err(|e| self.error(base_at, e.to_string(), "import the model again"))?;
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

    fn preamble(&mut self) -> Result<(), FileError> {
        let start = self.bytes.get(..chunk::PREAMBLE);
        if start.is_none_or(|start| start[..8] != chunk::MAGIC) {
            let mend = "give a .boz file, or import a mesh with `bozzetto import`";
            return Err(self.error(0, "this is not a Bozzetto wavelet file", mend));
        }
        if start != Some(chunk::preamble().as_slice()) {
            return Err(self.error(
                8,
                "the version is not known or damaged",
                "open it with a newer Bozzetto",
            ));
        }
        self.at = chunk::PREAMBLE;
        Ok(())
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
        let limit = 12 * u64::from(head.faces) + 8 + 24 * u64::from(head.faces);
        let (faces, sharp) = header::decode_base(&self.unpack(at, &chunk, limit)?, head)
            .map_err(|what| self.error(at, what, RESTORE))?;
        let base = BaseMesh::new(head.vertices, faces.clone(), &sharp)
            .map_err(|e| self.error(at, format!("the base mesh is not one: {e}"), RESTORE))?;
        if base.faces() != faces {
            return Err(self.error(at, "the base faces are not in their order", RESTORE));
        }
        let hierarchy = Hierarchy::new(Arc::new(base), Level(head.levels))
            .filter(|h| h.layout(h.finest()).len() <= MOST_VERTICES)
            .ok_or_else(|| {
                self.error(at, "the surface has more than 67 million vertices", "export a coarser level")
            })?;
        Ok((hierarchy, at))
    }

    /// Reads blocks up to the end marker; whether it was there.
    fn blocks(&mut self, wavelets: &mut [Vec<Vector>], hash: SurfaceHash) -> Result<bool, FileError> {
        let mut due = (0usize, 0usize);
        while let Some((at, chunk)) = self.next_critical()? {
            while due.0 < wavelets.len() && due.1 == wavelets[due.0].len() {
                due = (due.0 + 1, 0);
            }
            if chunk.kind == END {
                if due.0 < wavelets.len() {
                    return Err(self.error(at, "coefficients are missing before the end marker", RESTORE));
                }
                if self.unpack(at, &chunk, 16)? != hash.0 {
                    return Err(self.error(at, "the end marker belongs to another surface", RESTORE));
                }
                return Ok(true);
            }
            if chunk.kind != WAVELETS {
                return Err(self.not_known(at, chunk.kind));
            }
            let raw = self.unpack(at, &chunk, 8 + 12 * BLOCK as u64)?;
            let wrong = || self.error(at, "a block of coefficients is not the one that is due", RESTORE);
            let (place, values) = raw.split_at_checked(8).ok_or_else(wrong)?;
            let first = u32::from_le_bytes(place[4..8].try_into().expect("four bytes")) as usize;
            let values = blocks::decode(values).ok_or_else(wrong)?;
            let in_order = due.0 < wavelets.len() && place[..4] == [due.0 as u8, 0, 0, 0] && first == due.1;
            if !in_order || values.is_empty() || values.len() > wavelets[due.0].len() - due.1 {
                return Err(wrong());
            }
            wavelets[due.0][due.1..due.1 + values.len()].copy_from_slice(&values);
            due.1 += values.len();
        }
        Ok(false)
    }

    fn ancillary(&mut self, model: &mut Model) -> Result<(), FileError> {
        let count = model.surface.hierarchy().layout(model.surface.finest()).len();
        while let Some((at, chunk)) = self.next()? {
            match chunk.kind {
                SOURCE => {
                    let raw = self.unpack(at, &chunk, 4 * u64::from(count))?;
                    let source: Vec<u32> = raw
                        .chunks_exact(4)
                        .map(|bytes| u32::from_le_bytes(bytes.try_into().expect("four bytes")))
                        .collect();
                    if source.len() != count as usize {
                        return Err(self.error(at, "the source indices do not match the vertices", RESTORE));
                    }
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

/// The source indices of an import, from slots to public ids.
pub fn source_by_public_id(hierarchy: &Hierarchy, by_slot: &[u32]) -> Vec<u32> {
    let layout = hierarchy.layout(hierarchy.finest());
    (0..layout.len())
        .into_par_iter()
        .map(|id| by_slot[layout.slot(layout.site_of(PublicId(id))).index()])
        .collect()
}
