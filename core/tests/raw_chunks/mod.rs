//! Wavelet files as chunks, taken apart and put together by code of its own, so that tests can forge files whose
//! checksums are all in order.

#![allow(dead_code, reason = "every test program uses its own part of this")]

use flate2::read::{DeflateDecoder, DeflateEncoder};
use std::io::Read;

/// Length of magic, version and their checksum.
pub(crate) const PREAMBLE: usize = 16;

/// One chunk, unpacked.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RawChunk {
    pub(crate) kind: [u8; 4],
    pub(crate) critical: bool,
    pub(crate) raw: Vec<u8>,
    /// Where the chunk ends in the file it was read from.
    pub(crate) end: usize,
    /// States another unpacked length than the true one.
    pub(crate) stated: Option<u64>,
}

impl RawChunk {
    /// A chunk that stands in no file yet.
    pub(crate) fn new(kind: &[u8; 4], critical: bool, raw: &[u8]) -> Self {
        Self { kind: *kind, critical, raw: raw.to_vec(), end: 0, stated: None }
    }
}

/// Takes a sound file apart.
pub(crate) fn split(file: &[u8]) -> Vec<RawChunk> {
    let number = |at: usize| u64::from_le_bytes(file[at..at + 8].try_into().expect("eight bytes")) as usize;
    let mut chunks = Vec::new();
    let mut at = PREAMBLE;
    while at < file.len() {
        let (raw_len, packed_len) = (number(at + 8), number(at + 16));
        let payload = &file[at + 28..at + 28 + packed_len];
        let mut raw = Vec::new();
        match file[at + 5] {
            0 => raw.extend(payload),
            _ => drop(DeflateDecoder::new(payload).read_to_end(&mut raw).expect("a sound file")),
        }
        assert_eq!(raw.len(), raw_len);
        let end = at + 28 + packed_len + 4;
        let kind = file[at..at + 4].try_into().expect("four bytes");
        chunks.push(RawChunk { kind, critical: file[at + 4] == 1, raw, end, stated: None });
        at = end;
    }
    chunks
}

/// Puts a file together, with every checksum right. Payloads are packed if `pack` says so.
pub(crate) fn join(chunks: &[RawChunk], pack: bool) -> Vec<u8> {
    let mut file = b"\x89BOZ\r\n\x1a\n\x01\0\0\0".to_vec();
    file.extend(crc32fast::hash(&file).to_le_bytes());
    for chunk in chunks {
        let mut payload = chunk.raw.clone();
        if pack {
            payload.clear();
            let packer = DeflateEncoder::new(chunk.raw.as_slice(), flate2::Compression::best());
            std::io::BufReader::new(packer).read_to_end(&mut payload).expect("memory");
        }
        let mut fields = chunk.kind.to_vec();
        fields.extend([u8::from(chunk.critical), u8::from(pack), 0, 0]);
        fields.extend(chunk.stated.unwrap_or(chunk.raw.len() as u64).to_le_bytes());
        fields.extend((payload.len() as u64).to_le_bytes());
        let both = [fields.as_slice(), &payload].concat();
        file.extend(&fields);
        file.extend(crc32fast::hash(&fields).to_le_bytes());
        file.extend(&payload);
        file.extend(crc32fast::hash(&both).to_le_bytes());
    }
    file
}
