//! Index newtypes. A bare integer never crosses a module's border where one of these says more.

use std::fmt;

/// A level of detail: `M^0` is the base mesh, `M^{j+1}` splits every face of `M^j` into four.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Level(pub u8);

impl Level {
    /// The coarsest level, the base mesh itself.
    pub const BASE: Level = Level(0);

    /// The next finer level.
    pub fn finer(self) -> Level {
        Level(self.0 + 1)
    }

    /// `2^j`: the number of edges a base edge is split into.
    pub fn segments(self) -> u32 {
        1 << self.0
    }

    /// For indexing arrays by level.
    pub fn index(self) -> usize {
        usize::from(self.0)
    }
}

impl fmt::Display for Level {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// A vertex of `M^j` by its position in level j's storage: base vertices, then edge interiors, then face
/// interiors. Changes from level to level; see [`super::Layout`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Slot(pub u32);

impl Slot {
    /// For indexing arrays of level j.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// An odd vertex of level j (a vertex of `M^{j+1}` that is not in `M^j`), counted in public order from 0. Its
/// public id is `n_j` more.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Odd(pub u32);

impl Odd {
    /// For indexing `d^j`.
    pub fn index(self) -> usize {
        self.0 as usize
    }
}

/// A vertex by its public, nested id: the same number at every level that has it (docs/FORMAT.md, "Numbering").
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PublicId(pub u32);

impl fmt::Display for PublicId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
