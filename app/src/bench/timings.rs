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

/// A pool of so many threads.
///
/// # Errors
/// The system has no room for them.
pub(super) fn pool(threads: usize) -> anyhow::Result<ThreadPool> {
    Ok(ThreadPoolBuilder::new().num_threads(threads).build()?)
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
