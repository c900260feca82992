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
    /// Is packed, and states this unpacked length.
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
    let length = |at: &mut usize| {
        let (mut length, mut shift) = (0, 0);
        loop {
            let byte = usize::from(file[*at]);
            *at += 1;
            length |= (byte & 127) << shift;
            shift += 7;
            if byte < 128 {
                return length;
            }
        }
    };
    let mut chunks = Vec::new();
    let mut start = PREAMBLE;
    while start < file.len() {
        let flags = file[start + 4];
        let mut at = start + 5;
        let packed_len = length(&mut at);
        let raw_len = if flags & 2 != 0 { Some(length(&mut at)) } else { None };
        at += 2;
        let payload = &file[at..at + packed_len];
        let mut raw = Vec::new();
        match raw_len {
            None => raw.extend(payload),
            Some(_) => drop(DeflateDecoder::new(payload).read_to_end(&mut raw).expect("a sound file")),
        }
        assert_eq!(raw.len(), raw_len.unwrap_or(packed_len));
        let end = at + packed_len + 4;
        let kind = file[start..start + 4].try_into().expect("four bytes");
        chunks.push(RawChunk { kind, critical: flags & 1 == 1, raw, end, stated: None });
        start = end;
    }
    chunks
}

/// Puts a file together, with every checksum right. Ancillary payloads are packed if `pack` says so.
pub(crate) fn join(chunks: &[RawChunk], pack: bool) -> Vec<u8> {
    let mut file = b"\x89BOZ\r\n\x1a\n\x03\0\0\0".to_vec();
    file.extend(crc32fast::hash(&file).to_le_bytes());
    for chunk in chunks {
        let mut payload = chunk.raw.clone();
        let packed = pack && !chunk.critical || chunk.stated.is_some();
        if packed {
            payload.clear();
            let packer = DeflateEncoder::new(chunk.raw.as_slice(), flate2::Compression::best());
            std::io::BufReader::new(packer).read_to_end(&mut payload).expect("memory");
        }
        let mut fields = chunk.kind.to_vec();
        fields.push(u8::from(chunk.critical) | u8::from(packed) << 1);
        put_length(payload.len() as u64, &mut fields);
        if packed {
            put_length(chunk.stated.unwrap_or(chunk.raw.len() as u64), &mut fields);
        }
        let both = [fields.as_slice(), &payload].concat();
        file.extend(&fields);
        file.extend((crc32fast::hash(&fields) as u16).to_le_bytes());
        file.extend(&payload);
        file.extend(crc32fast::hash(&both).to_le_bytes());
    }
    file
}

fn put_length(mut length: u64, bytes: &mut Vec<u8>) {
    while length > 127 {
        bytes.push(length as u8 | 128);
        length >>= 7;
    }
    bytes.push(length as u8);
}
