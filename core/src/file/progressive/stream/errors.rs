//! How far what a reader has is from the whole, kept up to date from block to block.

use super::super::planes::CLASSES;
use super::{State, Step, Truth, restored};
use crate::hierarchy::{Hierarchy, Level, Odd};
use crate::surface::Vector;

/// The squared errors left, by level and class.
pub(super) struct Errors {
    base: f64,
    levels: Vec<[f64; 2]>,
}

impl Errors {
    pub(super) fn new(state: &State, truth: &Truth) -> Self {
        let mut errors = Self { base: 0.0, levels: vec![[0.0; 2]; state.levels.len()] };
        errors.renew(state, truth, Step::Base);
        for j in 0..state.levels.len() {
            errors.renew(state, truth, Step::Begin(j));
        }
        errors
    }

    pub(super) fn renew(&mut self, state: &State, truth: &Truth, step: Step) {
        let square = |x: i32, y: i32| {
            let off = f64::from(x) - f64::from(y);
            off * off
        };
        match step {
            Step::Base => {
                let known = state.known_base();
                let pairs = known.iter().zip(&truth.base);
                self.base = pairs.map(|(k, t)| (0..3).map(|c| square(k[c], t[c])).sum::<f64>()).sum();
            }
            Step::Begin(j) => (0..2).for_each(|class| self.renew(state, truth, Step::Refine(j, class))),
            Step::Refine(j, class) => {
                let (coarse, fine) =
                    (state.hierarchy.layout(Level(j as u8)), state.hierarchy.layout(Level(j as u8 + 1)));
                let details = &state.levels[j];
                let range = CLASSES[class].clone();
                let of_odd = |(odd, t): (usize, &Vector)| {
                    let known = match details.known.is_empty() {
                        true => [0; 3],
                        false => details.known[fine.slot(coarse.odd_site(Odd(odd as u32))).index()],
                    };
                    range
                        .clone()
                        .map(|c| square(restored(known[c], details.planes[class]), t[c]))
                        .sum::<f64>()
                };
                // In order, so that the sum does not depend on threads.
                self.levels[j][class] = truth.local[j].iter().enumerate().map(of_odd).sum();
            }
        }
    }

    /// The root of the mean over the surface. A tangential error counts a sixteenth.
    pub(super) fn total(&self, hierarchy: &Hierarchy) -> f64 {
        let faces = hierarchy.base().faces().len() as f64;
        let levels = self
            .levels
            .iter()
            .enumerate()
            .map(|(j, [normal, tangential])| (normal + tangential / 16.0) / f64::from(4u32 << (2 * j)));
        ((self.base + levels.sum::<f64>()) / faces).sqrt()
    }
}
