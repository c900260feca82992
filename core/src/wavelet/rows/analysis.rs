//! One face of one level of analysis.

use super::border::Border;
use super::chart::Chart;
use super::face_blocks::FaceBlock;
use super::points::Points;
use super::predict::Difference;
use super::prefetch::{Ahead, Purpose};
use super::strip::Strip;
use super::update::Direction;
use super::window::{Between, HALO, RowMut, STRIP, Window};
use super::{Engine, stored_details, stored_even_row_details, stored_row};
use std::ops::Range;

/// What a face writes: its details and its even vertices.
pub(super) struct Output<'a, const N: usize> {
    pub(super) details: FaceBlock<'a, [i32; N]>,
    pub(super) coarser: FaceBlock<'a, [i32; N]>,
}

impl Engine<'_> {
    /// Analyses a face: all its details, and its regular even vertices. Whether the sums were exact.
    pub(super) fn analyse_face<const N: usize>(
        &self,
        chart: &Chart,
        (window, border): (&mut Window<N>, &mut Border<N>),
        finer: &[[i32; N]],
        output: &mut Output<N>,
    ) -> bool {
        let n = chart.n();
        let points = Points::all(chart.coarse, chart.fine, finer);
        border.collect(self.arch, chart, &points);
        let mut exact = true;
        for first in (0..=n).step_by(STRIP as usize) {
            let strip = Strip { first, last: (first + STRIP as i32 - 1).min(n), arch: self.arch };
            window.start(first as u32);
            for r in -HALO..=n - first + HALO {
                let even = r - HALO;
                let stored = (0..=n - first).contains(&even);
                let run = if stored { self.regular_run(chart, even, strip) } else { 0..0 };
                let mut ahead = self.ahead_of_analysis(chart, (strip, r), finer, output);
                if run.is_empty() {
                    ahead.rest();
                }
                let used = window.used(n, r);
                let RowMut { e, odds: [h, ..], .. } = window.row(r);
                let (rho, planes) = (2 * r, [&mut e[..used], &mut h[..used]]);
                strip.read_row(chart, border, rho, stored_row(chart, rho, finer), planes);
                // While the odd vertices of the row before are there still.
                exact &= self.predict(window, n, r);
                let [_, v, d] = window.row(r).odds;
                let (rho, planes) = (2 * r + 1, [&mut v[..used], &mut d[..used]]);
                strip.read_row(chart, border, rho, stored_row(chart, rho, finer), planes);
                self.store_details(chart, strip, window, r, &mut output.details);
                if !run.is_empty() {
                    window.update(self.arch, Direction::Add, even, run, &mut ahead);
                }
                if stored {
                    store_evens(chart, strip, window, even, &mut output.coarser);
                }
            }
        }
        exact
    }

    /// What the next row reads and writes.
    #[inline(always)]
    fn ahead_of_analysis<const N: usize>(
        &self,
        chart: &Chart,
        (strip, r): (Strip, i32),
        finer: &[[i32; N]],
        output: &Output<N>,
    ) -> Ahead {
        let mut ahead = Ahead::new(self.arch);
        for rho in [2 * r + 2, 2 * r + 3] {
            let row = stored_row(chart, rho, finer);
            ahead.add(&row[strip.share(row.len(), 2)], Purpose::Read);
        }
        let odd = (stored_details(chart, 2 * r + 1), 2);
        for (range, per_column) in [odd, (stored_even_row_details(chart, r + 1), 1)] {
            let row = &output.details.interior[range];
            ahead.add(&row[strip.share(row.len(), per_column)], Purpose::Write);
        }
        ahead
    }

    /// Makes details of row `r` of `H` and of the row before it of `V` and `D`.
    #[inline(always)]
    fn predict<const N: usize>(&self, window: &mut Window<N>, n: i32, r: i32) -> bool {
        let difference = |odd: &[i32], parents: [&[i32]; 2], detail: &mut [i32]| {
            self.arch.dispatch(Difference { odd, parents, detail })
        };
        let count = window.worked(n, r);
        let Between { upper, details: [detail, ..], odds: [odd, ..], .. } = window.between(r, count);
        let mut exact = difference(odd, [&upper[..count], &upper[N..]], detail);
        if r > -HALO {
            let count = window.worked(n, r - 1);
            let Between { upper, lower, details: [_, v, d], odds } = window.between(r - 1, count);
            let lower = &lower[..count];
            exact &= difference(odds[1], [&upper[..count], lower], v);
            exact &= difference(odds[2], [&upper[N..], lower], d);
        }
        exact
    }

    #[inline(always)]
    fn store_details<const N: usize>(
        &self,
        chart: &Chart,
        strip: Strip,
        window: &mut Window<N>,
        r: i32,
        details: &mut FaceBlock<[i32; N]>,
    ) {
        let n = chart.n();
        let half = |t: u32| (t - 1) / 2;
        if (0..n).contains(&r) {
            let part = strip.part(0, n - r - 1);
            let column = window.column(part.start);
            let [h, ..] = window.row(r).details;
            if r == 0 {
                for i in part {
                    let value = h[(i - strip.first + HALO) as usize];
                    details.put_on_edge(chart, 2 * n, [2 * i + 1, 0], value, half);
                }
            } else if !part.is_empty() {
                let stored = &mut details.interior[stored_even_row_details(chart, r)];
                let count = part.len();
                stored[part.start as usize..part.end as usize].copy_from_slice(&h[column..column + count]);
            }
        }
        if (1..=n).contains(&r) {
            let rho = 2 * r - 1;
            let [_, v, d] = window.row(r - 1).details;
            let FaceBlock { interior, edges } = details;
            let stored = &mut interior[stored_details(chart, rho)];
            let mut on_edges =
                FaceBlock { interior: &mut [], edges: edges.each_mut().map(|e| e.as_deref_mut()) };
            let border = |i, value| on_edges.put_on_edge(chart, 2 * n, [i, rho], value, half);
            strip.write_row(chart, rho, stored, border, [v, d]);
        }
    }
}

#[inline(always)]
fn store_evens<const N: usize>(
    chart: &Chart,
    strip: Strip,
    window: &mut Window<N>,
    r: i32,
    coarser: &mut FaceBlock<[i32; N]>,
) {
    let n = chart.n();
    let row = window.row(r);
    let at = |i: i32| (i - strip.first + HALO) as usize;
    let inside = strip.part(1, n - r - 1);
    if r > 0 && !inside.is_empty() {
        let start = chart.coarse.row(chart.face, r as u32).0 - chart.coarse.row(chart.face, 1).0;
        let Range { start: from, end: to } = inside;
        let place = (start as i32 + from - 1) as usize..(start as i32 + to - 1) as usize;
        coarser.interior[place].copy_from_slice(&row.e[at(from)..at(to)]);
    }
    let borders = if r == 0 { strip.part(0, n) } else { strip.part(0, 0) };
    let right = if r == 0 { 0..0 } else { strip.part(n - r, n - r) };
    for i in borders.chain(right) {
        coarser.put_on_edge(chart, n, [i, r], row.e[at(i)], |t| t - 1);
    }
}
