//! One face of one level of synthesis.

use super::border::Border;
use super::chart::Chart;
use super::face_blocks::FaceBlock;
use super::points::Points;
use super::predict::Sum;
use super::prefetch::{Ahead, Purpose};
use super::strip::Strip;
use super::update::Direction;
use super::window::{Between, HALO, RowMut, STRIP, Window};
use super::{Engine, row_range, stored_details, stored_even_row_details};
use crate::wavelet::lifting::{minus, rounded};
use std::ops::Range;

impl Engine<'_> {
    /// Synthesises a face: all its vertices but the corners. Whether the sums were exact.
    pub(super) fn synthesise_face<const N: usize>(
        &self,
        chart: &Chart,
        (window, border): (&mut Window<N>, &mut Border<N>),
        (coarser, details): (&[[i32; N]], &[[i32; N]]),
        finer: &mut FaceBlock<[i32; N]>,
    ) -> bool {
        let n = chart.n();
        let start = chart.coarse.odd_face_start(chart.face) as usize;
        let own = &details[start..];
        let points = Points::odd(chart.coarse, chart.fine, details);
        border.collect(self.arch, chart, &points);
        let mut exact = true;
        for first in (0..=n).step_by(STRIP as usize) {
            let strip = Strip { first, last: (first + STRIP as i32 - 1).min(n), arch: self.arch };
            window.start(first as u32);
            for r in -HALO..=n - first + HALO {
                let even = r - HALO + 1;
                let stored = (0..=n - first).contains(&even);
                // An odd vertex's parent may lie one beyond the strip.
                let wider = Strip { last: strip.last + 1, ..strip };
                let run = if stored { self.regular_run(chart, even, wider) } else { 0..0 };
                let mut ahead = self.ahead_of_synthesis(chart, (strip, r), (coarser, own), finer);
                if run.is_empty() {
                    ahead.rest();
                }
                read_details(chart, (strip, r), window, border, own);
                if stored {
                    self.read_evens(chart, (wider, even), &run, window, (coarser, details));
                    if !run.is_empty() {
                        window.update(self.arch, Direction::Subtract, even, run, &mut ahead);
                    }
                    exact &= self.store(chart, strip, window, even, finer);
                }
            }
        }
        exact
    }

    /// What the next row reads and writes.
    #[inline(always)]
    fn ahead_of_synthesis<const N: usize>(
        &self,
        chart: &Chart,
        (strip, r): (Strip, i32),
        (coarser, own): (&[[i32; N]], &[[i32; N]]),
        finer: &FaceBlock<[i32; N]>,
    ) -> Ahead {
        let mut ahead = Ahead::new(self.arch);
        let odd = (stored_details(chart, 2 * r + 3), 2);
        for (range, per_column) in [(stored_even_row_details(chart, r + 1), 1), odd] {
            let row = &own[range];
            ahead.add(&row[strip.share(row.len(), per_column)], Purpose::Read);
        }
        let even = r - HALO + 2;
        let evens = even_row(chart, even, coarser);
        ahead.add(&evens[strip.share(evens.len(), 1)], Purpose::Read);
        for rho in [2 * even - 1, 2 * even] {
            let row = &finer.interior[row_range(chart, rho)];
            ahead.add(&row[strip.share(row.len(), 2)], Purpose::Write);
        }
        ahead
    }

    /// Reads the even vertices of a strip's row, and updates one by one those outside the run of regular ones.
    fn read_evens<const N: usize>(
        &self,
        chart: &Chart,
        (strip, r): (Strip, i32),
        run: &Range<i32>,
        window: &mut Window<N>,
        (coarser, details): (&[[i32; N]], &[[i32; N]]),
    ) {
        let n = chart.n();
        let part = strip.part(0, n - r);
        let at = |i: i32| (i - strip.first + HALO) as usize;
        let row = window.row(r);
        let mut border =
            |i: i32| row.e[at(i)] = coarser[chart.coarse.slot(chart.even(i as u32, r as u32)).index()];
        let (from, to) = (part.start.max(1), (part.end - 1).min(n - r - 1));
        if r > 0 && from <= to {
            (part.start..from).chain(to + 1..part.end).for_each(border);
            let evens = even_row(chart, r, coarser);
            row.e[at(from)..=at(to)].copy_from_slice(&evens[from as usize - 1..to as usize]);
        } else {
            part.clone().for_each(&mut border);
        }
        let regular = if run.is_empty() { part.end..part.end } else { run.clone() };
        for i in (part.start..regular.start).chain(regular.end..part.end) {
            let sum = self.filters.gather(chart.coarse, chart.even(i as u32, r as u32), details);
            let even = &mut window.row(r).e[at(i)];
            *even = minus(*even, rounded(sum));
        }
    }

    /// Predicts and writes row `2R` of the fine grid and the row before it. Whether class sums of the details that were read
    /// cannot overflow: every detail of a level is read here in some face.
    fn store<const N: usize>(
        &self,
        chart: &Chart,
        strip: Strip,
        window: &mut Window<N>,
        r: i32,
        finer: &mut FaceBlock<[i32; N]>,
    ) -> bool {
        let sum = |odd: &mut [i32], parents: [&[i32]; 2], detail: &[i32]| {
            self.arch.dispatch(Sum { odd, parents, detail })
        };
        let count = window.worked(chart.n(), r);
        let Between { upper, details: [detail, ..], odds: [odd, ..], .. } = window.between(r, count);
        let mut exact = sum(odd, [&upper[..count], &upper[N..]], detail);
        let RowMut { e, odds: [h, ..], .. } = window.row(r);
        write(chart, strip, 2 * r, [e, h], finer);
        if r > 0 {
            let count = window.worked(chart.n(), r - 1);
            let Between { upper, lower, details, odds: [_, v, d] } = window.between(r - 1, count);
            let lower = &lower[..count];
            exact &= sum(v, [&upper[..count], lower], details[1]);
            exact &= sum(d, [&upper[N..], lower], details[2]);
            let [_, v, d] = window.row(r - 1).odds;
            write(chart, strip, 2 * r - 1, [v, d], finer);
        }
        exact
    }
}

/// Row `r` of the even vertices inside a face.
fn even_row<'a, const N: usize>(chart: &Chart, r: i32, coarser: &'a [[i32; N]]) -> &'a [[i32; N]] {
    let n = chart.n();
    if !(1..n - 1).contains(&r) {
        return &[];
    }
    let start = chart.coarse.row(chart.face, r as u32).index();
    &coarser[start..start + (n - r - 1) as usize]
}

/// Reads the details of row `2R` of the unfolded fine grid and of the row after it.
#[inline(always)]
fn read_details<const N: usize>(
    chart: &Chart,
    (strip, r): (Strip, i32),
    window: &mut Window<N>,
    border: &Border<N>,
    own: &[[i32; N]],
) {
    let n = chart.n();
    let left = strip.first - HALO;
    let used = window.used(n, r);
    let [h, v, d] = window.row(r).details;
    let (h, odd) = (&mut h[..used], [&mut v[..used], &mut d[..used]]);
    let rho = 2 * r + 1;
    strip.read_row(chart, border, rho, &own[stored_details(chart, rho)], odd);
    // Of an even row only `H` is stored, all of it inside the face.
    let (low, high) = chart.reach(2 * r);
    let (low, high) = (low.div_euclid(2).max(left), high.div_euclid(2).min(left + used as i32 - 1));
    let (from, to) = if (1..n).contains(&r) { (low.max(0), high.min(n - r - 1)) } else { (0, -1) };
    match border.sides(2 * r) {
        Some([before, after]) if from <= to => {
            if strip.first == 0 {
                h.iter_mut().zip(before.as_chunks::<2>().0).for_each(|(h, pair)| *h = pair[1]);
            }
            let (pairs, _) = after.as_chunks::<2>();
            let beyond = pairs.iter().map(|pair| pair[1]).chain(std::iter::repeat([0; N]));
            h[(to + 1 - left) as usize..].iter_mut().zip(beyond).for_each(|(h, value)| *h = value);
        }
        _ => {
            let around = if from > to {
                [[2 * low, 2 * high + 1], [0, -1]]
            } else {
                [[2 * low, 2 * from - 1], [2 * to + 2, 2 * high + 1]]
            };
            for columns in around {
                let no_odds = |_| [0; N];
                border.row(2 * r, columns, no_odds, |i, value| {
                    if i & 1 == 1 {
                        h[((i >> 1) - left) as usize] = value;
                    }
                });
            }
        }
    }
    if from <= to {
        let row = &own[stored_even_row_details(chart, r)];
        h[(from - left) as usize..=(to - left) as usize].copy_from_slice(&row[from as usize..=to as usize]);
    }
}

#[inline(always)]
fn write<const N: usize>(
    chart: &Chart,
    strip: Strip,
    rho: i32,
    planes: [&[[i32; N]]; 2],
    finer: &mut FaceBlock<[i32; N]>,
) {
    let FaceBlock { interior, edges } = finer;
    let stored = &mut interior[row_range(chart, rho)];
    let mut on_edges = FaceBlock { interior: &mut [], edges: edges.each_mut().map(|e| e.as_deref_mut()) };
    let border = |i, value| on_edges.put_on_edge(chart, 2 * chart.n(), [i, rho], value, |t| t - 1);
    strip.write_row(chart, rho, stored, border, planes);
}
