//! What an edit moved, level by level, so that whoever draws or stores can follow it and nothing more.

use super::Surface;
use crate::hierarchy::{Level, Slot};
use std::ops::Range;

/// Runs of slots, sorted and apart. A run may go on over rows of a base face, over base edges and faces.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Runs(Vec<Range<u32>>);

impl Runs {
    /// The runs of some slots, in any order and any number of times. `O(m log m)`.
    pub fn of_slots(mut slots: Vec<u32>) -> Self {
        slots.sort_unstable();
        Self::of_sorted(slots.into_iter().map(|slot| slot..slot + 1))
    }

    /// Joins runs in any order. `O(m log m)`.
    pub fn of_runs(mut runs: Vec<Range<u32>>) -> Self {
        runs.sort_unstable_by_key(|run| run.start);
        Self::of_sorted(runs.into_iter())
    }

    fn of_sorted(sorted: impl Iterator<Item = Range<u32>>) -> Self {
        let mut runs: Vec<Range<u32>> = Vec::new();
        for run in sorted {
            match runs.last_mut() {
                Some(last) if run.start <= last.end => last.end = last.end.max(run.end),
                _ => runs.push(run),
            }
        }
        Self(runs)
    }

    /// The runs in order.
    pub fn iter(&self) -> impl Iterator<Item = Range<u32>> + '_ {
        self.0.iter().cloned()
    }

    /// All slots in order.
    pub fn slots(&self) -> impl Iterator<Item = Slot> + '_ {
        self.iter().flatten().map(Slot)
    }

    /// The number of slots.
    pub fn len(&self) -> usize {
        self.0.iter().map(|run| run.len()).sum()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// The vertices of one level whose positions changed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Moved {
    /// None.
    #[default]
    Nothing,
    /// None but vertices in these runs; nearly all of those.
    Some(Runs),
    /// Possibly all.
    Everything,
}

impl Moved {
    fn join(&mut self, later: Moved) {
        *self = match (std::mem::take(self), later) {
            (Moved::Nothing, other) | (other, Moved::Nothing) => other,
            (Moved::Everything, _) | (_, Moved::Everything) => Moved::Everything,
            (Moved::Some(Runs(mut a)), Moved::Some(Runs(b))) => {
                a.extend(b);
                Moved::Some(Runs::of_runs(a))
            }
        };
    }
}

/// The positions an edit changed.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Changes {
    /// By level, 0 to J: the slots of `c^j` that changed.
    pub moved: Vec<Moved>,
    /// Vertices of the finest level whose mask changed.
    pub masked: Moved,
    /// Whether the surface has other levels now: nothing known of the old ones holds any more.
    pub reshaped: bool,
    /// Whether vertices were hidden or shown again.
    pub hidden: bool,
    /// Whether some coordinate or coefficient went beyond the limit; the surface then has to be put back.
    pub beyond_limit: bool,
}

impl Changes {
    pub(super) fn none(levels: usize) -> Self {
        Self { moved: vec![Moved::Nothing; levels], ..Self::default() }
    }

    /// Changes of a surface that moved nothing.
    pub fn nothing(surface: &Surface) -> Self {
        Self::none(surface.finest().index() + 1)
    }

    /// Changes of a surface of which every vertex may have moved.
    pub fn all(surface: &Surface) -> Self {
        Self { moved: vec![Moved::Everything; surface.finest().index() + 1], ..Self::default() }
    }

    /// What moved at a level.
    pub fn at(&self, level: Level) -> &Moved {
        &self.moved[level.index()]
    }

    /// Notes what moved at a level.
    pub(super) fn record(&mut self, level: Level, runs: Runs) {
        if !runs.is_empty() {
            self.moved[level.index()] = Moved::Some(runs);
        }
    }

    /// Joins what a later edit changed to this.
    pub fn join(&mut self, later: Changes) {
        self.beyond_limit |= later.beyond_limit;
        self.hidden |= later.hidden;
        if later.reshaped || self.reshaped {
            self.reshaped = true;
            self.moved = later.moved;
            self.masked = Moved::Everything;
            return;
        }
        self.masked.join(later.masked);
        if self.moved.is_empty() {
            self.moved = later.moved;
            return;
        }
        self.moved.iter_mut().zip(later.moved).for_each(|(mine, theirs)| mine.join(theirs));
    }
}
