//! Detail that follows: after a coarse pull, finer wavelet coefficients turn with the surface under them.
//!
//! Each odd vertex has a frame from connectivity alone: the edge between its parents, and the line between the vertices
//! on either side of it. What takes the frame before the pull to the frame after it turns the coefficient. So relief keeps
//! its height and its angle to the surface where a form bends, and keeps its bits where nothing moved.

use super::brushes::turned;
use super::details::opposite;
use super::reach::{Steps, cross, dot, minus, plus, steps, times, unit};
use crate::hierarchy::{Layout, Level, Odd, Site, Slot};
use crate::surface::{Changes, Moved, Runs, Surface, Vector};
use rayon::prelude::*;

/// Odd vertices that a thread takes at a time.
const TASK: usize = 512;

/// A level as it was before the pull, where the pull reaches.
#[derive(Debug, Clone, Default)]
struct Before {
    runs: Vec<(u32, usize)>,
    ends: Vec<u32>,
    positions: Vec<Vector>,
    odds: Vec<(Odd, Vector)>,
}

/// The surface before a pull, where the pull reaches, from its level up.
#[derive(Debug, Clone)]
pub struct Follow {
    level: Level,
    levels: Vec<Before>,
}

/// What was turned: additions to wavelet coefficients, coarse to fine.
pub type Turned = Vec<(Level, Vec<(Odd, Vector)>)>;

impl Follow {
    /// Notes positions and details where a trial of the pull has moved something; the surface is as before the pull.
    pub fn new(surface: &Surface, level: Level, trial: &Changes) -> Self {
        let hierarchy = surface.hierarchy();
        let none = Runs::default();
        let runs_at = |j: Level| match trial.at(j) {
            Moved::Some(runs) => runs,
            _ => &none,
        };
        let levels = (level.0..surface.finest().0)
            .map(|j| {
                let mut before = Before::default();
                for run in runs_at(Level(j)).iter() {
                    before.runs.push((run.start, before.positions.len()));
                    before.ends.push(run.end);
                    let of_run = &surface.scaling(Level(j))[run.start as usize..run.end as usize];
                    before.positions.extend_from_slice(of_run);
                }
                let (coarse, fine) = (hierarchy.layout(Level(j)), hierarchy.layout(Level(j).finer()));
                for slot in runs_at(Level(j).finer()).slots() {
                    let site = fine.site(slot);
                    if Layout::coarsen(site).is_none() {
                        let odd = coarse.odd_at(site);
                        before.odds.push((odd, surface.wavelets(Level(j))[odd.index()]));
                    }
                }
                before.odds.sort_unstable_by_key(|&(odd, _)| odd);
                before
            })
            .collect();
        Self { level, levels }
    }

    /// Turns the details after the pull, level by level up to `reach`, and returns what was added. Cost: the support.
    pub fn turn(&self, surface: &mut Surface, reach: Level) -> (Turned, Changes) {
        let mut all = Vec::new();
        let mut changes = Changes::nothing(surface);
        for (before, level) in self.levels.iter().zip((self.level.0..reach.0).map(Level)) {
            let deltas = before.turned(surface, level);
            if !deltas.is_empty() {
                let of_level = (level, deltas);
                changes.join(surface.add_details_up_to(std::slice::from_ref(&of_level), reach));
                all.push(of_level);
            }
        }
        (all, changes)
    }
}

impl Before {
    fn position(&self, slot: Slot, now: &[Vector]) -> Vector {
        let at = self.runs.partition_point(|&(start, _)| start <= slot.0);
        match at.checked_sub(1) {
            Some(run) if slot.0 < self.ends[run] => {
                let (start, first) = self.runs[run];
                self.positions[first + (slot.0 - start) as usize]
            }
            _ => now[slot.index()],
        }
    }

    fn turned(&self, surface: &Surface, level: Level) -> Vec<(Odd, Vector)> {
        let layout = surface.hierarchy().layout(level);
        let now = surface.scaling(level);
        let turn_one = |&(odd, detail): &(Odd, Vector)| {
            let site = layout.odd_site(odd);
            let [u, w] = layout.parents(site);
            let sides = opposite(layout, site)?;
            let corners = [u, w, sides[0], sides[1]].map(|s: Site| layout.slot(s));
            let after = corners.map(|slot| now[slot.index()]);
            let before = corners.map(|slot| self.position(slot, now));
            // Where neither parent moved there is nothing to follow.
            if detail == [0; 3] || before[..2] == after[..2] {
                return None;
            }
            let rotation = rotation(before.map(steps), after.map(steps))?;
            let change = minus(turned(&rotation, steps(detail)), steps(detail));
            let change = change.map(|x| x.round() as i32);
            (change != [0; 3]).then_some((odd, change))
        };
        self.odds.par_iter().with_min_len(TASK).filter_map(turn_one).collect()
    }
}

/// The rotation, as the images of the three axes, that takes the frame of `u, w, a, b` to that of the same vertices
/// later; the edge is `u w`, the side `a b`. Frames without an area turn nothing.
fn rotation(from: [Steps; 4], to: [Steps; 4]) -> Option<[Steps; 3]> {
    let frame = |[u, w, a, b]: [Steps; 4]| {
        let x = unit(minus(w, u));
        let z = unit(cross(x, minus(a, b)));
        (dot(x, x) > 0.5 && dot(z, z) > 0.5).then(|| [x, cross(z, x), z])
    };
    let (from, to) = (frame(from)?, frame(to)?);
    // Σ to_k from_kᵀ, by columns.
    Some(std::array::from_fn(|axis| {
        (0..3).fold([0.0; 3], |column, k| plus(column, times(to[k], from[k][axis])))
    }))
}
