//! Normal equations of discs, solved to weights: one system, or several beside each other with the same bits.
//!
//! LDLᵀ in f64; the answer is improved once by its residual, which the integer matrix gives almost exactly, and rounded.
//! `+ − × ÷` alone, each entry in a fixed order: the same bits on every machine, however many entries its instructions take at
//! once.

use super::weights::WEIGHT_BITS;
use pulp::{Arch, Simd, WithSimd};

/// The weights of a positive definite system, its whole matrix row by row.
pub(super) fn solve(matrix: &[f64], right: &[f64]) -> Vec<i32> {
    Arch::new().dispatch(Solve { matrix, right })
}

struct Solve<'a> {
    matrix: &'a [f64],
    right: &'a [f64],
}

impl WithSimd for Solve<'_> {
    type Output = Vec<i32>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<i32> {
        let n = self.right.len();
        if n == 0 {
            return Vec::new();
        }
        // Discs are listed from the middle. Vertices at the rim have few neighbours, so from there most of a column is zero and
        // stays so. A symmetric matrix is turned round like a list.
        let backwards = |numbers: &[f64]| numbers.iter().rev().copied().collect::<Vec<f64>>();
        let (matrix, right) = (backwards(self.matrix), backwards(self.right));
        // Column after column is taken off the rest; `upper` has Lᵀ row by row, and what is left of the matrix.
        let (mut upper, mut diagonal) = (matrix.clone(), vec![0.0; n]);
        for m in 0..n {
            let (above, below) = upper.split_at_mut((m + 1) * n);
            let column = &mut above[m * n..];
            diagonal[m] = column[m];
            column[m + 1..].iter_mut().for_each(|x| *x /= diagonal[m]);
            for (i, row) in (m + 1..n).zip(below.chunks_exact_mut(n)) {
                let own = column[i];
                if own == 0.0 {
                    continue;
                }
                for (x, &other) in row[i..].iter_mut().zip(&column[i..]) {
                    *x -= other * own * diagonal[m];
                }
            }
        }
        let mut s = substituted(&upper, &diagonal, right.clone());
        let mut residual = right;
        for (&s, column) in s.iter().zip(matrix.chunks_exact(n)) {
            for (left, &entry) in residual.iter_mut().zip(column) {
                *left -= entry * s;
            }
        }
        for (s, correction) in s.iter_mut().zip(substituted(&upper, &diagonal, residual)) {
            *s += correction;
        }
        s.iter().rev().map(|&s| weight(s)).collect()
    }
}

/// Solves with the factors of a matrix.
#[inline(always)]
fn substituted(upper: &[f64], diagonal: &[f64], mut x: Vec<f64>) -> Vec<f64> {
    let n = x.len();
    for m in 0..n {
        let known = x[m];
        for (x, &factor) in x[m + 1..].iter_mut().zip(&upper[m * n + m + 1..(m + 1) * n]) {
            *x -= factor * known;
        }
    }
    for i in (0..n).rev() {
        let (x, known) = x[i..].split_first_mut().expect("one at least");
        *x /= diagonal[i];
        for (&known, &factor) in known.iter().zip(&upper[i * n + i + 1..(i + 1) * n]) {
            *x -= factor * known;
        }
    }
    x
}

fn weight(s: f64) -> i32 {
    (s * f64::from(1 << WEIGHT_BITS)).round() as i32
}

/// Systems that are solved beside each other.
pub(super) const LANES: usize = 8;

/// One entry of each.
type Lanes = [f64; LANES];

/// Up to [`LANES`] positive definite systems beside each other, the smaller ones filled up with unknowns that are zero and that
/// nothing else depends on.
#[derive(Debug, Default)]
pub(super) struct Systems {
    sizes: Vec<usize>,
    n: usize,
    /// Row by row, turned round as [`solve`] turns them: above the diagonal what is being solved, below it what was given.
    matrix: Vec<Lanes>,
    diagonal: Vec<Lanes>,
    right: Vec<Lanes>,
}

impl Systems {
    /// Begins anew with systems of such sizes, all entries zero.
    pub(super) fn start(&mut self, sizes: impl IntoIterator<Item = usize>) {
        self.sizes.clear();
        self.sizes.extend(sizes);
        assert!(self.sizes.len() <= LANES, "as many systems as lanes");
        self.n = self.sizes.iter().copied().max().unwrap_or(0);
        for (values, len) in
            [(&mut self.matrix, self.n * self.n), (&mut self.diagonal, self.n), (&mut self.right, self.n)]
        {
            values.clear();
            values.resize(len, [0.0; LANES]);
        }
        for (i, diagonal) in self.diagonal.iter_mut().enumerate() {
            let filled = |lane: usize| self.sizes.get(lane).is_none_or(|&size| i >= size);
            *diagonal = each(|lane| f64::from(filled(lane)));
        }
    }

    /// Sets an entry of a system's matrix off the diagonal; its mirror image is set on its own.
    pub(super) fn set(&mut self, lane: usize, [row, column]: [usize; 2], value: f64) {
        let last = self.sizes[lane] - 1;
        self.matrix[(last - row) * self.n + last - column][lane] = value;
    }

    /// Sets an entry of a system's diagonal and of its right side.
    pub(super) fn set_sides(&mut self, lane: usize, row: usize, diagonal: f64, right: f64) {
        let at = self.sizes[lane] - 1 - row;
        self.diagonal[at][lane] = diagonal;
        self.right[at][lane] = right;
    }

    /// The weights of each, the bits that [`solve`] gives.
    pub(super) fn solve(&mut self) -> Vec<Vec<i32>> {
        let s = Arch::new().dispatch(SolveAll(self));
        let of_lane =
            |(lane, &size): (usize, &usize)| s[..size].iter().rev().map(|s| weight(s[lane])).collect();
        self.sizes.iter().enumerate().map(of_lane).collect()
    }
}

struct SolveAll<'a>(&'a mut Systems);

impl WithSimd for SolveAll<'_> {
    type Output = Vec<Lanes>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Vec<Lanes> {
        let Systems { n, matrix, diagonal: given, right, .. } = self.0;
        let n = *n;
        let mut diagonal = given.clone();
        for m in 0..n {
            let (above, below) = matrix.split_at_mut((m + 1) * n);
            let column = &mut above[m * n..];
            let pivot = diagonal[m];
            column[m + 1..].iter_mut().for_each(|x| *x = each(|l| x[l] / pivot[l]));
            for (i, row) in (m + 1..n).zip(below.chunks_exact_mut(n)) {
                let own = column[i];
                if own == [0.0; LANES] {
                    continue;
                }
                diagonal[i] = each(|l| diagonal[i][l] - own[l] * own[l] * pivot[l]);
                for (x, other) in row[i + 1..].iter_mut().zip(&column[i + 1..]) {
                    *x = each(|l| x[l] - other[l] * own[l] * pivot[l]);
                }
            }
        }
        let mut s = substituted_all(matrix, &diagonal, right.clone());
        let mut residual = right.clone();
        for (c, s) in s.iter().enumerate() {
            for (r, left) in residual.iter_mut().enumerate() {
                let entry = match r.cmp(&c) {
                    std::cmp::Ordering::Less => &matrix[c * n + r],
                    std::cmp::Ordering::Equal => &given[c],
                    std::cmp::Ordering::Greater => &matrix[r * n + c],
                };
                *left = each(|l| left[l] - entry[l] * s[l]);
            }
        }
        for (s, correction) in s.iter_mut().zip(substituted_all(matrix, &diagonal, residual)) {
            *s = each(|l| s[l] + correction[l]);
        }
        s
    }
}

#[inline(always)]
fn each(value: impl FnMut(usize) -> f64) -> Lanes {
    std::array::from_fn(value)
}

/// [`substituted`] for all systems.
#[inline(always)]
fn substituted_all(upper: &[Lanes], diagonal: &[Lanes], mut x: Vec<Lanes>) -> Vec<Lanes> {
    let n = x.len();
    for m in 0..n {
        let known = x[m];
        for (x, factor) in x[m + 1..].iter_mut().zip(&upper[m * n + m + 1..(m + 1) * n]) {
            *x = each(|l| x[l] - factor[l] * known[l]);
        }
    }
    for i in (0..n).rev() {
        let (x, known) = x[i..].split_first_mut().expect("one at least");
        *x = each(|l| x[l] / diagonal[i][l]);
        for (known, factor) in known.iter().zip(&upper[i * n + i + 1..(i + 1) * n]) {
            *x = each(|l| x[l] - factor[l] * known[l]);
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::sampling::SplitMix64;

    /// Systems of discs of all sizes, in every mixture of sizes, give the bits of each on its own.
    #[test]
    fn systems_beside_each_other_give_the_bits_of_one_alone() {
        let mut random = SplitMix64::at(7, 0);
        let mut below = |most: u64| (random.bits() % most) as usize;
        let mut systems = Systems::default();
        for round in 0..200 {
            let alone: Vec<(Vec<f64>, Vec<f64>)> = (0..1 + below(LANES as u64))
                .map(|_| {
                    let n = if round % 3 == 0 { below(65) } else { 20 + below(10) };
                    let mut matrix = vec![0.0; n * n];
                    for i in 0..n {
                        matrix[i * n + i] = 8.0 * (6 + below(2)) as f64;
                        for k in 0..i {
                            if below(n as u64) < 3 {
                                (matrix[i * n + k], matrix[k * n + i]) = (4.0, 4.0);
                            }
                        }
                    }
                    (matrix, (0..n).map(|_| below(11) as f64).collect())
                })
                .collect();
            systems.start(alone.iter().map(|(_, right)| right.len()));
            for (lane, (matrix, right)) in alone.iter().enumerate() {
                let n = right.len();
                for i in 0..n {
                    systems.set_sides(lane, i, matrix[i * n + i], right[i]);
                    (0..n).filter(|&k| k != i).for_each(|k| systems.set(lane, [i, k], matrix[i * n + k]));
                }
            }
            let wanted: Vec<Vec<i32>> = alone.iter().map(|(matrix, right)| solve(matrix, right)).collect();
            assert_eq!(systems.solve(), wanted, "round {round}");
        }
    }
}
