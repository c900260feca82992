//! Changes of so much detail that whole levels are synthesised anew, and how much detail there is.

use super::digest::CoefficientSum;
use super::{Changes, Moved, Surface, Vector};
use crate::hierarchy::{Level, Odd};
use crate::memory::Buffer;
use crate::wavelet::lifting::{minus, plus};
use crate::wavelet::rows::{Instructions, synthesise_level_into};
use rayon::prelude::*;

/// From one changed coefficient in so many finest vertices on, whole levels are cheaper than supports.
const WHOLE_FROM: usize = 32;

impl Surface {
    /// Adds to wavelet coefficients of several levels, without the levels finer than `reach`, which stay as they were. The bits
    /// are those of [`Surface::add_wavelets`] level by level; many changes re-synthesise whole levels. Odd vertices of a level
    /// must differ. Cost: the support, `O(n_J)` at most.
    pub(crate) fn add_details_up_to(
        &mut self,
        deltas: &[(Level, Vec<(Odd, Vector)>)],
        reach: Level,
    ) -> Changes {
        let count: usize = deltas.iter().map(|(_, of_level)| of_level.len()).sum();
        if deltas.is_empty() || count * WHOLE_FROM < self.scaling(reach).len() {
            let mut changes = Changes::nothing(self);
            for (level, of_level) in deltas {
                changes.join(self.add_wavelets_up_to(*level, of_level, reach));
            }
            return changes;
        }
        let mut changes = Changes::nothing(self);
        for (level, of_level) in deltas {
            for &(odd, delta) in of_level {
                let new = plus(self.wavelets[level.index()][odd.index()], delta);
                self.store_wavelet(*level, odd, new, &mut changes);
            }
        }
        let coarsest = deltas.iter().map(|&(level, _)| level).min().expect("something changes");
        changes.join(self.resynthesise(coarsest, reach));
        changes
    }

    /// Puts other wavelet coefficients of a level in place of those there, without synthesis.
    ///
    /// # Panics
    /// If the block does not have the level's length.
    pub(crate) fn put_details(&mut self, level: Level, details: Buffer<Vector>) {
        assert_eq!(details.len(), self.wavelets[level.index()].len());
        self.wavelets[level.index()] = details;
    }

    /// Synthesises the levels above `level` up to `reach`, whole, from what the coefficients are now. `O(n_reach)`. The hash is
    /// that of before until [`Surface::resum`].
    pub(crate) fn synthesise_from(&mut self, level: Level, reach: Level) -> Changes {
        let mut changes = self.resynthesise(level, reach);
        changes.beyond_limit |= !within(&self.wavelets[level.index()..]);
        changes
    }

    fn resynthesise(&mut self, level: Level, reach: Level) -> Changes {
        let mut changes = Changes::nothing(self);
        for j in level.0..reach.0 {
            let (coarser, finer) = self.scaling.split_at_mut(usize::from(j) + 1);
            let known = (&coarser[usize::from(j)][..], &self.wavelets[usize::from(j)][..]);
            let (hierarchy, filters) = (&self.hierarchy, &self.filters);
            synthesise_level_into(hierarchy, filters, Level(j), Instructions::Detected, known, &mut finer[0]);
            changes.moved[usize::from(j) + 1] = Moved::Everything;
        }
        changes.beyond_limit |= !within(&self.scaling[level.index()..=reach.index()]);
        self.follow_bounds(&changes);
        changes
    }

    /// Brings the hash up to date with details that were put in place, by what that added to those before. Cost: the deltas.
    pub(crate) fn resum(&mut self, added: &[(Level, Vec<(Odd, Vector)>)]) {
        for (level, of_level) in added {
            let of_part = |part: &[(Odd, Vector)]| {
                let mut sum = CoefficientSum::default();
                for &(odd, delta) in part {
                    let now = self.wavelets[level.index()][odd.index()];
                    sum.replace(self.wavelet_id(*level, odd), minus(now, delta), now);
                }
                sum
            };
            let sum =
                of_level.par_chunks(4096).map(of_part).reduce(CoefficientSum::default, CoefficientSum::plus);
            self.sum = self.sum.plus(sum);
        }
    }

    /// The energy of every level's wavelets: the sum of squared lengths of `2^−j d^j`, in squared model units, the L2
    /// normalisation in which levels can be compared. `O(n_J)`.
    pub fn spectrum(&self) -> Vec<f64> {
        let step = self.form().placement.step;
        let energy = |(j, details): (usize, &Buffer<Vector>)| {
            // Sums of squares of integers, so that threads cannot matter.
            let sum: u128 = details
                .par_iter()
                .with_min_len(4096)
                .map(|d| d.iter().map(|&x| i64::from(x).unsigned_abs().pow(2)).sum::<u64>() as u128)
                .sum();
            sum as f64 * step * step / f64::from(1u32 << (2 * j))
        };
        self.wavelets.iter().enumerate().map(energy).collect()
    }
}

fn within(blocks: &[Buffer<Vector>]) -> bool {
    let within =
        |values: &Buffer<Vector>| values.par_iter().all(|v| v.iter().all(|&x| super::within_limit(x)));
    blocks.iter().all(within)
}
