//! Progress on a terminal, for what takes longer than a second.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::cell::OnceCell;
use std::io::IsTerminal;
use std::sync::mpsc::{self, RecvTimeoutError, Sender};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// What takes no longer is not spoken of.
const PATIENCE: Duration = Duration::from_secs(1);

/// A bar that appears after a second, on a terminal only.
#[derive(Debug)]
pub struct Progress {
    what: &'static str,
    begun: Instant,
    bar: OnceCell<ProgressBar>,
}

impl Progress {
    /// Begins; `what` is said beside the bar.
    pub fn new(what: &'static str) -> Self {
        Self { what, begun: Instant::now(), bar: OnceCell::new() }
    }

    /// Shows the share done, from 0 to 1. Always true: a command is cancelled by its signal, and its output is only
    /// ever replaced in one step.
    pub fn report(&self, share: f32) -> bool {
        if self.begun.elapsed() >= PATIENCE && std::io::stderr().is_terminal() {
            let bar = self.bar.get_or_init(|| {
                let style =
                    ProgressStyle::with_template("{msg} {wide_bar} {percent} %").expect("a valid template");
                let bar =
                    ProgressBar::with_draw_target(Some(1000), ProgressDrawTarget::stderr()).with_style(style);
                bar.set_message(self.what);
                bar
            });
            bar.set_position((share * 1000.0) as u64);
        }
        true
    }

    /// Seconds since the beginning.
    pub fn seconds(&self) -> f64 {
        self.begun.elapsed().as_secs_f64()
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.get() {
            bar.finish_and_clear();
        }
    }
}

/// A line with the time so far that appears after a second, on a terminal only, while something runs that cannot say how much of
/// it is done.
#[derive(Debug)]
pub(super) struct Busy {
    running: Option<(Sender<()>, JoinHandle<()>)>,
}

impl Busy {
    /// Begins; `what` is said on the line.
    pub(super) fn new(what: &'static str) -> Self {
        let start = || {
            let (end, ended) = mpsc::channel();
            let goes_on = move || ended.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout);
            let begun = Instant::now();
            let line = std::thread::spawn(move || {
                if !goes_on() {
                    return;
                }
                let style = ProgressStyle::with_template("{spinner} {msg}").expect("a valid template");
                let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()).with_style(style);
                loop {
                    bar.set_message(format!("{what}, {} s", begun.elapsed().as_secs()));
                    bar.tick();
                    if !goes_on() {
                        break;
                    }
                }
                bar.finish_and_clear();
            });
            (end, line)
        };
        Self { running: std::io::stderr().is_terminal().then(start) }
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        if let Some((end, line)) = self.running.take() {
            drop(end);
            // It has nothing to say but the line.
            let _ = line.join();
        }
    }
}
