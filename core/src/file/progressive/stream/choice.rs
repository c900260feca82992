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
    /// Plane by plane down to what is noise: the best model for every number of bytes.
    Fine,
    /// Level by level: read several times faster, and coarse levels first.
    Coarse,
}

/// From which plane on the finest level is told better as it differs from a smooth surface: twice its mean
/// magnitude.
pub(super) fn noise(finest: Option<&Vec<Vector>>) -> u32 {
    let finest = finest.map_or(&[][..], Vec::as_slice);
    let sum: u64 = finest.iter().flatten().map(|x| u64::from(x.unsigned_abs())).sum();
    let mean = sum / (3 * finest.len() as u64).max(1);
    65 - mean.leading_zeros()
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
