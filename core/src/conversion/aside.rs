//! Positions put aside: while the connectivity of a large mesh is looked at, its positions wait in a scratch file.

use crate::disk::{Scratch, Stored};
use std::io;

/// Positions of a part.
const PART: usize = 1 << 16;

/// Positions in a scratch file.
pub(super) struct Aside(Vec<Stored>);

impl Aside {
    /// Writes positions down, 24 bytes each.
    ///
    /// # Errors
    /// There is no room for them.
    pub(super) fn put(positions: &[[f64; 3]]) -> io::Result<Self> {
        let scratch = Scratch::default();
        let store = |part: &[[f64; 3]]| {
            let bytes: Vec<u8> = part.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
            scratch.store(&bytes)
        };
        positions.chunks(PART).map(store).collect::<io::Result<_>>().map(Self)
    }

    /// The positions, bit for bit.
    ///
    /// # Errors
    /// They cannot be read any more.
    pub(super) fn take(self, count: usize) -> io::Result<Vec<[f64; 3]>> {
        let mut positions = Vec::with_capacity(count);
        for part in self.0 {
            let bytes = part.read()?;
            let (numbers, _) = bytes.as_chunks::<8>();
            let (triples, _) = numbers.as_chunks::<3>();
            positions.extend(triples.iter().map(|triple| triple.map(f64::from_le_bytes)));
        }
        Ok(positions)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn positions_come_back_bit_for_bit() {
        let count = 2 * PART + 5;
        let positions: Vec<[f64; 3]> =
            (0..count).map(|i| [i as f64 / 3.0, -0.0, f64::from_bits(i as u64)]).collect();
        let back = Aside::put(&positions).and_then(|aside| aside.take(count)).expect("room");
        let bits = |all: &[[f64; 3]]| all.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert!(bits(&back) == bits(&positions));
    }
}
