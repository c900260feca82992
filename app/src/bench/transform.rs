//! Whole transforms: all levels of analysis and synthesis, beside copying and sparse matrices.

use super::shape::Base;
use super::sparse::SparseAnalysis;
use super::timings::{Timings, pool};
use anyhow::Result;
use bozzetto_core::hierarchy::Level;
use bozzetto_core::memory::Buffer;
use bozzetto_core::surface::{Surface, Vector};
use bozzetto_core::wavelet::rows::{Instructions, analyse_level_into, synthesise_level_into};
use std::hint::black_box;
use std::time::Instant;

/// A surface's coefficients in storage that is written over and over.
struct Bank<'a> {
    surface: &'a Surface,
    scaling: Vec<Buffer<Vector>>,
    wavelets: Vec<Buffer<Vector>>,
}

impl<'a> Bank<'a> {
    fn of(surface: &'a Surface) -> Self {
        let levels = surface.finest().0;
        let scaling = (0..=levels).map(|j| surface.scaling(Level(j)).into()).collect();
        let wavelets = (0..levels).map(|j| surface.wavelets(Level(j)).into()).collect();
        Self { surface, scaling, wavelets }
    }

    fn analyse(&mut self) {
        for j in (0..self.wavelets.len()).rev() {
            let (coarser, finer) = self.scaling.split_at_mut(j + 1);
            analyse_level_into(
                self.surface.hierarchy(),
                self.surface.filters(),
                Level(j as u8),
                Instructions::Detected,
                &finer[0],
                (&mut self.wavelets[j], &mut coarser[j]),
            );
        }
    }

    fn both_ways(&mut self) {
        self.analyse();
        self.synthesise();
    }

    fn synthesise(&mut self) {
        for j in 0..self.wavelets.len() {
            let (coarser, finer) = self.scaling.split_at_mut(j + 1);
            synthesise_level_into(
                self.surface.hierarchy(),
                self.surface.filters(),
                Level(j as u8),
                Instructions::Detected,
                (&coarser[j], &self.wavelets[j]),
                &mut finer[0],
            );
        }
    }
}

/// Nanoseconds per vertex of the finest level, for all levels.
pub(super) struct TransformFigures {
    pub(super) analysis: f64,
    pub(super) synthesis: f64,
    pub(super) copy: f64,
    pub(super) sparse: f64,
    /// One thread's time over two threads'.
    pub(super) two_threads_speedup: f64,
    /// The same of copying, half of the vertices each.
    pub(super) copy_two_threads_speedup: f64,
}

/// Measures analysis, synthesis and both baselines by turns.
///
/// # Errors
/// No room for threads.
pub(super) fn transforms(surface: &Surface, runs: usize, done: &dyn Fn(f32)) -> Result<TransformFigures> {
    let (one, two) = (pool(1)?, pool(2)?);
    let mut bank = Bank::of(surface);
    let mut sparse = SparseAnalysis::of(surface);
    let finest = surface.scaling(surface.finest());
    let mut copied = Buffer::from(finest);
    let mut timings: [Timings; 7] = Default::default();
    let [analysis, synthesis, copy, copy_together, explicit, together, apart] = &mut timings;
    for run in 0..runs {
        done(run as f32 / runs as f32);
        // Once unmeasured: the matrices have pushed everything out of the caches, and threads that have just woken may
        // still share a processor.
        one.install(|| {
            bank.both_ways();
            let begun = Instant::now();
            analysis.time(|| bank.analyse());
            synthesis.time(|| bank.synthesise());
            apart.push(begun.elapsed().as_secs_f64());
        });
        two.install(|| {
            bank.both_ways();
            together.time(|| bank.both_ways());
            let half = finest.len() / 2;
            let (low, high) = copied.split_at_mut(half);
            copy_together.time(|| {
                rayon::join(
                    || black_box(low).copy_from_slice(black_box(&finest[..half])),
                    || black_box(high).copy_from_slice(black_box(&finest[half..])),
                )
            });
        });
        one.install(|| {
            copy.time(|| black_box(&mut copied).copy_from_slice(black_box(finest)));
            explicit.time(|| sparse.run());
        });
    }
    let per_vertex = |timings: &Timings| timings.median() / finest.len() as f64 * 1e9;
    Ok(TransformFigures {
        analysis: per_vertex(analysis),
        synthesis: per_vertex(synthesis),
        copy: per_vertex(copy),
        sparse: per_vertex(explicit),
        two_threads_speedup: apart.median() / together.median(),
        copy_two_threads_speedup: copy.median() / copy_together.median(),
    })
}

/// How much more a vertex costs, analysis or synthesis, whichever grows more, over a base mesh with `large` levels than
/// with `small` ones; on one thread.
///
/// # Errors
/// Too many levels, or no room for threads.
pub(super) fn growth(base: Base, [small, large]: [u8; 2], runs: usize, done: &dyn Fn(f32)) -> Result<f64> {
    let surfaces = [base.surface(small)?, base.surface(large)?];
    let mut banks = surfaces.each_ref().map(Bank::of);
    let counts = surfaces.each_ref().map(|s| s.scaling(s.finest()).len());
    // As many vertices of the small surface as of the large one in all, so that one hiccup weighs alike.
    let repeats = [(counts[1] / counts[0]).clamp(1, 64), 1];
    let mut timings: [[Timings; 2]; 2] = Default::default();
    let one = pool(1)?;
    for run in 0..runs {
        done(run as f32 / runs as f32);
        for ((bank, timings), repeats) in banks.iter_mut().zip(&mut timings).zip(repeats) {
            one.install(|| {
                for _ in 0..repeats {
                    timings[0].time(|| bank.analyse());
                    timings[1].time(|| bank.synthesise());
                }
            });
        }
    }
    let per_vertex = |size: usize, way: usize| timings[size][way].median() / counts[size] as f64;
    Ok([0, 1].map(|way| per_vertex(1, way) / per_vertex(0, way)).into_iter().fold(0.0, f64::max))
}
