//! What lies around one base face at level j + 1: its edges, and beyond each a few lines of the face across it.
//!
//! Collected once a face, row by row of the face across, so that what lies in one line of the cache is fetched once; rows
//! of a window then find it in one small array.

use super::chart::Chart;
use super::window::HALO;
use crate::hierarchy::Site;
use std::ops::Range;

/// Lines per edge: the edge itself, and as many steps of level j + 1 beyond it as any stencil reaches.
const LINES: usize = 2 * HALO as usize + 1;

/// Values on and beyond the edges of a face: for every step along an edge, counted from its end, so many as there are lines,
/// the edge's own first.
pub(super) struct Border<const N: usize>([Vec<[i32; N]>; 3]);

/// A run of columns of a row, and where their values stand at an edge: a constant and a multiple of the column.
struct Run {
    columns: Range<i32>,
    edge: usize,
    at: i32,
    step: i32,
}

impl Run {
    const NONE: Run = Run { columns: i32::MIN..i32::MIN, edge: 0, at: 0, step: 0 };
}

impl<const N: usize> Border<N> {
    /// Room for the faces of a level j with `n` segments.
    pub(super) fn new(n: u32) -> Self {
        Self([(); 3].map(|()| vec![[0; N]; LINES * (2 * n as usize + 1)]))
    }

    /// Collects what lies around a face.
    pub(super) fn collect(&mut self, chart: &Chart, value: impl Fn(Site) -> [i32; N]) {
        let n = 2 * chart.n() as u32;
        for (k, values) in self.0.iter_mut().enumerate() {
            let (edge, forwards) = chart.edges[k];
            let mut put = |p: u32, h: u32, site| values[p as usize * LINES + h as usize] = value(site);
            for p in 1..n {
                put(p, 0, Site::Edge { edge, t: if forwards { n - p } else { p } });
            }
            let Some(side) = chart.across[k] else { continue };
            let face = side.face;
            let lines = LINES as u32;
            if side.k == 0 {
                for h in 1..lines.min(n - 1) {
                    (1..n - h).for_each(|p| put(p, h, Site::Face { face, i: p, r: h }));
                }
                continue;
            }
            for p in 1..n - 1 {
                for h in 1..lines.min(n - p) {
                    let q = n - h - p;
                    let (i, r) = if side.k == 1 { (q, p) } else { (h, q) };
                    put(p, h, Site::Face { face, i, r });
                }
            }
        }
    }

    /// Calls back for columns `from..=to` of row `ρ` of the unfolded grid with their values: of the face itself as `inside`
    /// has them, of what is neither inside, on an edge nor beyond exactly one as `value` has them. Zero beyond the boundary
    /// and around extraordinary corners, over which no stencil reaches.
    #[inline(always)]
    pub(super) fn row(
        &self,
        chart: &Chart,
        rho: i32,
        [from, to]: [i32; 2],
        inside: impl Fn(i32) -> [i32; N],
        value: impl Fn(Site) -> [i32; N],
        mut found: impl FnMut(i32, [i32; N]),
    ) {
        let n = 2 * chart.n();
        let mut next = from;
        let runs = self.runs(chart, rho);
        for (at, run) in runs.iter().enumerate() {
            for i in next..run.columns.start.min(to + 1) {
                // Between the two runs of a row lies the face.
                if at == 1 && i > 0 && i + rho < n {
                    found(i, inside(i));
                } else {
                    found(i, chart.elsewhere(rho, i).map_or([0; N], &value));
                }
            }
            next = next.max(run.columns.start);
            let values = &self.0[run.edge];
            for i in next..run.columns.end.min(to + 1) {
                found(i, values[(run.at + run.step * i) as usize]);
            }
            next = next.max(run.columns.end);
        }
        for i in next..=to {
            found(i, chart.elsewhere(rho, i).map_or([0; N], &value));
        }
    }

    /// The runs of row `ρ`, from left to right. A point beyond edge 0 has `n − i` along it and `−ρ` away from it; beyond edge
    /// 1, `n − ρ` and `i + ρ − n`; beyond edge 2, `i + ρ` and `−i`.
    fn runs(&self, chart: &Chart, rho: i32) -> [Run; 2] {
        let (n, lines) = (2 * chart.n(), LINES as i32);
        let beyond = |k: usize| if chart.across[k].is_some() { LINES as i32 - 1 } else { 0 };
        if rho <= 0 {
            if -rho > beyond(0) {
                return [Run::NONE, Run::NONE];
            }
            return [Run { columns: 1 - rho..n, edge: 0, at: n * lines - rho, step: -lines }, Run::NONE];
        }
        if rho >= n {
            return [Run::NONE, Run::NONE];
        }
        [
            Run { columns: (1 - rho).max(-beyond(2))..1, edge: 2, at: rho * lines, step: lines - 1 },
            Run {
                columns: n - rho..n.min(n - rho + beyond(1) + 1),
                edge: 1,
                at: (n - rho) * lines + rho - n,
                step: 1,
            },
        ]
    }
}
