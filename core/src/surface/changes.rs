//! What an edit moved, level by level, so that whoever draws or stores can follow it and nothing more.

use crate::hierarchy::{Level, Slot};

/// The vertices of one level whose positions changed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Moved {
    /// None.
    #[default]
    Nothing,
    /// These, in no particular order, each once.
    Some(Vec<Slot>),
    /// Possibly all.
    Everything,
}

/// The positions an edit changed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Changes {
    /// By level, 0 to J: the slots of `c^j` that changed.
    pub moved: Vec<Moved>,
    /// Whether some coordinate or coefficient went beyond the limit; the surface then has to be put back.
    pub beyond_limit: bool,
}

impl Changes {
    pub(super) fn none(levels: usize) -> Self {
        Self { moved: vec![Moved::Nothing; levels], beyond_limit: false }
    }

    /// What moved at a level.
    pub fn at(&self, level: Level) -> &Moved {
        &self.moved[level.index()]
    }

    /// Joins what a later edit changed to this.
    pub fn join(&mut self, later: Changes) {
        self.beyond_limit |= later.beyond_limit;
        if self.moved.is_empty() {
            self.moved = later.moved;
            return;
        }
        for (mine, theirs) in self.moved.iter_mut().zip(later.moved) {
            *mine = match (std::mem::take(mine), theirs) {
                (Moved::Nothing, other) | (other, Moved::Nothing) => other,
                (Moved::Everything, _) | (_, Moved::Everything) => Moved::Everything,
                (Moved::Some(mut a), Moved::Some(b)) => {
                    a.extend(b);
                    a.sort_unstable();
                    a.dedup();
                    Moved::Some(a)
                }
            };
        }
    }
}
