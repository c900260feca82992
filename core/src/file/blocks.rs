//! Blocks of coefficients as bytes: zigzag, then one plane per channel and byte, most significant first, so that
//! small numbers leave long runs of zeros for the packer.

use crate::surface::Vector;

/// Coefficients per block: small enough that a cut file loses little.
pub(super) const BLOCK: usize = 1 << 15;

/// Appends the planes of some coefficients.
pub(super) fn encode(values: &[Vector], bytes: &mut Vec<u8>) {
    for channel in 0..3 {
        for byte in (0..4).rev() {
            bytes.extend(values.iter().map(|v| (zigzag(v[channel]) >> (8 * byte)) as u8));
        }
    }
}

/// Reads planes back; `None` if the length is not 12 bytes a coefficient.
pub(super) fn decode(bytes: &[u8]) -> Option<Vec<Vector>> {
    if !bytes.len().is_multiple_of(12) {
        return None;
    }
    let count = bytes.len() / 12;
    let mut values = vec![[0; 3]; count];
    for (at, value) in values.iter_mut().enumerate() {
        for (channel, x) in value.iter_mut().enumerate() {
            let planes = (0..4).map(|k| u32::from(bytes[(4 * channel + k) * count + at]));
            *x = unzigzag(planes.fold(0, |word, byte| word << 8 | byte));
        }
    }
    Some(values)
}

fn zigzag(x: i32) -> u32 {
    ((x << 1) ^ (x >> 31)) as u32
}

fn unzigzag(x: u32) -> i32 {
    (x >> 1) as i32 ^ -((x & 1) as i32)
}
