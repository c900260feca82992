//! Wavelet analysis the plain way, straight from the definitions and sharing no code with the program: subdivided
//! meshes with their own numbering, hat functions and wavelets as dense columns, and `[P|Q]` inverted by elimination.
#![allow(dead_code, unreachable_pub)]

use std::collections::{BTreeMap, BTreeSet};

/// A dense matrix by rows.
pub type Matrix = Vec<Vec<f64>>;

/// A weight that is off on purpose: of the wavelet of this odd vertex, by so much.
#[derive(Clone, Copy)]
pub struct WrongWeight {
    /// The odd vertex.
    pub odd: usize,
    /// What is added to its weight at one end of its edge.
    pub error: f64,
}

/// A base mesh split 1→4 several times. Vertices of a level keep their indices in all finer ones.
pub struct Meshes {
    /// The triangles of each level, coarsest first.
    pub faces: Vec<Vec<[usize; 3]>>,
    /// The number of vertices of each level.
    pub counts: Vec<usize>,
    /// The two ends of the edge that each vertex halves; meaningless for base vertices.
    pub parents: Vec<[usize; 2]>,
}

impl Meshes {
    /// Splits a base mesh `times` times.
    pub fn subdivide(base: &[[u32; 3]], times: usize) -> Self {
        let base: Vec<[usize; 3]> = base.iter().map(|face| face.map(|v| v as usize)).collect();
        let count = 1 + base.iter().flatten().max().expect("a face");
        let mut meshes = Self { faces: vec![base], counts: vec![count], parents: vec![[0; 2]; count] };
        for _ in 0..times {
            meshes.split();
        }
        meshes
    }

    fn split(&mut self) {
        let mut middle_of = BTreeMap::new();
        let mut finer = Vec::new();
        for &[a, b, c] in self.faces.last().expect("level 0") {
            let mut middle = |u: usize, v: usize| {
                let ends = [u.min(v), u.max(v)];
                *middle_of.entry(ends).or_insert_with(|| {
                    self.parents.push(ends);
                    self.parents.len() - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        self.faces.push(finer);
        self.counts.push(self.parents.len());
    }

    /// `N_k` of an odd vertex: the ends of its edge, then `k` times all vertices of all triangles at them.
    fn disc(&self, level: usize, odd: usize, k: usize) -> Vec<usize> {
        let mut disc = BTreeSet::from(self.parents[odd]);
        for _ in 0..k {
            let touching = self.faces[level].iter().filter(|face| face.iter().any(|v| disc.contains(v)));
            disc = touching.flatten().copied().collect();
        }
        disc.into_iter().collect()
    }

    /// `P^j` by columns: the hat function of every vertex in the hat functions of the next level, zeros left out.
    fn refinement(&self, level: usize) -> Vec<Vec<(usize, f64)>> {
        let (coarse, fine) = (self.counts[level], self.counts[level + 1]);
        let mut columns: Vec<Vec<(usize, f64)>> = (0..coarse).map(|v| vec![(v, 1.0)]).collect();
        for odd in coarse..fine {
            self.parents[odd].iter().for_each(|&end| columns[end].push((odd, 0.5)));
        }
        columns
    }

    /// Inner products of a level's hat functions; every face of the level has the same area.
    fn inner_products(&self, level: usize) -> Matrix {
        let count = self.counts[level];
        let area = 0.25f64.powi(level as i32);
        let mut products = vec![vec![0.0; count]; count];
        for face in &self.faces[level] {
            for &u in face {
                for &v in face {
                    products[u][v] += if u == v { area / 6.0 } else { area / 12.0 };
                }
            }
        }
        products
    }

    /// `[P|Q]` of a level for the k-disc wavelet, or the lazy one for `None`.
    pub fn synthesis_matrix(&self, level: usize, k: Option<usize>, wrong: Option<WrongWeight>) -> Matrix {
        let (coarse, fine) = (self.counts[level], self.counts[level + 1]);
        let p = self.refinement(level);
        let (hats, finer_hats) = (self.inner_products(level), self.inner_products(level + 1));
        let mut pq = vec![vec![0.0; fine]; fine];
        for (v, column) in p.iter().enumerate() {
            column.iter().for_each(|&(row, value)| pq[row][v] = value);
        }
        for odd in coarse..fine {
            let disc = k.map_or(Vec::new(), |k| self.disc(level, odd, k));
            let gram = disc.iter().map(|&u| disc.iter().map(|&v| hats[u][v]).collect()).collect();
            let with_odd = |u: usize| p[u].iter().map(|&(w, value)| value * finer_hats[odd][w]).sum::<f64>();
            let right = disc.iter().map(|&u| vec![with_odd(u)]).collect();
            let solved = solve(gram, right).into_iter().map(|row| row[0]);
            let mut weights: Vec<(usize, f64)> = disc.iter().copied().zip(solved).collect();
            if let Some(wrong) = wrong.filter(|wrong| wrong.odd == odd) {
                weights.push((self.parents[odd][0], wrong.error));
            }
            pq[odd][odd] = 1.0;
            for (v, weight) in weights {
                p[v].iter().for_each(|&(row, value)| pq[row][odd] -= weight * value);
            }
        }
        pq
    }

    /// Every coefficient of a function on the finest level, by vertex: scaling coefficients of level 0 at base
    /// vertices, wavelet coefficients at all others.
    pub fn analyse(&self, values: &[[f64; 3]], k: Option<usize>, wrong: Option<WrongWeight>) -> Matrix {
        let mut coefficients: Matrix = values.iter().map(|value| value.to_vec()).collect();
        for level in (0..self.counts.len() - 1).rev() {
            let finer = coefficients[..self.counts[level + 1]].to_vec();
            let solved = solve(self.synthesis_matrix(level, k, wrong), finer);
            coefficients.splice(..solved.len(), solved);
        }
        coefficients
    }
}

/// Solves `matrix · x = right` for all columns of `right` by Gaussian elimination with row pivoting.
fn solve(mut matrix: Matrix, mut right: Matrix) -> Matrix {
    let count = matrix.len();
    for column in 0..count {
        let pivot = (column..count)
            .max_by(|&a, &b| matrix[a][column].abs().total_cmp(&matrix[b][column].abs()))
            .expect("a row is left");
        assert!(matrix[pivot][column].abs() > 1e-9, "the matrix can be inverted");
        matrix.swap(column, pivot);
        right.swap(column, pivot);
        for row in column + 1..count {
            let factor = matrix[row][column] / matrix[column][column];
            if factor != 0.0 {
                let (above, below) = matrix.split_at_mut(row);
                subtract(&mut below[0][column..], &above[column][column..], factor);
                let (above, below) = right.split_at_mut(row);
                subtract(&mut below[0], &above[column], factor);
            }
        }
    }
    for row in (0..count).rev() {
        let (above, below) = right.split_at_mut(row + 1);
        for (column, solved) in (row + 1..count).zip(below.iter()) {
            subtract(&mut above[row], solved, matrix[row][column]);
        }
        above[row].iter_mut().for_each(|x| *x /= matrix[row][row]);
    }
    right
}

fn subtract(from: &mut [f64], what: &[f64], times: f64) {
    from.iter_mut().zip(what).for_each(|(a, b)| *a -= times * b);
}
