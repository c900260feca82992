//! Which step a writer takes next.

use super::Step;
use crate::surface::Vector;

/// What a writer chose, or a reader was told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Choice {
    /// Which of the candidates.
    pub(super) index: usize,
    /// How many planes.
    pub(super) count: u32,
    /// All of the level.
    pub(super) finish: bool,
}

/// How a writer goes through the planes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::file) enum Granularity {
    /// Plane by plane as far as anything is seen of it: the best model for every number of bytes.
    Fine,
    /// Level by level: read several times faster, and coarse levels first.
    Coarse,
}

/// The plane from which on nothing is seen of what is missing: at 24 bits 64 steps are a 260,000th of the extent. A stream
/// that goes on plane by plane till there is up to 0.6 % longer as a whole than one that stops at the noise, or as much
/// shorter; in between its prefixes are up to 25 dB nearer.
const UNSEEN: u32 = 6;

/// From which plane on the finest level is told level by level: what is there is [`UNSEEN`] and, of magnitudes up to twice
/// their mean, is told better as it differs from a smooth surface.
pub(super) fn last_plane(finest: Option<&[Vector]>) -> u32 {
    let finest = finest.unwrap_or_default();
    let sum: u64 = finest.iter().flatten().map(|x| u64::from(x.unsigned_abs())).sum();
    let mean = sum / (3 * finest.len() as u64).max(1);
    UNSEEN.min(65 - mean.leading_zeros())
}

/// All that is missing of the coarsest thing that is not whole.
pub(super) fn coarsest(candidates: &[(Step, u32)]) -> Choice {
    let rank = |step: Step| match step {
        Step::Base => 0,
        Step::Begin(j) | Step::Refine(j, _) => j + 1,
    };
    let index = (0..candidates.len()).min_by_key(|&index| rank(candidates[index].0)).unwrap_or(0);
    let (step, plane) = candidates[index];
    Choice { index, count: plane, finish: matches!(step, Step::Refine(..)) }
}
