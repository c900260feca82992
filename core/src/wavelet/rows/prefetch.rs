//! Asking for rows before they are needed: a row of a face begins far from where the one before it ended, and what fetches ahead
//! by itself finds out only after some lines of it.

use super::strip::Strip;
use super::window::HALO;
use pulp::Arch;
use std::ops::Range;

/// Bytes of a line of the cache.
const LINE: usize = 64;

/// Rows that are asked for together.
const ROWS: usize = 5;

/// What is to be done with values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    Read,
    Write,
}

/// Has the caches fetch what will be read; a hint, and nothing where there is no such instruction.
#[inline(always)]
pub(super) fn prefetch<T>(arch: Arch, values: &[T]) {
    CacheLines::of(values, Purpose::Read).fetch(arch, usize::MAX);
}

/// What is to be fetched, some lines at a time between other work: only so many can be on their way at once, and who asks for
/// more waits.
pub(super) struct Ahead {
    arch: Arch,
    rows: [CacheLines; ROWS],
    /// Which of them are left, the most urgent first.
    left: Range<usize>,
    /// CacheLines a step.
    pace: usize,
}

impl Ahead {
    /// Nothing yet.
    #[inline(always)]
    pub(super) fn new(arch: Arch) -> Self {
        Self { arch, rows: [CacheLines::of::<u8>(&[], Purpose::Read); ROWS], left: 0..0, pace: 0 }
    }

    /// Adds the values of a row, after those that are more urgent.
    #[inline(always)]
    pub(super) fn add<T>(&mut self, values: &[T], purpose: Purpose) {
        self.rows[self.left.end] = CacheLines::of(values, purpose);
        self.left.end += 1;
    }

    /// From now on so many steps fetch everything.
    #[inline(always)]
    pub(super) fn spread(&mut self, steps: usize) {
        let lines: usize = self.rows[self.left.clone()].iter().map(|row| row.count).sum();
        self.pace = lines.div_ceil(steps.max(1));
    }

    /// Fetches a step's share.
    #[inline(always)]
    pub(super) fn step(&mut self) {
        self.fetch(self.pace);
    }

    /// Fetches what is left.
    #[inline(always)]
    pub(super) fn rest(&mut self) {
        self.fetch(usize::MAX);
    }

    #[inline(always)]
    fn fetch(&mut self, mut lines: usize) {
        while lines > 0 && !self.left.is_empty() {
            let row = &mut self.rows[self.left.start];
            lines -= row.fetch(self.arch, lines);
            self.left.start += usize::from(row.count == 0);
        }
    }
}

/// CacheLines of the cache after each other: where values lie, never read here.
#[derive(Clone, Copy)]
struct CacheLines {
    first: *const u8,
    count: usize,
    purpose: Purpose,
}

impl CacheLines {
    #[inline(always)]
    fn of<T>(values: &[T], purpose: Purpose) -> Self {
        Self { first: values.as_ptr().cast(), count: size_of_val(values).div_ceil(LINE), purpose }
    }

    /// Has the first of them fetched, at most so many; says how many.
    #[inline(always)]
    fn fetch(&mut self, arch: Arch, lines: usize) -> usize {
        let lines = lines.min(self.count);
        #[cfg(target_arch = "x86_64")]
        {
            use std::arch::x86_64::{_MM_HINT_ET0, _MM_HINT_T0};
            let sse = match arch {
                Arch::V4(v4) => Some(v4.sse),
                Arch::V3(v3) => Some(v3.sse),
                _ => None,
            };
            if let Some(sse) = sse {
                for line in 0..lines {
                    let place = self.first.wrapping_add(LINE * line).cast::<i8>();
                    match self.purpose {
                        Purpose::Read => sse._mm_prefetch::<_MM_HINT_T0>(place),
                        Purpose::Write => sse._mm_prefetch::<_MM_HINT_ET0>(place),
                    }
                }
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = (arch, self.purpose);
        self.first = self.first.wrapping_add(LINE * lines);
        self.count -= lines;
        lines
    }
}

impl Strip {
    /// The share of a row of the fine grid inside a face that a strip needs, `per_column` of its values a column.
    #[inline(always)]
    pub(super) fn share(self, len: usize, per_column: i32) -> Range<usize> {
        let at = |column: i32| ((per_column * column).max(0) as usize).min(len);
        at(self.first - HALO)..at(self.last + HALO + 1)
    }
}
