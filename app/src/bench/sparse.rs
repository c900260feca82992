//! The same filters as explicit sparse matrices, to compare with: what a solver or a numerical library would do.
//!
//! Compressed sparse rows (CSR) of `f32` with `u32` columns, times three interleaved columns. A level's analysis is two
//! products: `d = B c^{j+1}` with `−½, −½, 1` a row, and `c^j = c^{j+1}|even + U d` with the update's weights, 72 a row
//! at regular vertices for k = 2.

use bozzetto_core::hierarchy::{Layout, Level, Odd, Slot};
use bozzetto_core::memory::Buffer;
use bozzetto_core::surface::Surface;
use bozzetto_core::wavelet::Filters;
use bozzetto_core::wavelet::lifting::parent_slots;
use bozzetto_core::wavelet::weights::WEIGHT_BITS;

/// A sparse matrix by rows.
#[derive(Debug)]
struct Matrix {
    /// Where each row ends in the other two.
    ends: Buffer<u32>,
    columns: Buffer<u32>,
    values: Buffer<f32>,
}

/// The rows of a matrix as they come.
#[derive(Default)]
struct Rows {
    ends: Vec<u32>,
    columns: Vec<u32>,
    values: Vec<f32>,
}

impl Rows {
    fn push(&mut self, column: u32, value: f32) {
        self.columns.push(column);
        self.values.push(value);
    }

    fn end_row(&mut self) {
        self.ends.push(self.columns.len() as u32);
    }

    fn into_matrix(self) -> Matrix {
        Matrix { ends: self.ends.into(), columns: self.columns.into(), values: self.values.into() }
    }
}

impl Matrix {
    /// `y += A x`, row by row.
    fn add_product(&self, x: &[[f32; 3]], y: &mut [[f32; 3]]) {
        let mut start = 0;
        for (&end, y) in self.ends.iter().zip(y) {
            let row = start as usize..end as usize;
            let mut sum = *y;
            for (&column, &value) in self.columns[row.clone()].iter().zip(&self.values[row]) {
                let x = x[column as usize];
                for c in 0..3 {
                    sum[c] += value * x[c];
                }
            }
            *y = sum;
            start = end;
        }
    }
}

/// One level of analysis.
#[derive(Debug)]
struct LevelMatrices {
    /// `d^j` of `c^{j+1}`.
    predict: Matrix,
    /// What `d^j` adds to `c^j`.
    update: Matrix,
    /// The slots of the even vertices at level j + 1.
    evens: Buffer<u32>,
}

/// All levels of analysis as matrices, with the vectors they work on.
#[derive(Debug)]
pub(super) struct SparseAnalysis {
    /// Coarsest first.
    levels: Vec<LevelMatrices>,
    /// `c^j`, by level.
    scaling: Vec<Buffer<[f32; 3]>>,
    /// `d^j`, by level.
    wavelets: Vec<Buffer<[f32; 3]>>,
}

impl SparseAnalysis {
    /// The matrices of a surface's filters and its finest level as floats. Linear in the surface, at some 170 bytes a
    /// vertex of a level.
    pub(super) fn of(surface: &Surface) -> Self {
        let hierarchy = surface.hierarchy();
        let finest = surface.finest();
        let layouts: Vec<&Layout> = (0..=finest.0).map(|j| hierarchy.layout(Level(j))).collect();
        let levels = layouts.windows(2).map(|w| LevelMatrices::of(w[0], w[1], surface.filters())).collect();
        let mut scaling: Vec<_> = layouts.iter().map(|l| Buffer::zeroed(l.len() as usize)).collect();
        let from = surface.scaling(finest);
        scaling[finest.index()] = Buffer::of(from.len(), |slot| from[slot].map(|x| x as f32));
        let wavelets =
            layouts[..finest.index()].iter().map(|l| Buffer::zeroed(l.odd_len() as usize)).collect();
        Self { levels, scaling, wavelets }
    }

    /// Analyses all levels, on this thread.
    pub(super) fn run(&mut self) {
        for (j, level) in self.levels.iter().enumerate().rev() {
            let (coarser, finer) = self.scaling.split_at_mut(j + 1);
            let (coarser, finer) = (&mut coarser[j], &finer[0]);
            let details = &mut self.wavelets[j];
            details.fill([0.0; 3]);
            level.predict.add_product(finer, details);
            for (even, &slot) in coarser.iter_mut().zip(&level.evens[..]) {
                *even = finer[slot as usize];
            }
            level.update.add_product(details, coarser);
        }
    }
}

impl LevelMatrices {
    fn of(coarse: &Layout, fine: &Layout, filters: &Filters) -> Self {
        let (mut predict, mut update) = (Rows::default(), Rows::default());
        for odd in (0..coarse.odd_len()).map(Odd) {
            for parent in parent_slots(coarse, fine, odd) {
                predict.push(parent.0, -0.5);
            }
            predict.push(fine.slot(coarse.odd_site(odd)).0, 1.0);
            predict.end_row();
        }
        let unit = f64::from(1 << WEIGHT_BITS);
        let mut evens = Vec::with_capacity(coarse.len() as usize);
        for slot in (0..coarse.len()).map(Slot) {
            let site = coarse.site(slot);
            filters.for_each_tap(coarse, site, |odd, weight| {
                update.push(odd.0, (f64::from(weight) / unit) as f32);
            });
            update.end_row();
            evens.push(fine.slot(Layout::refine(site)).0);
        }
        Self { predict: predict.into_matrix(), update: update.into_matrix(), evens: evens.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::Base;
    use super::*;

    /// The matrices are the filters: they find the surface's own coefficients but for rounding.
    #[test]
    fn matrices_analyse_as_the_engine_does() {
        for base in [Base::EightFaces, Base::FourHundredFaces] {
            let surface = base.surface(5).expect("small");
            let mut sparse = SparseAnalysis::of(&surface);
            sparse.run();
            for level in (0..5).map(Level) {
                let ours = [surface.scaling(level), surface.wavelets(level)];
                let theirs = [&sparse.scaling[level.index()], &sparse.wavelets[level.index()]];
                for (ours, theirs) in ours.into_iter().zip(theirs) {
                    let apart = ours.iter().flatten().zip(theirs.iter().flatten());
                    let most = apart.map(|(&a, &b)| (f64::from(a) - f64::from(b)).abs()).fold(0.0, f64::max);
                    // Of coordinates up to 2^24, in single precision.
                    assert!(most < 64.0, "{base:?}, {level:?}: {most}");
                }
            }
        }
    }
}
