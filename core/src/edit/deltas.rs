//! Integers added to coefficients of several levels, and the same packed for the history.
//!
//! Packed, a set of deltas takes a few bytes a coefficient: gaps between sorted indices and zigzagged components as
//! variable-length integers, then DEFLATE unless they are few. The bytes stand behind a shared handle, so that whoever keeps the history can
//! move them elsewhere.

use crate::disk::Stored;
use crate::hierarchy::{Level, Odd, Slot};
use crate::surface::Vector;
use flate2::Compression;
use flate2::read::DeflateDecoder;
use flate2::write::DeflateEncoder;
use std::io::{Read, Write};
use std::sync::{Arc, Mutex};

/// What an edit adds: to scaling coefficients of one level, and to wavelet coefficients of that level and finer ones.
/// Sorted by slot and odd vertex.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Deltas {
    /// Additions to `c^j`.
    pub scaling: Option<(Level, Vec<(Slot, Vector)>)>,
    /// Additions to `d^l`, coarse to fine.
    pub wavelets: Vec<(Level, Vec<(Odd, Vector)>)>,
    /// Vertices of the finest level that are hidden, or shown again, in order.
    pub hidden: Vec<Slot>,
}

/// Where packed bytes are.
pub trait Kept: std::fmt::Debug + Send {
    /// The bytes.
    ///
    /// # Errors
    /// They are elsewhere and cannot be read.
    fn read(&self) -> std::io::Result<Vec<u8>>;

    /// How many of them are in memory.
    fn in_memory(&self) -> usize;
}

impl Kept for Stored {
    fn read(&self) -> std::io::Result<Vec<u8>> {
        Stored::read(self)
    }

    fn in_memory(&self) -> usize {
        0
    }
}

impl Kept for Vec<u8> {
    fn read(&self) -> std::io::Result<Vec<u8>> {
        Ok(self.clone())
    }

    fn in_memory(&self) -> usize {
        self.len()
    }
}

/// Deltas and changes of the mask, packed.
#[derive(Debug, Clone)]
pub struct Packed {
    bytes: Arc<Mutex<Box<dyn Kept>>>,
}

/// A changed value of the mask: slot of the finest level, before, after.
pub type MaskChange = (Slot, u8, u8);

impl Packed {
    /// Packs, with the edit's words as text before them. Linear in what there is.
    pub fn new(words: &[u8], deltas: &Deltas, mask: &[MaskChange]) -> Self {
        let mut out = Out::Plain(vec![PLAIN]);
        out.number(words.len() as u64);
        out.write(words);
        let (level, scaling) = match &deltas.scaling {
            Some((level, of_level)) => (u64::from(level.0), of_level.as_slice()),
            None => (0, [].as_slice()),
        };
        out.number(level);
        out.vectors(scaling.iter().map(|&(slot, v)| (slot.0, v)));
        out.number(deltas.wavelets.len() as u64);
        for (level, of_level) in &deltas.wavelets {
            out.number(u64::from(level.0));
            out.vectors(of_level.iter().map(|&(odd, v)| (odd.0, v)));
        }
        let mut mask = mask.to_vec();
        mask.sort_unstable();
        out.number(mask.len() as u64);
        let mut last = 0;
        for (slot, before, after) in mask {
            out.number(u64::from(slot.0 - last));
            out.number(u64::from(before) << 8 | u64::from(after));
            last = slot.0;
        }
        out.number(deltas.hidden.len() as u64);
        let mut last = 0;
        for slot in &deltas.hidden {
            out.number(u64::from(slot.0 - last));
            last = slot.0;
        }
        let bytes = out.finish();
        Self { bytes: Arc::new(Mutex::new(Box::new(bytes))) }
    }

    /// Unpacks. Linear in what there is.
    ///
    /// # Errors
    /// The bytes were moved elsewhere and cannot be read.
    pub fn unpack(&self) -> std::io::Result<(Deltas, Vec<MaskChange>)> {
        let bytes = self.bytes.lock().expect("nobody panics while holding it").read()?;
        let mut plain = Vec::new();
        opened(&bytes).read_to_end(&mut plain)?;
        let mut input = In(plain.iter().copied());
        let mut deltas = input.deltas(u64::MAX);
        let mut last = 0;
        let mask = (0..input.number())
            .map(|_| {
                last += input.number() as u32;
                let values = input.number();
                (Slot(last), (values >> 8) as u8, values as u8)
            })
            .collect();
        let mut last = 0;
        let hidden = (0..input.number())
            .map(|_| {
                last += input.number() as u32;
                Slot(last)
            })
            .collect();
        deltas.hidden = hidden;
        Ok((deltas, mask))
    }

    /// Unpacks what the first so many levels of wavelets and the scaling coefficients get, and nothing after them. Linear in
    /// that.
    ///
    /// # Errors
    /// The bytes were moved elsewhere and cannot be read.
    pub fn unpack_first(&self, levels: usize) -> std::io::Result<Deltas> {
        let bytes = self.bytes.lock().expect("nobody panics while holding it").read()?;
        let plain = std::io::BufReader::new(opened(&bytes)).bytes();
        Ok(In(plain.map_while(Result::ok)).deltas(levels as u64))
    }

    /// The edit's words.
    ///
    /// # Errors
    /// The bytes were moved elsewhere and cannot be read.
    pub fn words(&self) -> std::io::Result<Vec<u8>> {
        let bytes = self.bytes.lock().expect("nobody panics while holding it").read()?;
        let mut input = opened(&bytes);
        let (mut len, mut shift, mut byte) = (0, 0, [0x80]);
        while byte[0] >= 0x80 {
            input.read_exact(&mut byte)?;
            len |= u64::from(byte[0] & 0x7f) << shift;
            shift += 7;
        }
        let mut words = Vec::new();
        input.take(len).read_to_end(&mut words)?;
        Ok(words)
    }

    /// Brings the bytes back into memory; whether they were elsewhere.
    ///
    /// # Errors
    /// They cannot be read.
    pub fn call_back(&self) -> std::io::Result<bool> {
        let mut kept = self.bytes.lock().expect("nobody panics while holding it");
        let bytes = kept.read()?;
        let elsewhere = kept.in_memory() < bytes.len();
        if elsewhere {
            *kept = Box::new(bytes);
        }
        Ok(elsewhere)
    }

    /// The handle behind which the bytes stand.
    pub fn handle(&self) -> &Arc<Mutex<Box<dyn Kept>>> {
        &self.bytes
    }
}

/// The first byte of packed bytes, before plain ones and before deflated ones.
const PLAIN: u8 = 0;
const DEFLATED: u8 = 1;

/// As many bytes are kept plain: making a deflater ready takes longer than most edits of a few coefficients.
const FEW: usize = 512;

/// What was packed, to be read.
fn opened(bytes: &[u8]) -> Box<dyn Read + '_> {
    match bytes.split_first() {
        Some((&DEFLATED, rest)) => Box::new(DeflateDecoder::new(rest)),
        Some((_, rest)) => Box::new(rest),
        None => Box::new(bytes),
    }
}

enum Out {
    Plain(Vec<u8>),
    Deflated(DeflateEncoder<Vec<u8>>),
}

impl Out {
    fn write(&mut self, more: &[u8]) {
        match self {
            Out::Plain(bytes) if bytes.len() + more.len() <= FEW => bytes.extend_from_slice(more),
            Out::Plain(bytes) => {
                let mut encoder = DeflateEncoder::new(vec![DEFLATED], Compression::fast());
                for part in [&bytes[1..], more] {
                    encoder.write_all(part).expect("memory takes every byte");
                }
                *self = Out::Deflated(encoder);
            }
            Out::Deflated(encoder) => encoder.write_all(more).expect("memory takes every byte"),
        }
    }

    fn finish(self) -> Vec<u8> {
        match self {
            Out::Plain(bytes) => bytes,
            Out::Deflated(encoder) => encoder.finish().expect("memory takes every byte"),
        }
    }

    fn number(&mut self, mut x: u64) {
        let (mut bytes, mut len) = ([0; 10], 0);
        while x >= 0x80 {
            bytes[len] = x as u8 | 0x80;
            x >>= 7;
            len += 1;
        }
        bytes[len] = x as u8;
        self.write(&bytes[..=len]);
    }

    fn vectors(&mut self, sorted: impl ExactSizeIterator<Item = (u32, Vector)>) {
        self.number(sorted.len() as u64);
        let mut last = 0;
        for (at, v) in sorted {
            self.number(u64::from(at - last));
            last = at;
            for x in v {
                self.number(u64::from((x << 1 ^ x >> 31) as u32));
            }
        }
    }
}

struct In<I>(I);

impl<I: Iterator<Item = u8>> In<I> {
    /// The words passed over, scaling coefficients and the first so many levels of wavelets.
    fn deltas(&mut self, levels: u64) -> Deltas {
        let words = self.number() as usize;
        if let Some(last) = words.checked_sub(1) {
            self.0.nth(last);
        }
        let level = Level(self.number() as u8);
        let scaling: Vec<(Slot, Vector)> = self.vectors().map(|(at, v)| (Slot(at), v)).collect();
        let wavelets = (0..self.number().min(levels))
            .map(|_| {
                let level = Level(self.number() as u8);
                (level, self.vectors().map(|(at, v)| (Odd(at), v)).collect())
            })
            .collect();
        let scaling = (!scaling.is_empty()).then_some((level, scaling));
        Deltas { scaling, wavelets, hidden: Vec::new() }
    }

    fn number(&mut self) -> u64 {
        let (mut x, mut shift) = (0, 0);
        for byte in self.0.by_ref() {
            x |= u64::from(byte & 0x7f) << shift;
            shift += 7;
            if byte < 0x80 {
                break;
            }
        }
        x
    }

    fn vectors(&mut self) -> std::vec::IntoIter<(u32, Vector)> {
        let count = self.number();
        let mut last = 0;
        let vectors: Vec<_> = (0..count)
            .map(|_| {
                last += self.number() as u32;
                let v = std::array::from_fn(|_| {
                    let x = self.number() as u32;
                    (x >> 1) as i32 ^ -((x & 1) as i32)
                });
                (last, v)
            })
            .collect();
        vectors.into_iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether few enough to be kept plain or not, and just at the border.
    #[test]
    fn words_of_any_length_come_back() {
        for len in [0, 1, 127, 128, FEW - 20, FEW - 10, FEW - 9, FEW - 8, FEW - 5, FEW, 3 * FEW] {
            let words: Vec<u8> = (0..len).map(|at| at as u8).collect();
            let deltas =
                Deltas { scaling: Some((Level(2), vec![(Slot(5), [4, -4, 300])])), ..Deltas::default() };
            let packed = Packed::new(&words, &deltas, &[]);
            assert_eq!(packed.words().expect("in memory"), words);
            assert_eq!(packed.unpack().expect("in memory").0, deltas, "{len}");
            let first = packed.handle().lock().expect("free").read().expect("in memory")[0];
            assert_eq!(first == DEFLATED, len > FEW - 15, "{len}");
        }
    }

    #[test]
    fn what_is_packed_comes_back() {
        let deltas = Deltas {
            scaling: Some((Level(3), vec![(Slot(0), [1, -2, 3]), (Slot(900_000), [i32::MAX, i32::MIN, 0])])),
            wavelets: vec![
                (Level(3), vec![(Odd(7), [5, 5, 5])]),
                (Level(6), (0..5000).map(|i| (Odd(3 * i), [i as i32 - 2000, 0, -1])).collect()),
            ],
            hidden: vec![Slot(2), Slot(700)],
        };
        let mask = [(Slot(9), 0, 255), (Slot(4), 17, 3)];
        let packed = Packed::new(b"some words", &deltas, &mask);
        assert_eq!(packed.words().expect("in memory"), b"some words");
        let (back, mut mask_back) = packed.unpack().expect("in memory");
        assert_eq!(back, deltas);
        for levels in 0..=2 {
            let first = packed.unpack_first(levels).expect("in memory");
            assert_eq!(first.scaling, deltas.scaling);
            assert_eq!((first.wavelets.as_slice(), first.hidden.len()), (&deltas.wavelets[..levels], 0));
        }
        mask_back.reverse();
        assert_eq!(mask_back, mask);
        let size = packed.handle().lock().expect("free").in_memory();
        assert!(size < 16_000, "{size} bytes for 5000 vectors");
        let (nothing, none) = Packed::new(b"", &Deltas::default(), &[]).unpack().expect("in memory");
        assert!(nothing == Deltas::default() && none.is_empty());
    }
}
