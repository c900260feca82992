//! Detail that follows: after a coarse pull, finer wavelet coefficients turn with the surface under them.
//!
//! Each odd vertex has a frame from connectivity alone: the edge between its parents, and the line between the vertices
//! on either side of it. What takes the frame before the pull to the frame after it turns the coefficient. So relief keeps
//! its height and its angle to the surface where a form bends, and keeps its bits where nothing moved.

use super::apply::trial_of;
use super::brushes::turned;
use super::details::opposite;
use super::pull::Pulled;
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

/// The surface before a pull, where the pull reaches, from its level up to one that is chosen later.
#[derive(Debug, Clone)]
pub struct Follow {
    level: Level,
    /// Details turn whenever one of the four vertices of their frame moves, and not only with their parents.
    by_frame: bool,
    levels: Vec<Before>,
}

/// Additions to wavelet coefficients, coarse to fine: what was turned, among others.
pub type Turned = Vec<(Level, Vec<(Odd, Vector)>)>;

impl Follow {
    /// For a pull of a level and a version, with nothing noted yet.
    pub fn new(level: Level, version: u32) -> Self {
        Self { level, by_frame: version >= 2, levels: Vec::new() }
    }

    /// Notes positions and details of the levels up to `reach` where a trial of the pull moves something. The surface has
    /// to be as before the pull, and is so afterwards. Levels noted once are not looked at again. Cost: the support, twice.
    pub fn note(&mut self, surface: &mut Surface, pulled: &Pulled, reach: Level) {
        let from = self.level.0 + self.levels.len() as u8;
        if from < reach.0 {
            let trial = trial_of(surface, pulled, reach);
            self.levels.extend((from..reach.0).map(|j| Before::of(surface, Level(j), &trial, self.by_frame)));
        }
    }

    /// Turns the details after the pull, level by level up to `reach`, and returns what was added. Cost: the support.
    pub fn turn(&self, surface: &mut Surface, reach: Level) -> (Turned, Changes) {
        let mut all = Vec::new();
        let mut changes = Changes::nothing(surface);
        for (before, level) in self.levels.iter().zip((self.level.0..reach.0).map(Level)) {
            let deltas = before.turned(surface, level, self.by_frame);
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
    /// A level where a trial moves something; the surface is as before the pull.
    fn of(surface: &Surface, level: Level, trial: &Changes, by_frame: bool) -> Self {
        let (coarse, fine) = (surface.hierarchy().layout(level), surface.hierarchy().layout(level.finer()));
        let none = Runs::default();
        let runs_at = |j: Level| match trial.at(j) {
            Moved::Some(runs) => runs,
            _ => &none,
        };
        let mut before = Self::default();
        for run in runs_at(level).iter() {
            before.runs.push((run.start, before.positions.len()));
            before.ends.push(run.end);
            let of_run = &surface.scaling(level)[run.start as usize..run.end as usize];
            before.positions.extend_from_slice(of_run);
        }
        let moved = runs_at(level.finer()).slots().map(|slot| fine.site(slot));
        let mut odds: Vec<Odd> =
            moved.filter(|&site| Layout::coarsen(site).is_none()).map(|site| coarse.odd_at(site)).collect();
        if by_frame {
            odds.extend(across(coarse, runs_at(level)));
        }
        odds.sort_unstable();
        odds.dedup();
        before.odds = odds.into_iter().map(|odd| (odd, surface.wavelets(level)[odd.index()])).collect();
        before
    }

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

    fn turned(&self, surface: &Surface, level: Level, by_frame: bool) -> Vec<(Odd, Vector)> {
        let layout = surface.hierarchy().layout(level);
        let now = surface.scaling(level);
        let turn_one = |&(odd, detail): &(Odd, Vector)| {
            let site = layout.odd_site(odd);
            let [u, w] = layout.parents(site);
            let sides = opposite(layout, site)?;
            let corners = [u, w, sides[0], sides[1]].map(|s: Site| layout.slot(s));
            let after = corners.map(|slot| now[slot.index()]);
            let before = corners.map(|slot| self.position(slot, now));
            let decisive = if by_frame { 4 } else { 2 };
            if detail == [0; 3] || before[..decisive] == after[..decisive] {
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

/// The edges on the border of what moves: neither end moves, but the third vertex of a face beside does, and takes the frame
/// along.
fn across(layout: &Layout, moved: &Runs) -> Vec<Odd> {
    let mut moves = vec![false; layout.len() as usize];
    moved.iter().for_each(|run| moves[run.start as usize..run.end as usize].fill(true));
    let rests = |site: Site| !moves[layout.slot(site).index()];
    let mut odds = Vec::new();
    for site in moved.slots().map(|slot| layout.site(slot)) {
        let mut at_border = false;
        layout.for_each_neighbour(site, |neighbour| at_border |= rests(neighbour));
        if at_border {
            let ring = layout.ring(site);
            let around = ring.around.iter().zip(ring.around.iter().cycle().skip(1)).take(ring.faces());
            let border = around.filter(|&(&a, &b)| rests(a) && rests(b));
            odds.extend(border.map(|(&a, &b)| layout.odd_at(layout.midpoint(a, b))));
        }
    }
    odds
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
