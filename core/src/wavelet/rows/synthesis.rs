//! One face of one level of synthesis.

use super::border::Border;
use super::chart::Chart;
use super::face_blocks::FaceBlock;
use super::points::Points;
use super::predict::Sum;
use super::prefetch::{Purpose, prefetch};
use super::stencil::PlacedStencil;
use super::strip::Strip;
use super::update::{Direction, Update};
use super::window::{HALO, STRIP, Window, row_place};
use super::{Engine, row_range, stored_details, stored_even_row_details};
use crate::hierarchy::Layout;
use crate::wavelet::lifting::{minus, rounded};

/// Rows of predicted odd vertices on their way to the storage.
pub(super) struct Odds<const N: usize>([Vec<[i32; N]>; 3]);

impl Engine<'_> {
    /// Room for the rows of a level's windows.
    pub(super) fn odds<const N: usize>(&self, coarse: &Layout) -> Odds<N> {
        let len = self.window::<N>(coarse).row_len();
        Odds([(); 3].map(|()| vec![[0; N]; len]))
    }

    /// Synthesises a face: all its vertices but the corners. Whether the sums were exact.
    pub(super) fn synthesise_face<const N: usize>(
        &self,
        chart: &Chart,
        (window, border, odds): (&mut Window<N>, &mut Border<N>, &mut Odds<N>),
        (coarser, details): (&[[i32; N]], &[[i32; N]]),
        finer: &mut FaceBlock<[i32; N]>,
    ) -> bool {
        let n = chart.n();
        let stencils = window.place(self.filters.stencil());
        let start = chart.coarse.odd_face_start(chart.face) as usize;
        let own = &details[start..];
        let points = Points::odd(chart.coarse, chart.fine, details);
        border.collect(self.arch, chart, &points);
        let mut exact = true;
        for first in (0..=n).step_by(STRIP as usize) {
            let strip = Strip { first, last: (first + STRIP as i32 - 1).min(n), arch: self.arch };
            window.start(first as u32);
            for r in -HALO..=n - first + HALO {
                self.prefetch_for_synthesis(chart, (strip, r), (coarser, own), finer);
                read_details(chart, (strip, r), window, border, own);
                let even = r - HALO + 1;
                if (0..=n - first).contains(&even) {
                    self.update(chart, strip, window, even, &stencils[row_place(even)], coarser, details);
                    exact &= self.store(chart, strip, window, even, odds, finer);
                }
            }
        }
        exact
    }

    /// Has what the next row reads and writes fetched.
    #[inline(always)]
    fn prefetch_for_synthesis<const N: usize>(
        &self,
        chart: &Chart,
        (strip, r): (Strip, i32),
        (coarser, own): (&[[i32; N]], &[[i32; N]]),
        finer: &FaceBlock<[i32; N]>,
    ) {
        let odd = (stored_details(chart, 2 * r + 3), 2);
        for (range, per_column) in [(stored_even_row_details(chart, r + 1), 1), odd] {
            let row = &own[range];
            prefetch(self.arch, &row[strip.share(row.len(), per_column)], Purpose::Read);
        }
        let even = r - HALO + 2;
        let evens = even_row(chart, even, coarser);
        prefetch(self.arch, &evens[strip.share(evens.len(), 1)], Purpose::Read);
        for rho in [2 * even - 1, 2 * even] {
            let row = &finer.interior[row_range(chart, rho)];
            prefetch(self.arch, &row[strip.share(row.len(), 2)], Purpose::Write);
        }
    }

    /// The even vertices of a row, one beyond the strip included.
    #[allow(clippy::too_many_arguments)]
    fn update<const N: usize>(
        &self,
        chart: &Chart,
        strip: Strip,
        window: &mut Window<N>,
        r: i32,
        stencil: &PlacedStencil,
        coarser: &[[i32; N]],
        details: &[[i32; N]],
    ) {
        let n = chart.n();
        let wider = Strip { last: strip.last + 1, ..strip };
        let part = wider.part(0, n - r);
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
        let run = self.regular_run(chart, r, wider);
        let regular = if run.is_empty() { part.end..part.end } else { run.clone() };
        for i in (part.start..regular.start).chain(regular.end..part.end) {
            let sum = self.filters.gather(chart.coarse, chart.even(i as u32, r as u32), details);
            let even = &mut window.row(r).e[at(i)];
            *even = minus(*even, rounded(sum));
        }
        if !run.is_empty() {
            let (column, len) = (at(run.start), run.len() * N);
            let (details, evens) = window.for_update(r);
            let at = (column - HALO as usize) * N;
            let evens = &mut evens[column..].as_flattened_mut()[..len];
            Update { stencil, direction: Direction::Subtract, details, at, evens }.run(self.arch);
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
        Odds([h, v, d]): &mut Odds<N>,
        finer: &mut FaceBlock<[i32; N]>,
    ) -> bool {
        let last = window.used(chart.n(), r) - 1;
        let row = window.row(r);
        let (u, w) = (row.e[..last].as_flattened(), row.e[1..=last].as_flattened());
        let mut exact =
            self.arch.dispatch(Sum { odd: h.as_flattened_mut(), detail: row.h.as_flattened(), u, w });
        write(chart, strip, 2 * r, [row.e, h], finer);
        if r > 0 {
            let last = window.used(chart.n(), r - 1) - 1;
            let (upper, lower, row) = window.between(r - 1);
            let (u, w) = (upper[..last].as_flattened(), lower[..last].as_flattened());
            exact &=
                self.arch.dispatch(Sum { odd: v.as_flattened_mut(), detail: row.v.as_flattened(), u, w });
            let (u, w) = (upper[1..=last].as_flattened(), lower[..last].as_flattened());
            exact &=
                self.arch.dispatch(Sum { odd: d.as_flattened_mut(), detail: row.d.as_flattened(), u, w });
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
    let row = window.row(r);
    let (h, odd) = (&mut row.h[..used], [&mut row.v[..used], &mut row.d[..used]]);
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
