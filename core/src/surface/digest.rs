//! The surface hash: one number for everything that a surface is.
//!
//! The coefficients enter as a sum over (public id, value) of a mixed 128-bit term, so an edit updates the sum by
//! what it changed and no order, thread or layout matters. The sum and the header then go through SHA-256. It
//! guards against mistakes and damage, not against a forger: sums can be forged on purpose.

use super::Form;
use crate::hierarchy::{Hierarchy, PublicId};
use sha2::{Digest, Sha256};
use std::fmt;

/// The surface hash, printed as 32 hexadecimal digits.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct SurfaceHash(pub [u8; 16]);

impl fmt::Display for SurfaceHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for SurfaceHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::str::FromStr for SurfaceHash {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        if text.len() != 32 || !text.bytes().all(|b| matches!(b, b'0'..=b'9' | b'a'..=b'f')) {
            return Err(());
        }
        let mut bytes = [0; 16];
        for (byte, digits) in bytes.iter_mut().zip(text.as_bytes().chunks(2)) {
            let digits = std::str::from_utf8(digits).map_err(|_| ())?;
            *byte = u8::from_str_radix(digits, 16).map_err(|_| ())?;
        }
        Ok(Self(bytes))
    }
}

const SEEDS: [u64; 2] = [0x243f_6a88_85a3_08d3, 0x1319_8a2e_0370_7344];

fn mix(mut h: u64) -> u64 {
    const MULTIPLIER: u64 = 0xd6e8_feb8_6659_fd93;
    h = (h ^ (h >> 32)).wrapping_mul(MULTIPLIER);
    h = (h ^ (h >> 32)).wrapping_mul(MULTIPLIER);
    h ^ (h >> 32)
}

/// The running sum over coefficients.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CoefficientSum([u64; 2]);

impl CoefficientSum {
    /// The term of one coefficient: `x | y << 32` and `z | id << 32`, mixed in that order from a seed per lane.
    pub fn term(id: PublicId, [x, y, z]: [i32; 3]) -> Self {
        let word = |low: u32, high: u32| u64::from(low) | u64::from(high) << 32;
        let words = [word(x as u32, y as u32), word(z as u32, id.0)];
        Self(SEEDS.map(|seed| words.iter().fold(seed, |h, word| mix(h ^ word))))
    }

    /// The sum of two sums.
    pub fn plus(self, other: Self) -> Self {
        Self([self.0[0].wrapping_add(other.0[0]), self.0[1].wrapping_add(other.0[1])])
    }

    /// Replaces one coefficient's value.
    pub fn replace(&mut self, id: PublicId, old: [i32; 3], new: [i32; 3]) {
        let (old, new) = (Self::term(id, old), Self::term(id, new));
        for lane in 0..2 {
            self.0[lane] = self.0[lane].wrapping_sub(old.0[lane]).wrapping_add(new.0[lane]);
        }
    }

    /// The surface hash: SHA-256 of header and sum, first 16 bytes.
    pub fn finish(self, header: &[u8]) -> SurfaceHash {
        let mut sha = Sha256::new();
        sha.update(header);
        for lane in self.0 {
            sha.update(lane.to_le_bytes());
        }
        let mut bytes = [0; 16];
        bytes.copy_from_slice(&sha.finalize()[..16]);
        SurfaceHash(bytes)
    }
}

/// The bytes of everything but the coefficients, as they enter the hash (docs/FORMAT.md, "Surface hash").
pub fn header_bytes(hierarchy: &Hierarchy, form: &Form) -> Vec<u8> {
    let mut bytes = b"bozzetto surface 1\0".to_vec();
    bytes.extend([form.scheme.code(), form.wavelet.code(), hierarchy.finest().0, form.precision, 3]);
    for channel in super::CHANNELS {
        bytes.push(channel.len() as u8);
        bytes.extend(channel.as_bytes());
    }
    for number in form.placement.origin.iter().chain([&form.placement.step]) {
        bytes.extend(number.to_le_bytes());
    }
    bytes.push(form.placement.up.code());
    bytes.extend((form.placement.unit.len() as u32).to_le_bytes());
    bytes.extend(form.placement.unit.as_bytes());
    let base = hierarchy.base();
    bytes.extend(base.vertex_count().to_le_bytes());
    bytes.extend((base.faces().len() as u32).to_le_bytes());
    bytes.extend(base.faces().iter().flatten().flat_map(|v| v.to_le_bytes()));
    let sharp = base.sharp_edges();
    bytes.extend((sharp.len() as u32).to_le_bytes());
    bytes.extend(sharp.iter().flatten().flat_map(|v| v.to_le_bytes()));
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_read_back_and_have_one_spelling() {
        let hash = SurfaceHash([0xab; 16]);
        assert_eq!(hash.to_string().parse(), Ok(hash));
        for wrong in ["", "ab", &"AB".repeat(16), &"+b".repeat(16), &"ab".repeat(17)] {
            assert_eq!(wrong.parse::<SurfaceHash>(), Err(()), "{wrong}");
        }
    }
}
