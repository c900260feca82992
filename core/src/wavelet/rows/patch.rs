//! Local synthesis by rows: how a change of `c^j` goes on to `c^{j+1}` where details stay.
//!
//! Even vertices pass their change on. An odd vertex changes by the difference of its parents' means, so the details
//! need not be read. In a base face, borders included, a change is one run of differences a row, and what follows from
//! it lies in the same face: no change is ever looked up across a border. Faces work side by side, since each writes its
//! inside alone; border vertices, which several faces see alike, are written afterwards by one of them.

use super::pairs;
use super::predict::mean;
use crate::hierarchy::{Layout, Site, Slot};
use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;
use std::ops::Range;

/// Patches with fewer vertices are not worth a thread.
const WORTH_THREADS: usize = 1 << 13;

/// A row of a patch: columns from `first`, and where their steps stand.
#[derive(Debug, Clone, Copy, Default)]
struct Run {
    first: i32,
    at: usize,
    len: usize,
}

impl Run {
    /// First and last column.
    fn ends(self) -> Option<(i32, i32)> {
        (self.len > 0).then(|| (self.first, self.first + self.len as i32 - 1))
    }
}

/// What was added to `c^j` in one base face, borders included.
#[derive(Debug, Clone)]
pub struct Patch<const N: usize> {
    face: u32,
    top: i32,
    rows: Vec<Run>,
    steps: Vec<[i32; N]>,
}

/// What one step finer moved.
#[derive(Debug, Default)]
pub struct Refined {
    /// Sorted runs of slots. Not every vertex in them has moved, but every one that has lies in them.
    pub runs: Vec<Range<u32>>,
    /// Whether some coordinate went beyond the limit.
    pub beyond: bool,
}

impl<const N: usize> Patch<N> {
    /// The patches of a change of some vertices of a level, by face. `O(m log m)`.
    pub fn of(layout: &Layout, steps: &[(Slot, [i32; N])]) -> Vec<Self> {
        let base = layout.base();
        let mut places: Vec<(u32, i32, i32, [i32; N])> = Vec::with_capacity(steps.len());
        for &(slot, step) in steps {
            let site = layout.site(slot);
            let mut seen_from = |face| {
                let [_, i, r] = layout.in_face(face, site).expect("the face holds the vertex");
                places.push((face, r as i32, i as i32, step));
            };
            match site {
                Site::Face { face, .. } => seen_from(face),
                Site::Edge { edge, .. } => base.sides(edge).iter().flatten().for_each(|s| seen_from(s.face)),
                Site::Base(v) => base.fan(v).corners.iter().for_each(|&(face, _)| seen_from(face)),
            }
        }
        places.sort_unstable_by_key(|&(face, r, i, _)| (face, r, i));
        let of_face = |of: &[(u32, i32, i32, [i32; N])]| {
            let (face, top, ..) = of[0];
            let mut patch = Self { face, top, rows: Vec::new(), steps: Vec::new() };
            for row in of.chunk_by(|a, b| a.1 == b.1) {
                let (first, last) = (row[0].2, row[row.len() - 1].2);
                let at = patch.steps.len();
                patch.rows.resize((row[0].1 - top) as usize, Run::default());
                patch.rows.push(Run { first, at, len: (last - first + 1) as usize });
                patch.steps.resize(at + (last - first + 1) as usize, [0; N]);
                row.iter().for_each(|&(.., i, step)| patch.steps[at + (i - first) as usize] = step);
            }
            patch
        };
        places.chunk_by(|a, b| a.0 == b.0).map(of_face).collect()
    }

    fn row(&self, r: i32) -> Run {
        usize::try_from(r - self.top).ok().and_then(|at| self.rows.get(at)).copied().unwrap_or_default()
    }
}

/// Adds steps to values; whether a value went beyond the limit.
pub fn add_steps<const N: usize>(values: &mut [[i32; N]], steps: &[[i32; N]], limit: i32) -> bool {
    Arch::new().dispatch(Add { values: values.as_flattened_mut(), steps: steps.as_flattened(), limit })
}

/// Carries patches of level j on to level j + 1 and adds them to its vertices. The patches of level j + 1 replace those
/// of level j, unless it is the `last` level. Cost: the patches.
pub fn refine<const N: usize>(
    fine: &Layout,
    patches: &mut Vec<Patch<N>>,
    finer: &mut [[i32; N]],
    limit: i32,
    last: bool,
) -> Refined {
    let (borders, mut rest) = finer.split_at_mut(fine.row(0, 1).index());
    // Each patch with the inside of its face.
    let mut passed = 0;
    let mut tasks = Vec::with_capacity(patches.len());
    for patch in patches.drain(..) {
        let skipped = (patch.face as usize - passed) * inner_len(fine);
        let (interior, after) = std::mem::take(&mut rest)[skipped..].split_at_mut(inner_len(fine));
        rest = after;
        passed = patch.face as usize + 1;
        tasks.push((patch, interior));
    }
    let size: usize = tasks.iter().map(|(patch, _)| patch.steps.len()).sum();
    let arch = Arch::new();
    let one = |(patch, interior): (Patch<N>, &mut [[i32; N]])| {
        Refinement { fine, arch, borders: &*borders, limit, last, patch }.run(interior)
    };
    let done: Vec<Finer<N>> = if size >= WORTH_THREADS {
        tasks.into_par_iter().map(one).collect()
    } else {
        tasks.into_iter().map(one).collect()
    };

    let mut refined = Refined::default();
    let mut at_borders: Vec<u32> = Vec::new();
    for finer in &done {
        refined.beyond |= finer.beyond;
        for &(slot, step) in &finer.borders {
            let value = &mut borders[slot as usize];
            for c in 0..N {
                value[c] = value[c].wrapping_add(step[c]);
                refined.beyond |= !(-limit..=limit).contains(&value[c]);
            }
            at_borders.push(slot);
        }
    }
    at_borders.sort_unstable();
    refined.runs =
        at_borders.chunk_by(|a, b| a + 1 == *b).map(|run| run[0]..run[run.len() - 1] + 1).collect();
    for finer in done {
        refined.runs.extend(finer.runs);
        patches.push(finer.patch);
    }
    refined
}

/// The vertices inside a base face.
fn inner_len(layout: &Layout) -> usize {
    let n = layout.segments() as usize;
    (n - 1) * n.saturating_sub(2) / 2
}

/// A patch one level finer, with what else it says.
struct Finer<const N: usize> {
    patch: Patch<N>,
    /// Border vertices that this face writes.
    borders: Vec<(u32, [i32; N])>,
    runs: Vec<Range<u32>>,
    beyond: bool,
}

/// A patch on its way to the next level.
struct Refinement<'a, const N: usize> {
    fine: &'a Layout,
    arch: Arch,
    borders: &'a [[i32; N]],
    limit: i32,
    last: bool,
    patch: Patch<N>,
}

/// A row of even vertices: where they were, and what is added to them.
struct Line<const N: usize> {
    first: i32,
    old: Vec<[i32; N]>,
    new: Vec<[i32; N]>,
    step: Vec<[i32; N]>,
}

impl<const N: usize> Line<N> {
    /// Room for so many columns.
    fn new(columns: usize) -> Self {
        let [old, new, step] = [(); 3].map(|()| Vec::with_capacity(columns));
        Self { first: 0, old, new, step }
    }
}

/// Scratch rows.
struct Scratch<const N: usize> {
    a: Vec<[i32; N]>,
    b: Vec<[i32; N]>,
    merged: Vec<[i32; N]>,
}

impl<const N: usize> Scratch<N> {
    /// Room for so many columns.
    fn new(columns: usize) -> Self {
        let [a, b, merged] = [1, 1, 2].map(|times| Vec::with_capacity(times * columns));
        Self { a, b, merged }
    }
}

impl<const N: usize> Refinement<'_, N> {
    fn run(self, interior: &mut [[i32; N]]) -> Finer<N> {
        // Twice as many rows and columns, and what a change reaches beyond them.
        let rows = 2 * self.patch.rows.len() + 3;
        let widest = self.patch.rows.iter().map(|row| row.len).max().unwrap_or(0) + 4;
        let kept = if self.last { 0 } else { 4 * self.patch.steps.len() + 8 * rows };
        let patch = Patch {
            face: self.patch.face,
            top: i32::MAX,
            rows: Vec::with_capacity(rows),
            steps: Vec::with_capacity(kept),
        };
        let mut finer = Finer { patch, borders: Vec::new(), runs: Vec::with_capacity(rows), beyond: false };
        let n = self.fine.segments() as i32 / 2;
        let (mut upper, mut lower) = (Line::new(widest), Line::new(widest));
        let mut scratch = Scratch::new(widest);
        let bottom = self.patch.top + self.patch.rows.len() as i32 - 1;
        self.load(self.patch.top - 1, interior, &mut upper);
        for r in self.patch.top - 1..=bottom {
            // Before its row is written.
            self.load(r + 1, interior, &mut lower);
            if r >= 0 {
                if let Some((a, b)) = self.patch.row(r).ends() {
                    let columns = (a - 1).max(0)..b + 1;
                    self.mean_change(&upper, 0, &upper, 1, columns.clone(), &mut scratch.b);
                    scratch.a.clear();
                    scratch.a.extend_from_slice(&upper.step[upper.part(columns.clone())]);
                    self.write(2 * r, columns, &mut scratch, interior, &mut finer);
                }
                let ends = [self.patch.row(r).ends().map(|(a, b)| (a - 1, b)), self.patch.row(r + 1).ends()];
                let first = ends.iter().flatten().map(|e| e.0).min();
                let last = ends.iter().flatten().map(|e| e.1).max();
                if let (Some(first), Some(last)) = (first, last) {
                    let columns = first.max(0)..last.min(n - r - 1) + 1;
                    if !columns.is_empty() {
                        self.mean_change(&upper, 0, &lower, 0, columns.clone(), &mut scratch.a);
                        self.mean_change(&upper, 1, &lower, 0, columns.clone(), &mut scratch.b);
                        self.write(2 * r + 1, columns, &mut scratch, interior, &mut finer);
                    }
                }
            }
            std::mem::swap(&mut upper, &mut lower);
        }
        finer
    }

    /// Row `r` of level j as it was, as wide as the rows around it need.
    fn load(&self, r: i32, interior: &[[i32; N]], line: &mut Line<N>) {
        let n = self.fine.segments() as i32 / 2;
        let around = || [r - 1, r, r + 1].into_iter().filter_map(|r| self.patch.row(r).ends());
        line.old.clear();
        line.step.clear();
        line.new.clear();
        let (Some(first), Some(last)) = (around().map(|e| e.0).min(), around().map(|e| e.1).max()) else {
            return;
        };
        line.first = (first - 1).max(0);
        // One beyond the row, where differences are taken but not used.
        let end = (last + 1).min(n - r) + 2;
        if !(0..=n).contains(&r) || end <= line.first {
            line.old.resize((end - line.first).max(0) as usize, [0; N]);
        } else {
            // Inside the face every second place of the row.
            let inside = line.first.max(1)..if r > 0 { end.min(n - r) } else { 0 };
            let border = |i: i32| match i + r > n {
                true => [0; N],
                false => {
                    let (fine, n) = (self.fine, 2 * n);
                    let b = [n - 2 * i - 2 * r, 2 * i, 2 * r].map(|x| x as u32);
                    self.borders[fine.slot(fine.site_at(self.patch.face, b)).index()]
                }
            };
            if inside.is_empty() {
                line.old.extend((line.first..end).map(border));
            } else {
                line.old.extend((line.first..inside.start).map(border));
                let from = self.inside(2 * r).start + (2 * inside.start - 1) as usize;
                let stored = &interior[from..from + 2 * inside.len() - 1];
                line.old.extend(stored.iter().step_by(2));
                line.old.extend((inside.end..end).map(border));
            }
        }
        line.step.resize(line.old.len(), [0; N]);
        let run = self.patch.row(r);
        if run.len > 0 {
            let from = (run.first - line.first) as usize;
            line.step[from..from + run.len].copy_from_slice(&self.patch.steps[run.at..run.at + run.len]);
        }
        line.new.extend_from_slice(&line.old);
        add(line.new.as_flattened_mut(), line.step.as_flattened());
    }

    /// By how much the means of `u` and `w`, shifted by so many columns, change.
    fn mean_change(
        &self,
        u: &Line<N>,
        shift: i32,
        w: &Line<N>,
        w_shift: i32,
        columns: Range<i32>,
        change: &mut Vec<[i32; N]>,
    ) {
        let at = |line: &Line<N>, shift| line.part(columns.start + shift..columns.end + shift);
        let (u_part, w_part) = (at(u, shift), at(w, w_shift));
        change.clear();
        change.resize(columns.len(), [0; N]);
        self.arch.dispatch(MeanChange {
            change: change.as_flattened_mut(),
            old: [u.old[u_part.clone()].as_flattened(), w.old[w_part.clone()].as_flattened()],
            new: [u.new[u_part].as_flattened(), w.new[w_part].as_flattened()],
        });
    }

    /// Adds the merged planes to row `ρ`, and keeps them for the next level.
    fn write(
        &self,
        rho: i32,
        columns: Range<i32>,
        scratch: &mut Scratch<N>,
        interior: &mut [[i32; N]],
        finer: &mut Finer<N>,
    ) {
        let n = self.fine.segments() as i32;
        let Scratch { a, b, merged } = scratch;
        merged.resize(2 * a.len(), [0; N]);
        pairs::merge(self.arch, a, b, merged);
        let first = 2 * columns.start;
        let end = (2 * columns.end).min(n - rho + 1);
        let steps = &merged[..(end - first) as usize];
        let inside = first.max(1)..end.min(n - rho);
        if (1..n).contains(&rho) && !inside.is_empty() {
            let start = self.inside(rho).start as i32;
            let place = (start + inside.start - 1) as usize..(start + inside.end - 1) as usize;
            let part = (inside.start - first) as usize..(inside.end - first) as usize;
            finer.beyond |= self.arch.dispatch(Add {
                values: interior[place.clone()].as_flattened_mut(),
                steps: steps[part].as_flattened(),
                limit: self.limit,
            });
            let slot = self.fine.row(self.patch.face, 1).0;
            finer.runs.push(slot + place.start as u32..slot + place.end as u32);
        }
        let border = |i: &i32| rho == 0 || *i == 0 || *i == n - rho;
        if rho == 0 || first == 0 || end == n - rho + 1 {
            let step_at = |i: i32| steps[(i - first) as usize];
            finer.borders.extend((first..end).filter(border).filter_map(|i| {
                let site = self.fine.site_at(self.patch.face, [n - i - rho, i, rho].map(|x| x as u32));
                self.owns(site).then(|| (self.fine.slot(site).0, step_at(i)))
            }));
        }
        if !self.last {
            finer.patch.top = finer.patch.top.min(rho);
            let at = finer.patch.steps.len();
            finer.patch.rows.resize((rho - finer.patch.top) as usize, Run::default());
            finer.patch.rows.push(Run { first, at, len: steps.len() });
            finer.patch.steps.extend_from_slice(steps);
        }
    }

    /// Of the faces around a border vertex the first writes it.
    fn owns(&self, site: Site) -> bool {
        let base = self.fine.base();
        match site {
            Site::Face { .. } => false,
            Site::Edge { edge, .. } => base.sides(edge)[0].is_some_and(|side| side.face == self.patch.face),
            Site::Base(v) => base.fan(v).corners[0].0 == self.patch.face,
        }
    }

    /// Where row `ρ` of the fine level lies inside the face.
    fn inside(&self, rho: i32) -> Range<usize> {
        let n = self.fine.segments() as i32;
        if !(1..n - 1).contains(&rho) {
            return 0..0;
        }
        let start = (self.fine.row(0, rho as u32).0 - self.fine.row(0, 1).0) as usize;
        start..start + (n - rho - 1) as usize
    }
}

impl<const N: usize> Line<N> {
    fn part(&self, columns: Range<i32>) -> Range<usize> {
        (columns.start - self.first) as usize..(columns.end - self.first) as usize
    }
}

fn add(values: &mut [i32], steps: &[i32]) {
    values.iter_mut().zip(steps).for_each(|(value, step)| *value = value.wrapping_add(*step));
}

/// `mean(new) − mean(old)`.
struct MeanChange<'a> {
    change: &'a mut [i32],
    old: [&'a [i32]; 2],
    new: [&'a [i32]; 2],
}

impl WithSimd for MeanChange<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Self { change, old: [u, w], new: [nu, nw] } = self;
        let old = u.iter().zip(w);
        let new = nu.iter().zip(nw);
        for ((change, (&u, &w)), (&nu, &nw)) in change.iter_mut().zip(old).zip(new) {
            *change = mean(nu, nw).wrapping_sub(mean(u, w));
        }
    }
}

/// Adds steps to values; whether one went beyond the limit.
struct Add<'a> {
    values: &'a mut [i32],
    steps: &'a [i32],
    limit: i32,
}

impl WithSimd for Add<'_> {
    type Output = bool;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> bool {
        let (mut low, mut high) = (0, 0);
        for (value, &step) in self.values.iter_mut().zip(self.steps) {
            *value = value.wrapping_add(step);
            low = low.min(*value);
            high = high.max(*value);
        }
        low < -self.limit || high > self.limit
    }
}
