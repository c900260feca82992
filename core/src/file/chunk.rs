//! Chunks: type, flags, lengths, checksum of these; payload, checksum of header and payload. Every byte of a
//! file lies under one. The header has a checksum of its own because its lengths are trusted before the rest is there: a
//! damaged length would otherwise look like a file cut short.

use flate2::Compression;
use flate2::read::{DeflateDecoder, DeflateEncoder};
use std::io::Read;

/// The first bytes of every wavelet file: magic, version, checksum of both.
pub(super) const MAGIC: [u8; 8] = *b"\x89BOZ\r\n\x1a\n";
/// The version of the file format.
pub(super) const VERSION: u16 = 1;
/// Length of the preamble.
pub(super) const PREAMBLE: usize = 16;
/// Type, flags, packing, two zeros, raw length, packed length, checksum.
const HEADER: usize = FIELDS + 4;
const FIELDS: usize = 24;
const CRITICAL: u8 = 1;

/// A chunk's four-letter type.
pub(super) type Kind = [u8; 4];

/// A chunk as it stands in a file, payload still packed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chunk {
    /// Four letters.
    pub kind: [u8; 4],
    /// A reader that does not know a critical chunk must refuse the file.
    pub critical: bool,
    packing: u8,
    raw_len: u64,
    payload: Vec<u8>,
}

/// Why the next chunk cannot be had.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Stop {
    /// The file ends inside the chunk: a partial model.
    Cut,
    /// The bytes are not a chunk.
    Damaged(&'static str),
}

impl Chunk {
    /// Packs a payload if that makes it smaller.
    pub(super) fn new(kind: Kind, critical: bool, raw: &[u8]) -> Self {
        let mut packed = Vec::new();
        DeflateEncoder::new(raw, Compression::new(5)).read_to_end(&mut packed).expect("memory does not fail");
        let (packing, payload) = if packed.len() < raw.len() { (1, packed) } else { (0, raw.to_vec()) };
        Self { kind, critical, packing, raw_len: raw.len() as u64, payload }
    }

    /// Appends the chunk to a file's bytes.
    pub(super) fn write(&self, file: &mut Vec<u8>) {
        let start = file.len();
        file.extend(self.kind);
        file.extend([if self.critical { CRITICAL } else { 0 }, self.packing, 0, 0]);
        file.extend(self.raw_len.to_le_bytes());
        file.extend((self.payload.len() as u64).to_le_bytes());
        let fields = file[start..].to_vec();
        file.extend(crc32fast::hash(&fields).to_le_bytes());
        file.extend(&self.payload);
        file.extend(checksum(&fields, &self.payload).to_le_bytes());
    }

    /// Reads the chunk at the head of `bytes`; also how many bytes it takes.
    pub(super) fn read(bytes: &[u8]) -> Result<(Self, usize), Stop> {
        let header = bytes.get(..HEADER).ok_or(Stop::Cut)?;
        let (fields, crc) = header.split_at(FIELDS);
        if crc != crc32fast::hash(fields).to_le_bytes() {
            return Err(Stop::Damaged("the checksum of a chunk's header does not agree"));
        }
        let length = |at: usize| u64::from_le_bytes(header[at..at + 8].try_into().expect("eight bytes"));
        let packed_len = usize::try_from(length(16)).map_err(|_| Stop::Cut)?;
        let end = HEADER.checked_add(packed_len).and_then(|n| n.checked_add(4)).ok_or(Stop::Cut)?;
        let whole = bytes.get(..end).ok_or(Stop::Cut)?;
        let (payload, crc) = whole[HEADER..].split_at(packed_len);
        if crc != checksum(fields, payload).to_le_bytes() {
            return Err(Stop::Damaged("the checksum does not agree"));
        }
        if header[4] & !CRITICAL != 0 || header[5] > 1 || header[6..8] != [0, 0] {
            return Err(Stop::Damaged("the chunk uses features of a newer version"));
        }
        let chunk = Self {
            kind: header[..4].try_into().expect("four bytes"),
            critical: header[4] & CRITICAL != 0,
            packing: header[5],
            raw_len: length(8),
            payload: payload.to_vec(),
        };
        Ok((chunk, end))
    }

    /// The payload, unpacked; at most `limit` bytes, and exactly as many as the header says.
    pub(super) fn unpack(&self, limit: u64) -> Result<Vec<u8>, &'static str> {
        if self.raw_len > limit {
            return Err("the chunk says it is larger than such a chunk can be");
        }
        if self.packing == 0 {
            if self.payload.len() as u64 != self.raw_len {
                return Err("the chunk's two lengths do not agree");
            }
            return Ok(self.payload.clone());
        }
        let mut raw = Vec::new();
        DeflateDecoder::new(self.payload.as_slice())
            .take(self.raw_len + 1)
            .read_to_end(&mut raw)
            .map_err(|_| "the chunk does not unpack")?;
        if raw.len() as u64 != self.raw_len {
            return Err("the chunk unpacks to another length than it says");
        }
        Ok(raw)
    }
}

/// The checksum at a chunk's end. The header's own checksum is left out of it: with it the sum would no longer
/// depend on the header.
fn checksum(fields: &[u8], payload: &[u8]) -> u32 {
    let mut sum = crc32fast::Hasher::new();
    sum.update(fields);
    sum.update(payload);
    sum.finalize()
}

/// The preamble.
pub(super) fn preamble() -> [u8; PREAMBLE] {
    let mut bytes = [0; PREAMBLE];
    bytes[..8].copy_from_slice(&MAGIC);
    bytes[8..10].copy_from_slice(&VERSION.to_le_bytes());
    let crc = crc32fast::hash(&bytes[..12]);
    bytes[12..].copy_from_slice(&crc.to_le_bytes());
    bytes
}
