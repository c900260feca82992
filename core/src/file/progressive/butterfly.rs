//! What the butterfly scheme has at the odd vertices of a level, less the means of their parents: their **bends**.
//!
//! Based on: Dyn, Levin, Gregory, "A Butterfly Subdivision Scheme for Surface Interpolation with Tension Control", ACM
//! Transactions on Graphics 9(2), 1990; Zorin, Schröder, Sweldens, "Interpolating Subdivision for Meshes with Arbitrary
//! Topology", SIGGRAPH 1996, for its four-point rule along boundaries and creases.
//!
//! With `F` of an edge (u, w) between the faces (u, w, a) and (w, u, b) the sum `a + b − u − w`, the bend is `−1/16` of the
//! sum of `F` over the edges that form a face with the vertex's own. On a **curve**, an edge of the boundary or a sharp one,
//! `F` is zero, and a vertex there has `−1/16` of the second differences along the curve at its parents, zero where not
//! exactly two edges of the curve meet. So nothing is smoothed across a curve. Part of the file format; sums are modulo
//! 2^32, exact within [`crate::surface::LIMIT`].

use crate::hierarchy::{BaseMesh, Hierarchy, Layout, Level, row_slots};
use crate::memory::Buffer;
use crate::surface::Vector;
use crate::wavelet::lifting::{minus, plus};
use rayon::prelude::*;

/// What is made of curves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Curves {
    /// As above.
    Kept,
    /// `F` is zero on the boundary, and that is all.
    Ignored,
}

impl Curves {
    fn hold(self, base: &BaseMesh, edge: u32) -> bool {
        base.is_boundary_edge(edge) || self == Curves::Kept && base.is_sharp(edge)
    }
}

/// The bends of the odd vertices of a level, from positions of `M^j` by slot. `O(n_j)`, in parallel over faces.
pub(super) fn bends(
    hierarchy: &Hierarchy,
    level: Level,
    positions: &[Vector],
    curves: Curves,
) -> Buffer<Vector> {
    let coarse = hierarchy.layout(level);
    let n = coarse.segments() as usize;
    let mut bends = Buffer::zeroed(coarse.odd_len() as usize);
    let (on_edges, mut rest) = bends.split_at_mut(n * coarse.base().edges().len());
    let inside = (0..coarse.base().faces().len())
        .map(|_| rest.split_off_mut(..3 * n * (n - 1) / 2).expect("every face has as many"))
        .collect();
    let copy = |left: &mut &mut [Vector], _, row: &[Vector]| {
        left.split_off_mut(..row.len()).expect("as many as odd vertices").copy_from_slice(row);
    };
    on_edges.copy_from_slice(&by_rows(hierarchy, level, (positions, curves), inside, copy));
    bends
}

/// Gives the bends inside each face to what is there for the face, row after row of `M^{j+1}`: rows of even number have
/// odd vertices at every other place, the others at all. Returns those on base edges, n an edge from its low end. `O(n_j)`,
/// in parallel over faces.
pub(super) fn by_rows<T: Send>(
    hierarchy: &Hierarchy,
    level: Level,
    (positions, curves): (&[Vector], Curves),
    faces: Vec<T>,
    take: impl Fn(&mut T, usize, &[Vector]) + Sync,
) -> Vec<Vector> {
    let coarse = hierarchy.layout(level);
    let (base, n) = (coarse.base(), coarse.segments() as usize);
    let crossed = across_base_edges(coarse, positions, curves);
    let mut beside = vec![[0; 3]; 3 * n * base.faces().len()];
    let tasks = faces.into_par_iter().zip(beside.par_chunks_mut(3 * n)).enumerate();
    tasks.with_min_len(1024 / (n * n) + 1).for_each_init(
        Rows::default,
        |rows, (face, (mut inside, beside))| {
            let face = Face { coarse, positions, crossed: &crossed, face: face as u32 };
            rows.of_face(&face, beside, |row, bends| take(&mut inside, row, bends));
        },
    );
    let mut on_edges = vec![[0; 3]; n * base.edges().len()];
    for (edge, on_edge) in on_edges.chunks_mut(n).enumerate() {
        let edge = edge as u32;
        if curves == Curves::Kept && curves.hold(base, edge) {
            along_curve(coarse, positions, edge, on_edge);
            continue;
        }
        for side in base.sides(edge).into_iter().flatten() {
            let sums = &beside[3 * n * side.face as usize + n * usize::from(side.k)..][..n];
            let forwards = runs_from_low_end(base, side.face, side.k);
            for (s, &sum) in sums.iter().enumerate() {
                let bend = &mut on_edge[if forwards { s } else { n - 1 - s }];
                *bend = plus(*bend, sum);
            }
        }
        on_edge.iter_mut().for_each(|sum| *sum = sixteenth(*sum));
    }
    on_edges
}

/// `−1/16` of a sum, rounded.
fn sixteenth(sum: Vector) -> Vector {
    sum.map(|x| 8i32.wrapping_sub(x) >> 4)
}

fn runs_from_low_end(base: &BaseMesh, face: u32, k: u8) -> bool {
    let corner = base.faces()[face as usize][usize::from(k)];
    base.edges()[base.face_edges(face)[usize::from(k)] as usize][0] == corner
}

/// `a + b − u − w`.
fn flap(a: Vector, b: Vector, u: Vector, w: Vector) -> Vector {
    minus(plus(a, b), plus(u, w))
}

/// `F` of the edges of `M^j` on base edges, n an edge from its low end.
fn across_base_edges(coarse: &Layout, positions: &[Vector], curves: Curves) -> Vec<Vector> {
    let (base, n) = (coarse.base(), coarse.segments());
    let mut crossed = vec![[0; 3]; n as usize * base.edges().len()];
    for (edge, crossed) in crossed.chunks_mut(n as usize).enumerate() {
        let edge = edge as u32;
        let [Some(one), Some(other)] = base.sides(edge) else { continue };
        if curves.hold(base, edge) {
            continue;
        }
        let end = |t: u32| positions[coarse.slot(coarse.along_edge(edge, t)).index()];
        for (t, crossed) in (0..n).zip(crossed) {
            let [a, b] = [one, other].map(|side| {
                let k = usize::from(side.k);
                let s = if runs_from_low_end(base, side.face, side.k) { t } else { n - 1 - t };
                let mut apex = [0; 3];
                (apex[k], apex[(k + 1) % 3], apex[(k + 2) % 3]) = (n - 1 - s, s, 1);
                positions[coarse.slot(coarse.site_at(side.face, apex)).index()]
            });
            *crossed = flap(a, b, end(t), end(t + 1));
        }
    }
    crossed
}

/// The bends of the odd vertices on a base edge that is a curve.
fn along_curve(coarse: &Layout, positions: &[Vector], edge: u32, on_edge: &mut [Vector]) {
    let (base, n) = (coarse.base(), coarse.segments());
    let at = |edge: u32, t: u32| positions[coarse.slot(coarse.along_edge(edge, t)).index()];
    let mut differences: Vec<Vector> =
        (1..n).map(|t| flap(at(edge, t - 1), at(edge, t + 1), at(edge, t), at(edge, t))).collect();
    let [low, high] = base.edges()[edge as usize];
    let of_end = |vertex: u32| {
        let next = next_on_curve(base, edge, vertex);
        next.map_or([0; 3], |next| {
            let [own, other] = [edge, next].map(|e| {
                let [from, _] = base.edges()[e as usize];
                at(e, if from == vertex { 1 } else { n - 1 })
            });
            let v = positions[vertex as usize];
            flap(own, other, v, v)
        })
    };
    differences.insert(0, of_end(low));
    differences.push(of_end(high));
    for (bend, pair) in on_edge.iter_mut().zip(differences.windows(2)) {
        *bend = sixteenth(plus(pair[0], pair[1]));
    }
}

/// The other edge of the curve at an end of one, if there is exactly one other.
fn next_on_curve(base: &BaseMesh, edge: u32, vertex: u32) -> Option<u32> {
    let mut others: Vec<u32> = Vec::new();
    for &(face, corner) in &base.fan(vertex).corners {
        let edges = base.face_edges(face);
        for e in [edges[usize::from(corner)], edges[(usize::from(corner) + 2) % 3]] {
            if e != edge && Curves::Kept.hold(base, e) && !others.contains(&e) {
                others.push(e);
            }
        }
    }
    if others.len() == 1 { others.pop() } else { None }
}

/// A face of the base mesh and what is around it.
struct Face<'a> {
    coarse: &'a Layout,
    positions: &'a [Vector],
    crossed: &'a [Vector],
    face: u32,
}

impl Face<'_> {
    fn read(&self, r: u32, slots: &mut Vec<u32>, row: &mut Vec<Vector>) {
        row.clear();
        if r <= self.coarse.segments() {
            row_slots(self.coarse, self.face, r, slots);
            row.extend(slots.iter().map(|&slot| self.positions[slot as usize]));
        }
    }

    /// `F` of the edges of `M^j` along side k, from corner k.
    fn side(&self, k: u8) -> impl Fn(usize) -> Vector {
        let (base, n) = (self.coarse.base(), self.coarse.segments() as usize);
        let crossed = &self.crossed[n * base.face_edges(self.face)[usize::from(k)] as usize..][..n];
        let forwards = runs_from_low_end(base, self.face, k);
        move |s| crossed[if forwards { s } else { n - 1 - s }]
    }
}

/// `F` of the edges around a row r of a face's grid, by place: along it, up from its vertices, and down to the right of them.
#[derive(Default)]
struct Rows {
    positions: [Vec<Vector>; 3],
    slots: Vec<u32>,
    along: Vec<Vector>,
    along_above: Vec<Vector>,
    up: Vec<Vector>,
    down: Vec<Vector>,
    up_below: Vec<Vector>,
    down_below: Vec<Vector>,
    /// What is handed on.
    bends: Vec<Vector>,
}

impl Rows {
    /// Calls back with the bends inside a face, row after row; and of the odd vertices on its sides writes what this face has of
    /// their sums, n a side.
    fn of_face(&mut self, face: &Face, beside: &mut [Vector], mut take: impl FnMut(usize, &[Vector])) {
        let n = face.coarse.segments() as usize;
        let [first, second, third] = [0, 1, 2].map(|k| face.side(k));
        let Self { positions, slots, along, along_above, up, down, up_below, down_below, bends } = self;
        (0..2).for_each(|r| face.read(r as u32, slots, &mut positions[r]));
        along.clear();
        along.extend((0..n).map(first));
        for r in 0..n {
            face.read(r as u32 + 2, slots, &mut positions[2]);
            let [p, q, above] = &*positions;
            let len = n - r;
            let f = |a: &[Vector], b: &[Vector], u: &[Vector], w: &[Vector], out: &mut Vec<Vector>| {
                let sums = a.iter().zip(b).zip(u.iter().zip(w));
                out.extend(sums.map(|((&a, &b), (&u, &w))| flap(a, b, u, w)));
            };
            along_above.clear();
            f(&above[..len - 1], &p[1..], &q[..len - 1], &q[1..], along_above);
            up.clear();
            up.push(third(n - 1 - r));
            f(&p[2..], &q[..len - 1], &p[1..len], &q[1..], up);
            down.clear();
            f(&p[..len - 1], &q[1..], &p[1..len], &q[..len - 1], down);
            down.push(second(r));

            if r > 0 {
                bends.clear();
                bends
                    .extend((0..len).map(|i| {
                        sixteenth(plus(plus(up[i], down[i]), plus(down_below[i], up_below[i + 1])))
                    }));
                take(2 * r, bends);
            }
            if len > 1 {
                bends.resize(2 * (len - 1), [0; 3]);
                for (i, pair) in bends.chunks_mut(2).enumerate() {
                    pair[0] = sixteenth(plus(plus(along[i], up[i]), plus(along_above[i], up[i + 1])));
                    pair[1] = sixteenth(plus(plus(along[i + 1], down[i + 1]), plus(along_above[i], down[i])));
                }
                take(2 * r + 1, bends);
            }
            if r == 0 {
                (0..n).for_each(|i| beside[i] = plus(up[i], down[i]));
            }
            beside[n + r] = plus(along[len - 1], up[len - 1]);
            beside[3 * n - 1 - r] = plus(along[0], down[0]);

            positions.rotate_left(1);
            std::mem::swap(along, along_above);
            std::mem::swap(up, up_below);
            std::mem::swap(down, down_below);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::{Odd, Slot};
    use crate::mesh::shapes;
    use std::collections::{BTreeMap, BTreeSet};
    use std::sync::Arc;

    /// Read off the definition, one vertex at a time.
    fn plainly(hierarchy: &Hierarchy, level: Level, positions: &[Vector], curves: Curves) -> Vec<Vector> {
        let (coarse, base) = (hierarchy.layout(level), hierarchy.base());
        let mut opposite: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        let sorted = |a: u32, b: u32| [a.min(b), a.max(b)];
        for [a, b, c] in hierarchy.triangles(level) {
            for (u, w, o) in [(a, b, c), (b, c, a), (c, a, b)] {
                opposite.entry(sorted(u, w)).or_default().push(o);
            }
        }
        let mut curve: BTreeSet<[u32; 2]> = BTreeSet::new();
        for edge in (0..base.edges().len() as u32).filter(|&e| base.is_boundary_edge(e) || base.is_sharp(e)) {
            for t in 0..coarse.segments() {
                let [u, w] = [t, t + 1].map(|t| coarse.slot(coarse.along_edge(edge, t)).0);
                curve.insert(sorted(u, w));
            }
        }
        let f = |u: u32, w: u32| match opposite[&sorted(u, w)][..] {
            [a, b] if curves == Curves::Ignored || !curve.contains(&sorted(u, w)) => [0, 1, 2].map(|c| {
                [a, b].map(|v| positions[v as usize][c]).iter().sum::<i32>()
                    - [u, w].map(|v| positions[v as usize][c]).iter().sum::<i32>()
            }),
            _ => [0; 3],
        };
        let second = |v: u32| {
            let ends: Vec<u32> = curve
                .iter()
                .filter_map(|&[a, b]| (a == v).then_some(b).or_else(|| (b == v).then_some(a)))
                .collect();
            match ends[..] {
                [a, b] => [0, 1, 2].map(|c| {
                    positions[a as usize][c] + positions[b as usize][c] - 2 * positions[v as usize][c]
                }),
                _ => [0; 3],
            }
        };
        let of_odd = |odd: u32| {
            let [u, w] = coarse.parents(coarse.odd_site(Odd(odd))).map(|site| coarse.slot(site).0);
            let mut sums: Vec<Vector> = Vec::new();
            if curves == Curves::Kept && curve.contains(&sorted(u, w)) {
                sums.extend([second(u), second(w)]);
            } else {
                for &o in &opposite[&sorted(u, w)] {
                    sums.extend([f(u, o), f(w, o)]);
                }
            }
            [0, 1, 2].map(|c| (8 - sums.iter().map(|x| x[c]).sum::<i32>()).div_euclid(16))
        };
        (0..coarse.odd_len()).map(of_odd).collect()
    }

    #[test]
    fn rows_give_what_the_definition_says() {
        for (name, mesh) in shapes::awkward() {
            for sharp in [0, 1, 4] {
                let marks: Vec<[u32; 2]> = mesh.faces.iter().take(sharp).map(|f| [f[0], f[1]]).collect();
                let base =
                    BaseMesh::new(mesh.positions.len() as u32, mesh.faces.clone(), &marks).expect(name);
                let hierarchy = Hierarchy::new(Arc::new(base), Level(4)).expect("small");
                for level in (0..4).map(Level) {
                    let count = hierarchy.layout(level).len();
                    let number = |k: u32| (k.wrapping_mul(0x9e37_79b9) >> 8) as i32 - (1 << 23);
                    let positions: Vec<Vector> =
                        (0..count).map(|v| [3 * v, 3 * v + 1, 3 * v + 2].map(number)).collect();
                    for curves in [Curves::Kept, Curves::Ignored] {
                        let found = bends(&hierarchy, level, &positions, curves);
                        let wanted = plainly(&hierarchy, level, &positions, curves);
                        assert!(found[..] == wanted, "{name}, {sharp} sharp, level {}, {curves:?}", level.0);
                    }
                }
            }
        }
    }

    /// A quadratic surface over the regular lattice has the bends of its second derivatives: butterfly is exact for it.
    #[test]
    fn a_parabola_is_continued() {
        let mesh = shapes::triangle();
        let base = BaseMesh::new(3, mesh.faces, &[]).expect("a base mesh");
        let hierarchy = Hierarchy::new(Arc::new(base), Level(5)).expect("small");
        let height = |layout: &Layout, slot: u32| {
            let (_, [_, i, r]) = layout.chart(layout.site(Slot(slot)));
            let scale = 64 / layout.segments() as i32;
            let (x, y) = (scale * i as i32, scale * r as i32);
            [x, y, 3 * x * x + 2 * x * y - y * y]
        };
        let level = Level(4);
        let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(Level(5)));
        let positions: Vec<Vector> = (0..coarse.len()).map(|slot| height(coarse, slot)).collect();
        let bends = bends(&hierarchy, level, &positions, Curves::Kept);
        let mut inner = 0;
        for odd in (0..coarse.odd_len()).map(Odd) {
            let site = coarse.odd_site(odd);
            let (_, b) = fine.chart(site);
            if b.iter().any(|&x| x < 4) {
                continue;
            }
            inner += 1;
            let [u, w] = coarse.parents(site).map(|site| positions[coarse.slot(site).index()]);
            let mean = [0, 1, 2].map(|c| (u[c] + w[c]) >> 1);
            assert_eq!(plus(mean, bends[odd.index()]), height(fine, fine.slot(site).0));
        }
        assert!(inner > 10);
    }
}
