//! Whole levels of analysis and synthesis, face by face and row by row: the same bits as [`super::lifting`], the plain
//! reference, many times faster.
//!
//! A base face is worked through in strips of columns. A window slides down a strip; rows of the face and, unfolded
//! around it, of its neighbours are copied into the window, predicted and updated there by kernels on whole rows, and
//! written out. Every vertex is written by one face, so faces run in parallel. Even vertices near extraordinary
//! vertices, boundaries and sharp edges, where nothing can be unfolded, are updated one by one.
//!
//! It guarantees the reference's results for any input: where details are so large that the kernels' 32-bit class sums
//! could overflow, the level is given to the reference. Levels too coarse for the constant stencil have `coarse`.

mod analysis;
mod border;
mod chart;
mod coarse;
mod corner;
mod face_blocks;
mod pairs;
mod patch;
mod points;
mod predict;
mod prefetch;
mod stencil;
mod strip;
mod synthesis;
mod update;
mod window;

use super::lifting::{self, minus, plus, rounded};
use super::regularity::{is_coarse, is_regular, regular_run};
use super::{Filters, Wavelet};
use crate::hierarchy::{Hierarchy, Layout, Level, Site, Slot};
use crate::memory::Buffer;
use analysis::Output;
use border::Border;
use chart::Chart;
use face_blocks::split_by_face;
pub use patch::{Patch, Refined, add_steps, refine};
use pulp::Arch;
use rayon::prelude::*;
use std::ops::Range;
pub use stencil::Stencil;
use strip::Strip;
use window::{STRIP, Window};

/// Details below 2^27 in magnitude: twelve of them add within 32 bits.
const SUMMABLE_BITS: u32 = 27;

/// Vertices that are updated one by one at a time: few, for a thread without work falls asleep, and waking it takes longer.
const SITES: usize = 32;

/// The instructions that kernels are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Instructions {
    /// The best that this processor has.
    #[default]
    Detected,
    /// The best but AVX-512.
    Narrower,
    /// Those that every processor of the target has.
    Baseline,
}

/// What the work on a face needs besides the face.
struct Engine<'a> {
    filters: &'a Filters,
    arch: Arch,
}

impl Engine<'_> {
    /// A window for the faces of a level, one beyond the strip included: an odd vertex's parents.
    fn window<const N: usize>(&self, coarse: &Layout) -> Window<N> {
        Window::new(STRIP.min(coarse.segments() + 1) + 1, self.filters.stencil())
    }

    fn regular_run(&self, chart: &Chart, r: i32, strip: Strip) -> Range<i32> {
        let run = regular_run(chart.coarse, self.filters.wavelet(), chart.face, r as u32);
        if self.filters.wavelet() == Wavelet::Lazy {
            return 0..0;
        }
        strip.part(run.start as i32, run.end as i32 - 1)
    }
}

/// One level of analysis into given storage: `c^{j+1}` to `d^j` and `c^j`. `O(n_{j+1})`.
///
/// # Panics
/// If a slice does not have its level's length.
pub fn analyse_level_into<const N: usize>(
    hierarchy: &Hierarchy,
    filters: &Filters,
    level: Level,
    instructions: Instructions,
    finer: &[[i32; N]],
    (details, coarser): (&mut [[i32; N]], &mut [[i32; N]]),
) {
    let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
    assert_eq!(
        (details.len(), coarser.len(), finer.len()),
        (coarse.odd_len() as usize, coarse.len() as usize, fine.len() as usize)
    );
    if !serves(coarse, filters.wavelet()) {
        return coarse::analyse(filters, coarse, finer, (details, coarser));
    }
    let exact = {
        let engine = Engine { filters, arch: arch(instructions) };
        let (base, n) = (coarse.base(), coarse.segments() as usize);
        let details = split_by_face(base, details, n, 3 * n * (n - 1) / 2);
        let evens = &mut coarser[base.vertex_count() as usize..];
        let evens = split_by_face(base, evens, n - 1, (n - 1) * (n - 2) / 2);
        let faces = details.into_par_iter().zip(evens).enumerate();
        faces
            .map_init(
                || (engine.window(coarse), Border::new(coarse.segments())),
                |(window, border), (face, (details, coarser))| {
                    let chart = Chart::new(coarse, fine, face as u32);
                    engine.analyse_face(&chart, (window, border), finer, &mut Output { details, coarser })
                },
            )
            .reduce(|| true, |a, b| a & b)
    };
    if !exact {
        let (d, c) = lifting::analyse_level(hierarchy, filters, level, finer);
        details.copy_from_slice(&d);
        coarser.copy_from_slice(&c);
        return;
    }
    // What rows of faces leave: base vertices, and where the constant stencil does not serve.
    let details = &*details;
    let even = |slot: Slot| finer[fine.slot(Layout::refine(coarse.site(slot))).index()];
    for v in
        (0..coarse.base().vertex_count()).filter(|&v| is_regular(coarse, Site::Base(v), filters.wavelet()))
    {
        let sum = filters.gather(coarse, Site::Base(v), details);
        coarser[v as usize] = plus(even(Slot(v)), rounded(sum));
    }
    let sums = filters.irregular_sums(level, details).with_min_len(SITES);
    let updated: Vec<(Slot, [i32; N])> =
        sums.map(|(slot, sum)| (slot, plus(even(slot), rounded(sum)))).collect();
    updated.into_iter().for_each(|(slot, value)| coarser[slot.index()] = value);
}

/// One level of synthesis into given storage: `c^j` and `d^j` to `c^{j+1}`. `O(n_{j+1})`.
///
/// # Panics
/// If a slice does not have its level's length.
pub fn synthesise_level_into<const N: usize>(
    hierarchy: &Hierarchy,
    filters: &Filters,
    level: Level,
    instructions: Instructions,
    (coarser, details): (&[[i32; N]], &[[i32; N]]),
    finer: &mut [[i32; N]],
) {
    let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
    assert_eq!(
        (details.len(), coarser.len(), finer.len()),
        (coarse.odd_len() as usize, coarse.len() as usize, fine.len() as usize)
    );
    if !serves(coarse, filters.wavelet()) {
        return coarse::synthesise(filters, coarse, (coarser, details), finer);
    }
    let exact = {
        let engine = Engine { filters, arch: arch(instructions) };
        let (base, n) = (coarse.base(), fine.segments() as usize);
        let (corners, rest) = finer.split_at_mut(base.vertex_count() as usize);
        for (v, corner) in (0..).zip(corners) {
            let site = Site::Base(v);
            let even = coarser[coarse.slot(site).index()];
            *corner = minus(even, rounded(filters.gather(coarse, site, details)));
        }
        split_by_face(base, rest, n - 1, (n - 1) * (n - 2) / 2)
            .into_par_iter()
            .enumerate()
            .map_init(
                || (engine.window(coarse), Border::new(coarse.segments())),
                |(window, border), (face, mut finer)| {
                    let chart = Chart::new(coarse, fine, face as u32);
                    engine.synthesise_face(&chart, (window, border), (coarser, details), &mut finer)
                },
            )
            .reduce(|| true, |a, b| a & b)
    };
    if !exact {
        finer.copy_from_slice(&lifting::synthesise_level(hierarchy, filters, level, coarser, details));
    }
}

/// Whether rows serve a level at all.
fn serves(coarse: &Layout, wavelet: Wavelet) -> bool {
    coarse.level().0 >= 1 && !is_coarse(coarse, wavelet)
}

fn arch(instructions: Instructions) -> Arch {
    match instructions {
        Instructions::Detected => Arch::new(),
        Instructions::Narrower => narrower(Arch::new()),
        Instructions::Baseline => Arch::Scalar,
    }
}

fn narrower(arch: Arch) -> Arch {
    match arch {
        #[cfg(target_arch = "x86_64")]
        Arch::V4(v4) => Arch::V3(*v4),
        other => other,
    }
}

/// Where row `ρ` of level j + 1 lies in the storage of a face's interior; empty outside it.
fn row_range(chart: &Chart, rho: i32) -> Range<usize> {
    let n = 2 * chart.n();
    if !(1..n - 1).contains(&rho) {
        return 0..0;
    }
    let start = (chart.fine.row(chart.face, rho as u32).0 - chart.fine.row(chart.face, 1).0) as usize;
    start..start + (n - rho - 1) as usize
}

/// Row `ρ` of level j + 1 inside a face.
fn stored_row<'a, const N: usize>(chart: &Chart, rho: i32, finer: &'a [[i32; N]]) -> &'a [[i32; N]] {
    let row = row_range(chart, rho);
    if row.is_empty() {
        return &[];
    }
    let start = chart.fine.row(chart.face, 1).index();
    &finer[start + row.start..start + row.end]
}

/// Where the details of an odd row `ρ` lie in a face's part of the details; empty outside it.
fn stored_details(chart: &Chart, rho: i32) -> Range<usize> {
    let n = 2 * chart.n();
    if !(1..n - 1).contains(&rho) {
        return 0..0;
    }
    let start = chart.coarse.odd_row_start(rho as u32) as usize;
    start..start + (n - rho - 1) as usize
}

/// Where the details of row `2R` lie, of which every second vertex is odd; empty outside the face.
fn stored_even_row_details(chart: &Chart, r: i32) -> Range<usize> {
    let n = chart.n();
    if !(1..n).contains(&r) {
        return 0..0;
    }
    let start = chart.coarse.odd_row_start(2 * r as u32) as usize;
    start..start + (n - r) as usize
}

/// One level of analysis, into new storage.
pub fn analyse_level<const N: usize>(
    hierarchy: &Hierarchy,
    filters: &Filters,
    level: Level,
    finer: &[[i32; N]],
) -> (Buffer<[i32; N]>, Buffer<[i32; N]>) {
    let coarse = hierarchy.layout(level);
    let mut details = Buffer::zeroed(coarse.odd_len() as usize);
    let mut coarser = Buffer::zeroed(coarse.len() as usize);
    let output = (&mut details[..], &mut coarser[..]);
    analyse_level_into(hierarchy, filters, level, Instructions::Detected, finer, output);
    (details, coarser)
}

/// One level of synthesis, into new storage.
pub fn synthesise_level<const N: usize>(
    hierarchy: &Hierarchy,
    filters: &Filters,
    level: Level,
    coarser: &[[i32; N]],
    details: &[[i32; N]],
) -> Buffer<[i32; N]> {
    let mut finer = Buffer::zeroed(hierarchy.layout(level.finer()).len() as usize);
    synthesise_level_into(hierarchy, filters, level, Instructions::Detected, (coarser, details), &mut finer);
    finer
}

/// One level of synthesis without details, into new storage: the bits that details of zero give. `O(n_{j+1})`.
pub fn subdivide<const N: usize>(
    hierarchy: &Hierarchy,
    level: Level,
    coarser: &[[i32; N]],
) -> Buffer<[i32; N]> {
    let mut finer = Buffer::zeroed(hierarchy.layout(level.finer()).len() as usize);
    coarse::subdivide(hierarchy.layout(level), coarser, &mut finer);
    finer
}
