//! What an import does, one thing after another, and how long each took.

use bozzetto_core::conversion::remesh::Phase;
use std::cell::{Cell, RefCell};
use std::time::Instant;

/// What an import is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stage {
    /// Reading the file.
    Read,
    /// Converting, from looking for subdivision connectivity on, by the conversion's own phases.
    Convert(Phase),
    /// Making wavelets of the positions.
    Build,
    /// Measuring the distance of every vertex, for a map.
    Map,
}

impl Stage {
    /// All stages in their order, for people who wait.
    pub(crate) const ALL: [Stage; 10] = [
        Stage::Read,
        Stage::Convert(Phase::Detect),
        Stage::Convert(Phase::Clean),
        Stage::Convert(Phase::Simplify),
        Stage::Convert(Phase::Resample),
        Stage::Convert(Phase::Relax),
        Stage::Convert(Phase::Fit),
        Stage::Convert(Phase::Measure),
        Stage::Build,
        Stage::Map,
    ];

    /// The stages for a mesh that is at hand.
    pub(crate) const OF_A_MESH: &[Stage] = Self::ALL.split_at(1).1;

    /// The stages for a mesh that is at hand and converted in any case.
    pub(crate) const CONVERTING: &[Stage] = Self::ALL.split_at(2).1;

    /// What it is, for people.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Stage::Read => "Read the file",
            Stage::Convert(Phase::Detect) => "Look for subdivision connectivity",
            Stage::Convert(Phase::Clean) => "Repair the mesh",
            Stage::Convert(Phase::Simplify) => "Simplify it to a base mesh",
            Stage::Convert(Phase::Resample) => "Place the vertices",
            Stage::Convert(Phase::Relax) => "Space them evenly",
            Stage::Convert(Phase::Fit) => "Fit the surface",
            Stage::Convert(Phase::Measure) => "Measure the distance",
            Stage::Build => "Make the wavelets",
            Stage::Map => "Map the error",
        }
    }

    /// Where in the whole it begins and ends; fitting takes most of the time.
    fn span(self) -> [f32; 2] {
        match self {
            Stage::Read => [0.0, 0.05],
            Stage::Convert(Phase::Detect) => [0.05, 0.06],
            Stage::Convert(Phase::Clean) => [0.06, 0.08],
            Stage::Convert(Phase::Simplify) => [0.08, 0.16],
            Stage::Convert(Phase::Resample) => [0.16, 0.19],
            Stage::Convert(Phase::Relax) => [0.19, 0.26],
            Stage::Convert(Phase::Fit) => [0.26, 0.86],
            Stage::Convert(Phase::Measure) => [0.86, 0.95],
            Stage::Build => [0.95, 0.97],
            Stage::Map => [0.97, 1.0],
        }
    }

    /// The share of the whole that is done, when this much of the stage is.
    pub(crate) fn share(self, done: f32) -> f32 {
        let [from, to] = self.span();
        from + (to - from) * done.clamp(0.0, 1.0)
    }
}

/// Takes the time of each stage while passing progress on.
pub(crate) struct Clock<'p> {
    progress: &'p dyn Fn(Stage, f32) -> bool,
    now: Cell<Option<(Stage, Instant)>>,
    spent: RefCell<Vec<(Stage, f64)>>,
}

impl<'p> Clock<'p> {
    /// A clock that has not begun.
    pub(crate) fn new(progress: &'p dyn Fn(Stage, f32) -> bool) -> Self {
        Self { progress, now: Cell::new(None), spent: RefCell::default() }
    }

    /// Says how much of a stage is done; whether to go on.
    pub(crate) fn report(&self, stage: Stage, done: f32) -> bool {
        if self.now.get().is_none_or(|(now, _)| now != stage) {
            self.stop();
            self.now.set(Some((stage, Instant::now())));
        }
        (self.progress)(stage, done)
    }

    /// Seconds by stage, in the order in which they began; a stage that came again is counted together.
    pub(crate) fn seconds(self) -> Vec<(Stage, f64)> {
        self.stop();
        self.spent.into_inner()
    }

    fn stop(&self) {
        if let Some((stage, since)) = self.now.take() {
            let seconds = since.elapsed().as_secs_f64();
            let mut spent = self.spent.borrow_mut();
            match spent.iter_mut().find(|(known, _)| *known == stage) {
                Some((_, sum)) => *sum += seconds,
                None => spent.push((stage, seconds)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_rise_from_nothing_to_all() {
        let mut last = 0.0;
        for stage in Stage::ALL {
            assert_eq!(stage.share(0.0), last, "{stage:?}");
            last = stage.share(1.0);
        }
        assert_eq!(last, 1.0);
    }

    #[test]
    fn every_stage_is_timed_once() {
        let clock = Clock::new(&|_, done| done < 1.0);
        assert!(clock.report(Stage::Read, 0.5));
        assert!(!clock.report(Stage::Read, 1.0));
        clock.report(Stage::Build, 0.0);
        clock.report(Stage::Read, 0.0);
        let stages: Vec<Stage> = clock.seconds().into_iter().map(|(stage, _)| stage).collect();
        assert_eq!(stages, [Stage::Read, Stage::Build]);
    }
}
