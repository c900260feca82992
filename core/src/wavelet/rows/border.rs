//! What lies around one base face at level j + 1: its edges, beyond each a few lines of the face across it, and beyond each
//! corner the points near it of the faces that share only the corner.
//!
//! Collected once a face, row by row of the face across, so that what lies in one line of the cache is fetched once; rows
//! of a window then find it in small arrays, in the order of their columns.

use super::chart::Chart;
use super::corner::Corner;
use super::points::Points;
use super::prefetch::prefetch;
use super::window::HALO;
use pulp::Arch;
use std::ops::Range;

/// Lines per edge: the edge itself, and as many steps of level j + 1 beyond it as any stencil reaches.
const LINES: usize = 2 * HALO as usize + 1;

/// So many rows before it is needed a part of a row is fetched.
const AHEAD: i32 = 16;

/// Values on and beyond the edges of a face, in the order of the rows `ρ` and columns of its unfolded grid: beyond edge 0
/// `−ρ` by column, so many rows as there are lines; at edges 1 and 2 so many values a row.
pub(super) struct Border<const N: usize> {
    n: usize,
    edges: [Vec<[i32; N]>; 3],
    corners: [Corner<N>; 3],
}

/// Columns of a row from `first`.
#[derive(Clone, Copy)]
pub(super) struct Run<'a, const N: usize> {
    pub(super) first: i32,
    pub(super) values: &'a [[i32; N]],
}

impl<const N: usize> Run<'_, N> {
    /// No columns, left of all others.
    pub(super) const NONE: Self = Run { first: i32::MIN, values: &[] };

    fn columns(&self) -> Range<i32> {
        self.first..self.first + self.values.len() as i32
    }
}

impl<const N: usize> Border<N> {
    /// Room for the faces of a level j with `n` segments.
    pub(super) fn new(n: u32) -> Self {
        let n = 2 * n as usize;
        Self {
            n,
            edges: [(); 3].map(|()| vec![[0; N]; LINES * (n + 1)]),
            corners: [0, 1, 2].map(Corner::new),
        }
    }

    /// Collects what lies around a face.
    pub(super) fn collect(&mut self, arch: Arch, chart: &Chart, points: &Points<N>) {
        self.corners.iter_mut().for_each(|corner| corner.collect(chart, points));
        let n = self.n as i32;
        for (k, values) in self.edges.iter_mut().enumerate() {
            // Where the point `h` steps beyond the edge, `p` from its end, stands: a constant and a multiple of each.
            let lines = LINES as i32;
            let [start, by_p, by_h] = match k {
                0 => [n, -1, n + 1],
                1 => [n * lines, -lines, 1],
                _ => [lines - 1, lines, lines - 1],
            };
            let mut put = |p: i32, h: i32, value| values[(start + by_p * p + by_h * h) as usize] = value;
            let (edge, forwards) = chart.edges[k];
            let line = points.edge(edge);
            (1..n).for_each(|p| put(p, 0, line.at(if forwards { n - p } else { p })));
            let Some(side) = chart.across[k] else {
                for p in 1..n - 1 {
                    (1..lines.min(n - p)).for_each(|h| put(p, h, [0; N]));
                }
                continue;
            };
            match side.k {
                0 => {
                    for h in 1..lines.min(n - 1) {
                        let row = points.row(side.face, h as u32);
                        (1..n - h).for_each(|p| put(p, h, row.at(p)));
                    }
                }
                // Of each row only its end is needed, or only its beginning.
                1 => {
                    for p in 1..n - 1 {
                        if p + AHEAD < n - 1 {
                            let row = points.row(side.face, (p + AHEAD) as u32);
                            prefetch(arch, row.last(lines as usize));
                        }
                        let row = points.row(side.face, p as u32);
                        (1..lines.min(n - p)).for_each(|h| put(p, h, row.at(n - h - p)));
                    }
                }
                _ => {
                    for q in 1..n - 1 {
                        if q + AHEAD < n - 1 {
                            let row = points.row(side.face, (q + AHEAD) as u32);
                            prefetch(arch, row.first(lines as usize));
                        }
                        let row = points.row(side.face, q as u32);
                        (1..lines.min(n - q)).for_each(|h| put(n - h - q, h, row.at(h)));
                    }
                }
            }
        }
    }

    /// What stands to the left and to the right of row `ρ` of the face, edges included, where neither is near a corner: columns
    /// from `−2·HALO` to 0, and as many from `n − ρ` on.
    #[inline]
    pub(super) fn sides(&self, rho: i32) -> Option<[&[[i32; N]; LINES]; 2]> {
        let lines = LINES as i32;
        if !(lines..=self.n as i32 - lines).contains(&rho) {
            return None;
        }
        let at = rho as usize * LINES;
        let [left, right] = [&self.edges[2], &self.edges[1]].map(|edge| edge[at..].first_chunk());
        Some([left?, right?])
    }

    /// Calls back for columns `from..=to` of row `ρ` of the unfolded grid with their values, of the face itself as `inside` has
    /// them. Zero beyond the boundary and around extraordinary corners, over which no stencil reaches.
    #[inline(never)]
    pub(super) fn row(
        &self,
        rho: i32,
        [from, to]: [i32; 2],
        inside: impl Fn(i32) -> [i32; N],
        mut found: impl FnMut(i32, [i32; N]),
    ) {
        let n = self.n as i32;
        let within = |i: i32| i > 0 && rho > 0 && i + rho < n;
        let between = |i: i32| if within(i) { inside(i) } else { [0; N] };
        let mut next = from;
        for run in self.runs(rho) {
            let columns = run.columns();
            for i in next..columns.start.min(to + 1) {
                found(i, between(i));
            }
            next = next.max(columns.start);
            for i in next..columns.end.min(to + 1) {
                found(i, run.values[(i - columns.start) as usize]);
            }
            next = next.max(columns.end);
        }
        (next..=to).for_each(|i| found(i, between(i)));
    }

    /// The runs of row `ρ`, from left to right.
    fn runs(&self, rho: i32) -> [Run<'_, N>; 4] {
        let (n, lines) = (self.n as i32, LINES as i32);
        if rho <= -lines || rho >= n {
            return [self.corners[2].run(n, rho), Run::NONE, Run::NONE, Run::NONE];
        }
        let run = |edge: usize, columns: Range<i32>, first: i32| {
            let at = first as usize;
            Run { first: columns.start, values: &self.edges[edge][at..at + columns.len()] }
        };
        let [before, after] = [0, 1].map(|corner| self.corners[corner].run(n, rho));
        if rho <= 0 {
            let from = (1 - rho).min(n);
            return [before, run(0, from..n, -rho * (n + 1) + from), Run::NONE, after];
        }
        let from = (1 - rho).max(1 - lines);
        let to = n.min(n - rho + lines);
        [before, run(2, from..1, (rho + 1) * lines - 1 + from), run(1, n - rho..to, rho * lines), after]
    }
}
