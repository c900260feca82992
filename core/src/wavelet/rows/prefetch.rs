//! Asking for rows before they are needed: a row of a face begins far from where the one before it ended, and what fetches ahead
//! by itself finds out only after some lines of it.

use super::strip::Strip;
use super::window::HALO;
use pulp::Arch;
use std::ops::Range;

/// Bytes of a line of the cache.
#[cfg(target_arch = "x86_64")]
const LINE: usize = 64;

/// What is to be done with values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    Read,
    Write,
}

/// Has the caches fetch values; a hint, and nothing where there is no such instruction.
#[inline(always)]
pub(super) fn prefetch<T>(arch: Arch, values: &[T], purpose: Purpose) {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::x86_64::{_MM_HINT_ET0, _MM_HINT_T0};
        let sse = match arch {
            Arch::V4(v4) => v4.sse,
            Arch::V3(v3) => v3.sse,
            _ => return,
        };
        let first = values.as_ptr().cast::<i8>();
        for at in (0..size_of_val(values)).step_by(LINE) {
            match purpose {
                Purpose::Read => sse._mm_prefetch::<_MM_HINT_T0>(first.wrapping_add(at)),
                Purpose::Write => sse._mm_prefetch::<_MM_HINT_ET0>(first.wrapping_add(at)),
            }
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = (arch, values, purpose);
}

impl Strip {
    /// The share of a row of the fine grid inside a face that a strip needs, `per_column` of its values a column.
    #[inline(always)]
    pub(super) fn share(self, len: usize, per_column: i32) -> Range<usize> {
        let at = |column: i32| ((per_column * column).max(0) as usize).min(len);
        at(self.first - HALO)..at(self.last + HALO + 1)
    }
}
