//! Repeating what is measured, and the median of it.

use rayon::{ThreadPool, ThreadPoolBuilder};
use std::time::Instant;

/// Seconds of several runs of one thing.
#[derive(Debug, Default)]
pub(super) struct Timings(Vec<f64>);

impl Timings {
    /// Runs something and notes how long it took.
    pub(super) fn time<T>(&mut self, what: impl FnOnce() -> T) -> T {
        let begun = Instant::now();
        let result = what();
        self.0.push(begun.elapsed().as_secs_f64());
        result
    }

    /// Notes how long something took.
    pub(super) fn push(&mut self, seconds: f64) {
        self.0.push(seconds);
    }

    /// The newest in seconds; not a number before the first run.
    pub(super) fn last(&self) -> f64 {
        self.0.last().copied().unwrap_or(f64::NAN)
    }

    /// The median in seconds; not a number before the first run.
    pub(super) fn median(&self) -> f64 {
        let mut sorted = self.0.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let middle = sorted.len() / 2;
        match sorted.len() {
            0 => f64::NAN,
            n if n % 2 == 1 => sorted[middle],
            _ => (sorted[middle - 1] + sorted[middle]) / 2.0,
        }
    }
}

/// A pool of so many threads, several of which keep to a processor each: Linux lets a thread that wakes share the processor of
/// the one that wakes it for milliseconds, above all in a virtual machine, where a halted processor counts as taken.
///
/// # Errors
/// The system has no room for them.
pub(super) fn pool(threads: usize) -> anyhow::Result<ThreadPool> {
    let builder = ThreadPoolBuilder::new().num_threads(threads);
    #[cfg(target_os = "linux")]
    let builder = if threads > 1 { builder.start_handler(keep_to_a_processor) } else { builder };
    Ok(builder.build()?)
}

/// Binds the calling thread to one of the processors that it may use, the next for each number. Where that is not allowed, it
/// stays free.
#[cfg(target_os = "linux")]
fn keep_to_a_processor(number: usize) {
    use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};
    let Ok(allowed) = sched_getaffinity(None) else { return };
    let processors = (0..CpuSet::MAX_CPU).filter(|&processor| allowed.is_set(processor));
    if let Some(own) = processors.cycle().nth(number) {
        let mut set = CpuSet::new();
        set.set(own);
        let _ = sched_setaffinity(None, &set);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_in_the_middle() {
        assert!(Timings::default().median().is_nan());
        assert_eq!(Timings(vec![3.0, 1.0, 2.0]).median(), 2.0);
        assert_eq!(Timings(vec![4.0, 1.0, 2.0, 9.0]).median(), 3.0);
    }
}
