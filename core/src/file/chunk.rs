//! Chunks: type, flags, lengths, checksum of these; payload, checksum of header and payload. Every byte of a
//! file lies under one. The header has a checksum of its own because its lengths are trusted before the rest is there: a
//! damaged length would otherwise look like a file cut short. Lengths are as short as they can be: a file of a kilobyte
//! has chunks, too.

use flate2::Compression;
use flate2::read::{DeflateDecoder, DeflateEncoder};
use std::io::{Read, Write};

/// The first bytes of every wavelet file: magic, version, checksum of both.
pub(super) const MAGIC: [u8; 8] = *b"\x89BOZ\r\n\x1a\n";
/// The version of the file format that is written.
pub(super) const VERSION: u16 = 3;
/// The first version that is read.
pub(super) const OLDEST: u16 = 2;
/// Length of the preamble.
pub(super) const PREAMBLE: usize = 16;
/// A flag: a reader that does not know the chunk must refuse the file.
const CRITICAL: u8 = 1;
/// A flag: the payload is a raw DEFLATE stream.
const PACKED: u8 = 2;
/// Bytes of a length, at most: seven bits each.
const LONGEST: usize = 9;

/// A chunk's four-letter type.
pub(super) type Kind = [u8; 4];

/// A chunk as it stands in a file, payload still packed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Chunk {
    /// Four letters.
    pub kind: [u8; 4],
    /// A reader that does not know a critical chunk must refuse the file.
    pub critical: bool,
    /// The length of the payload unpacked, if it is packed.
    raw_len: Option<u64>,
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
        Self::packed(kind, critical, raw.len() as u64, || raw)
    }

    /// The same of a payload of so many bytes that need not be in memory at once; it is read again if packing does not make it
    /// smaller.
    pub(super) fn packed<R: Read>(kind: Kind, critical: bool, raw_len: u64, raw: impl Fn() -> R) -> Self {
        let read = "memory does not fail";
        let mut packed = Vec::new();
        DeflateEncoder::new(raw(), Compression::new(5)).read_to_end(&mut packed).expect(read);
        if (packed.len() as u64) < raw_len {
            packed.shrink_to_fit();
            return Self { kind, critical, raw_len: Some(raw_len), payload: packed };
        }
        let mut payload = Vec::new();
        raw().read_to_end(&mut payload).expect(read);
        Self::stored(kind, critical, payload)
    }

    /// A payload as it is.
    pub(super) fn stored(kind: Kind, critical: bool, payload: Vec<u8>) -> Self {
        Self { kind, critical, raw_len: None, payload }
    }

    /// Appends the chunk to a file's bytes.
    pub(super) fn write(&self, file: &mut Vec<u8>) {
        let start = file.len();
        file.extend(self.kind);
        file.push(if self.critical { CRITICAL } else { 0 } | if self.raw_len.is_some() { PACKED } else { 0 });
        write_length(self.payload.len() as u64, file);
        if let Some(raw_len) = self.raw_len {
            write_length(raw_len, file);
        }
        let fields = file[start..].to_vec();
        file.extend(short_checksum(&fields));
        file.extend(&self.payload);
        file.extend(checksum(&fields, &self.payload).to_le_bytes());
    }

    /// Reads the chunk at the head of `bytes`; also how many bytes it takes.
    pub(super) fn read(bytes: &[u8]) -> Result<(Self, usize), Stop> {
        let flags = *bytes.get(4).ok_or(Stop::Cut)?;
        let mut at = 5;
        let packed_len = read_length(bytes, &mut at)?;
        let raw_len = if flags & PACKED != 0 { Some(read_length(bytes, &mut at)?) } else { None };
        let fields = &bytes[..at];
        if *bytes.get(at..at + 2).ok_or(Stop::Cut)? != short_checksum(fields) {
            return Err(Stop::Damaged("the checksum of a chunk's header does not agree"));
        }
        let start = at + 2;
        let packed_len = usize::try_from(packed_len).map_err(|_| Stop::Cut)?;
        let end = start.checked_add(packed_len).and_then(|n| n.checked_add(4)).ok_or(Stop::Cut)?;
        let whole = bytes.get(..end).ok_or(Stop::Cut)?;
        let (payload, crc) = whole[start..].split_at(packed_len);
        if crc != checksum(fields, payload).to_le_bytes() {
            return Err(Stop::Damaged("the checksum does not agree"));
        }
        if flags & !(CRITICAL | PACKED) != 0 {
            return Err(Stop::Damaged("the chunk uses features of a newer version"));
        }
        let chunk = Self {
            kind: bytes[..4].try_into().expect("four bytes"),
            critical: flags & CRITICAL != 0,
            raw_len,
            payload: payload.to_vec(),
        };
        Ok((chunk, end))
    }

    /// The payload, unpacked; at most `limit` bytes, and exactly as many as the header says.
    pub(super) fn unpack(&self, limit: u64) -> Result<Vec<u8>, &'static str> {
        let mut raw = Vec::new();
        self.unpack_to(limit, &mut raw)?;
        Ok(raw)
    }

    /// [`Chunk::unpack`] piece by piece.
    pub(super) fn unpack_to(&self, limit: u64, to: &mut impl Write) -> Result<(), &'static str> {
        if self.raw_len() > limit {
            return Err("the chunk is larger than such a chunk can be");
        }
        let length = std::io::copy(&mut self.reader(), to).map_err(|_| "the chunk does not unpack")?;
        if length != self.raw_len() {
            return Err("the chunk unpacks to another length than it says");
        }
        Ok(())
    }

    /// The length of the payload unpacked, as the header says.
    pub(super) fn raw_len(&self) -> u64 {
        self.raw_len.unwrap_or(self.payload.len() as u64)
    }

    /// The payload, unpacked as it is read, and at most a byte more of it than the header says.
    pub(super) fn reader(&self) -> impl Read + '_ {
        let payload = self.payload.as_slice();
        let raw: Box<dyn Read + '_> = match self.raw_len {
            Some(_) => Box::new(DeflateDecoder::new(payload)),
            None => Box::new(payload),
        };
        raw.take(self.raw_len() + 1)
    }

    /// The payload of a chunk that is never packed.
    pub(super) fn into_stored(self) -> Result<Vec<u8>, &'static str> {
        if self.raw_len.is_some() {
            Err("the chunk is packed, which such a chunk is not")
        } else {
            Ok(self.payload)
        }
    }
}

/// Seven bits a byte, the lowest first; all bytes but the last have their highest bit set.
fn write_length(mut length: u64, file: &mut Vec<u8>) {
    while length > 127 {
        file.push(length as u8 | 128);
        length >>= 7;
    }
    file.push(length as u8);
}

fn read_length(bytes: &[u8], at: &mut usize) -> Result<u64, Stop> {
    let mut length = 0;
    for place in 0..LONGEST {
        let byte = *bytes.get(*at).ok_or(Stop::Cut)?;
        *at += 1;
        length |= u64::from(byte & 127) << (7 * place);
        if byte < 128 {
            // A length has one spelling.
            return if byte == 0 && place > 0 {
                Err(Stop::Damaged("a chunk's length is damaged"))
            } else {
                Ok(length)
            };
        }
    }
    Err(Stop::Damaged("a chunk's length is damaged"))
}

/// The lower half of a checksum.
fn short_checksum(bytes: &[u8]) -> [u8; 2] {
    (crc32fast::hash(bytes) as u16).to_le_bytes()
}

/// The checksum at a chunk's end. The header's own checksum is left out of it: with it the sum would no longer
/// depend on the header.
fn checksum(fields: &[u8], payload: &[u8]) -> u32 {
    let mut sum = crc32fast::Hasher::new();
    sum.update(fields);
    sum.update(payload);
    sum.finalize()
}

/// The preamble of a version.
pub(super) fn preamble(version: u16) -> [u8; PREAMBLE] {
    let mut bytes = [0; PREAMBLE];
    bytes[..8].copy_from_slice(&MAGIC);
    bytes[8..10].copy_from_slice(&version.to_le_bytes());
    let crc = crc32fast::hash(&bytes[..12]);
    bytes[12..].copy_from_slice(&crc.to_le_bytes());
    bytes
}
