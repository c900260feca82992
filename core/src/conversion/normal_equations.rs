//! The linear system of a fit: symmetric, one 3 × 3 block for each vertex and each pair of neighbours.
//!
//! Guarantees: sums are taken in an order that does not depend on threads.

use glam::DVec3;
use rayon::prelude::*;

/// Rows one thread takes at a time, and the length of the partial sums of inner products.
const CHUNK: usize = 2048;

/// Iterations between two questions whether to go on.
const UNASKED: usize = 8;

/// A symmetric 3 × 3 matrix: xx, xy, xz, yy, yz, zz.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Symmetric([f64; 6]);

impl Symmetric {
    /// `across` along the unit vector `n`, `along` in the plane perpendicular to it.
    pub(super) fn about(n: DVec3, across: f64, along: f64) -> Self {
        let d = across - along;
        Self([
            along + d * n.x * n.x,
            d * n.x * n.y,
            d * n.x * n.z,
            along + d * n.y * n.y,
            d * n.y * n.z,
            along + d * n.z * n.z,
        ])
    }

    /// Adds `scale` times another.
    pub(super) fn add(&mut self, other: &Self, scale: f64) {
        self.0.iter_mut().zip(&other.0).for_each(|(a, b)| *a += b * scale);
    }

    /// The product with a vector.
    pub(super) fn times(&self, v: DVec3) -> DVec3 {
        let [xx, xy, xz, yy, yz, zz] = self.0;
        DVec3::new(
            xx * v.x + xy * v.y + xz * v.z,
            xy * v.x + yy * v.y + yz * v.z,
            xz * v.x + yz * v.y + zz * v.z,
        )
    }

    fn inverse(&self) -> Self {
        let [a, b, c, d, e, f] = self.0;
        let minors =
            [d * f - e * e, c * e - b * f, b * e - c * d, a * f - c * c, b * c - a * e, a * d - b * b];
        let determinant = a * minors[0] + b * minors[1] + c * minors[2];
        if determinant > 0.0 { Self(minors.map(|m| m / determinant)) } else { Self::default() }
    }
}

/// What the samples on one face add to the system: blocks of its corners (00, 01, 02, 11, 12, 22) and right sides.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct FaceBlocks {
    pub(super) blocks: [Symmetric; 6],
    pub(super) right: [DVec3; 3],
}

/// Which of the six blocks joins two corners.
const PAIR: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];

/// Who is next to whom, for a fixed list of faces.
#[derive(Debug)]
pub(super) struct Pattern {
    /// Where each vertex's entries begin.
    starts: Vec<u32>,
    /// Neighbours, ascending.
    neighbours: Vec<u32>,
    /// Where each vertex's corners begin.
    corner_starts: Vec<u32>,
    /// Half-edge numbers `3 face + corner`, ascending.
    corners: Vec<u32>,
    faces: Vec<[u32; 3]>,
}

impl Pattern {
    /// The pattern of a list of faces. Linear.
    pub(super) fn new(vertices: usize, faces: &[[u32; 3]]) -> Self {
        let mut corner_starts = vec![0u32; vertices + 1];
        faces.iter().flatten().for_each(|&v| corner_starts[v as usize + 1] += 1);
        (0..vertices).for_each(|v| corner_starts[v + 1] += corner_starts[v]);
        let mut at = corner_starts.clone();
        let mut corners = vec![0; 3 * faces.len()];
        for (corner, &v) in faces.iter().flatten().enumerate() {
            corners[at[v as usize] as usize] = corner as u32;
            at[v as usize] += 1;
        }
        let mut starts = vec![0u32];
        let mut neighbours = Vec::with_capacity(6 * vertices);
        let mut near = Vec::new();
        for v in 0..vertices {
            near.clear();
            let range = corner_starts[v] as usize..corner_starts[v + 1] as usize;
            let others = corners[range].iter().flat_map(|&c| faces[c as usize / 3]);
            near.extend(others.filter(|&w| w as usize != v));
            near.sort_unstable();
            near.dedup();
            neighbours.extend_from_slice(&near);
            starts.push(neighbours.len() as u32);
        }
        Self { starts, neighbours, corner_starts, corners, faces: faces.to_vec() }
    }

    /// The vertices next to one, ascending.
    pub(super) fn neighbours(&self, vertex: usize) -> &[u32] {
        &self.neighbours[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// The corners at a vertex as `3 face + corner`.
    pub(super) fn corners(&self, vertex: usize) -> &[u32] {
        &self.corners[self.corner_starts[vertex] as usize..self.corner_starts[vertex + 1] as usize]
    }

    /// The faces.
    pub(super) fn faces(&self) -> &[[u32; 3]] {
        &self.faces
    }

    /// The number of vertices.
    pub(super) fn vertices(&self) -> usize {
        self.starts.len() - 1
    }
}

/// A system over a pattern.
#[derive(Debug)]
pub(super) struct System<'p> {
    pattern: &'p Pattern,
    diagonal: Vec<Symmetric>,
    beside: Vec<Symmetric>,
    right: Vec<DVec3>,
}

impl<'p> System<'p> {
    /// Gathers what each face contributes, and what `own` adds at each vertex: a diagonal block and a right side.
    pub(super) fn assemble(
        pattern: &'p Pattern,
        faces: &[FaceBlocks],
        own: impl Fn(usize, &Symmetric) -> (Symmetric, DVec3) + Sync,
    ) -> Self {
        let rows: Vec<(Symmetric, DVec3)> = (0..pattern.vertices())
            .into_par_iter()
            .with_min_len(CHUNK)
            .map(|v| {
                let (mut diagonal, mut right) = (Symmetric::default(), DVec3::ZERO);
                for &corner in pattern.corners(v) {
                    let (face, k) = (&faces[corner as usize / 3], corner as usize % 3);
                    diagonal.add(&face.blocks[PAIR[k][k]], 1.0);
                    right += face.right[k];
                }
                let (more, pull) = own(v, &diagonal);
                diagonal.add(&more, 1.0);
                (diagonal, right + pull)
            })
            .collect();
        let mut beside = vec![Symmetric::default(); pattern.neighbours.len()];
        let mut parts: Vec<(usize, &mut [Symmetric])> = Vec::with_capacity(pattern.vertices());
        let mut rest = beside.as_mut_slice();
        for v in 0..pattern.vertices() {
            let (row, after) = rest.split_at_mut(pattern.neighbours(v).len());
            parts.push((v, row));
            rest = after;
        }
        parts.into_par_iter().with_min_len(CHUNK).for_each(|(v, row)| {
            for &corner in pattern.corners(v) {
                let (f, k) = (corner as usize / 3, corner as usize % 3);
                for other in [(k + 1) % 3, (k + 2) % 3] {
                    let w = pattern.faces[f][other];
                    let at =
                        pattern.neighbours(v).binary_search(&w).expect("corners of a face are neighbours");
                    row[at].add(&faces[f].blocks[PAIR[k][other]], 1.0);
                }
            }
        });
        let (diagonal, right) = rows.into_iter().unzip();
        Self { pattern, diagonal, beside, right }
    }

    /// Conjugate gradients from 0, preconditioned by the inverted diagonal blocks, until the residual has fallen by
    /// `reduction` or after `iterations`. `None` if `go_on`, asked now and then, said no.
    pub(super) fn solve(
        &self,
        iterations: usize,
        reduction: f64,
        go_on: &dyn Fn() -> bool,
    ) -> Option<Vec<DVec3>> {
        let n = self.right.len();
        let inverse: Vec<Symmetric> = self.diagonal.par_iter().map(Symmetric::inverse).collect();
        let mut x = vec![DVec3::ZERO; n];
        let mut r = self.right.clone();
        let mut z: Vec<DVec3> = r.par_iter().zip(&inverse).map(|(r, m)| m.times(*r)).collect();
        let mut p = z.clone();
        let mut energy = inner(&r, &z);
        let goal = energy * reduction * reduction;
        let mut product = vec![DVec3::ZERO; n];
        for iteration in 0..iterations {
            if iteration % UNASKED == 0 && !go_on() {
                return None;
            }
            if energy.is_nan() || energy <= goal || energy <= 0.0 {
                break;
            }
            self.multiply(&p, &mut product);
            let bend = inner(&p, &product);
            if bend.is_nan() || bend <= 0.0 {
                break;
            }
            let step = energy / bend;
            x.par_iter_mut().zip(&p).with_min_len(CHUNK).for_each(|(x, p)| *x += *p * step);
            r.par_iter_mut().zip(&product).with_min_len(CHUNK).for_each(|(r, q)| *r -= *q * step);
            z.par_iter_mut()
                .zip(&r)
                .zip(&inverse)
                .with_min_len(CHUNK)
                .for_each(|((z, r), m)| *z = m.times(*r));
            let next = inner(&r, &z);
            let along = next / energy;
            energy = next;
            p.par_iter_mut().zip(&z).with_min_len(CHUNK).for_each(|(p, z)| *p = *z + *p * along);
        }
        Some(x)
    }

    fn multiply(&self, x: &[DVec3], into: &mut [DVec3]) {
        into.par_iter_mut().enumerate().with_min_len(CHUNK).for_each(|(v, y)| {
            let range = self.pattern.starts[v] as usize..self.pattern.starts[v + 1] as usize;
            let mut sum = self.diagonal[v].times(x[v]);
            for (block, &w) in self.beside[range.clone()].iter().zip(&self.pattern.neighbours[range]) {
                sum += block.times(x[w as usize]);
            }
            *y = sum;
        });
    }
}

/// The inner product, summed in fixed chunks.
fn inner(a: &[DVec3], b: &[DVec3]) -> f64 {
    let chunks: Vec<f64> = a
        .par_chunks(CHUNK)
        .zip(b.par_chunks(CHUNK))
        .map(|(a, b)| a.iter().zip(b).map(|(a, b)| a.dot(*b)).sum())
        .collect();
    chunks.iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_system_is_solved() {
        let mesh = crate::mesh::shapes::subdivide(&crate::mesh::shapes::octahedron(), 3);
        let pattern = Pattern::new(mesh.positions.len(), &mesh.faces);
        // Each face pulls its centre and its corners to a shifted place.
        let shift = DVec3::new(0.1, -0.2, 0.3);
        let metric = Symmetric::about(DVec3::Z, 1.0, 0.3);
        let mut face = FaceBlocks::default();
        for weights in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0 / 3.0; 3]] {
            for a in 0..3 {
                face.right[a] += metric.times(shift) * weights[a];
                for b in a..3 {
                    face.blocks[PAIR[a][b]].add(&metric, weights[a] * weights[b]);
                }
            }
        }
        let faces = vec![face; mesh.faces.len()];
        let system = System::assemble(&pattern, &faces, |_, _| (Symmetric::default(), DVec3::ZERO));
        let x = system.solve(100, 1e-12, &|| true).expect("it was not given up");
        assert!(x.iter().all(|x| x.distance(shift) < 1e-9));
    }
}
