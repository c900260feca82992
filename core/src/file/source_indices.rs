//! Which vertex of an imported mesh each vertex of a surface was.

use super::chunk::{Chunk, Kind};
use crate::hierarchy::{Hierarchy, PublicId};
use rayon::prelude::*;
use std::io::Read;

/// The chunk that holds them.
pub(super) const SOURCE: Kind = *b"SRCE";

/// For each public id the index of the vertex in the imported file. Kept packed as a file has them: few ask, and plain they
/// are four bytes a vertex.
#[derive(Debug, Clone)]
pub struct SourceIndices {
    chunk: Chunk,
    /// Whether it is packed as this version packs; equal models give equal files, whoever wrote what they were read from.
    own: bool,
}

impl SourceIndices {
    /// Packs indices by public id. Linear.
    pub fn new(indices: &[u32]) -> Self {
        let chunk = Chunk::packed(SOURCE, false, 4 * indices.len() as u64, || Bytes(indices));
        Self { chunk, own: true }
    }

    /// Packs the indices of an import, which are by slot of the finest level. Linear.
    pub fn of_slots(hierarchy: &Hierarchy, by_slot: &[u32]) -> Self {
        let layout = hierarchy.layout(hierarchy.finest());
        let ids = (0..layout.len()).into_par_iter().map(PublicId);
        let by_id: Vec<u32> = ids.map(|id| by_slot[layout.slot(layout.site_of(id)).index()]).collect();
        Self::new(&by_id)
    }

    /// Those of a file, if they are so many. Unpacks them piece by piece.
    pub(super) fn read(chunk: Chunk, count: u32) -> Result<Self, &'static str> {
        chunk.unpack_to(4 * u64::from(count), &mut std::io::sink())?;
        if chunk.raw_len() != 4 * u64::from(count) {
            return Err("the source indices do not match the vertices");
        }
        Ok(Self { chunk, own: false })
    }

    /// The chunk as this version writes it.
    pub(super) fn to_chunk(&self) -> Chunk {
        if self.own {
            return self.chunk.clone();
        }
        Chunk::packed(SOURCE, false, self.chunk.raw_len(), || self.chunk.reader())
    }

    /// The indices by public id. Linear.
    pub fn unpacked(&self) -> Vec<u32> {
        let raw = self.chunk.unpack(u64::MAX).expect("unpacked when it was read or made");
        let (indices, _) = raw.as_chunks::<4>();
        indices.iter().map(|&bytes| u32::from_le_bytes(bytes)).collect()
    }
}

impl PartialEq for SourceIndices {
    fn eq(&self, other: &Self) -> bool {
        self.chunk == other.chunk || self.unpacked() == other.unpacked()
    }
}

/// Numbers as their bytes, read many at a time.
struct Bytes<'a>(&'a [u32]);

impl Read for Bytes<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let (places, _) = buffer.as_chunks_mut::<4>();
        let count = places.len().min(self.0.len());
        let (now, later) = self.0.split_at(count);
        places.iter_mut().zip(now).for_each(|(place, index)| *place = index.to_le_bytes());
        self.0 = later;
        Ok(4 * count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whoever packed them, and if nobody did: the same indices, and the same bytes when they are written.
    #[test]
    fn indices_are_written_alike_however_they_were_packed() {
        let regular: Vec<u32> = (0..20_000).collect();
        let random: Vec<u32> = (0..50u32).map(|k| k.wrapping_mul(0x9e37_79b9) ^ k << 27).collect();
        for indices in [regular, random, Vec::new()] {
            let own = SourceIndices::new(&indices);
            assert_eq!(own.unpacked(), indices);
            let raw: Vec<u8> = indices.iter().flat_map(|index| index.to_le_bytes()).collect();
            assert_eq!(own.to_chunk(), Chunk::new(SOURCE, false, &raw));
            let count = indices.len() as u32;
            for chunk in [own.to_chunk(), Chunk::stored(SOURCE, false, raw)] {
                let read = SourceIndices::read(chunk.clone(), count).expect("sound");
                assert_eq!((read.unpacked(), read.to_chunk()), (indices.clone(), own.to_chunk()));
                assert!(SourceIndices::read(chunk, count + 1).is_err());
            }
        }
    }
}
