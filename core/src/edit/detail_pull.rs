//! Pulls of wavelet coefficients: detail of a level, while the coarser form stays to the bit.
//!
//! The paper's wavelet is a hat of the finer level less hats of its own level around, which a raw pull moves as it is. The smooth
//! one is made the same way of functions without creases: each hat is refined by the smooth spread, and the hats' shares
//! are chosen anew so that `c^j` would stay. As many of them as the paper's wavelet has bring that about nearly. What is
//! left of it is dropped, for a pull consists of additions to `d^j` and finer details alone.

use super::plan::EditError;
use super::pull::{Pull, Pulled, Spread};
use super::spread::{Weights, refined};
use super::vocabulary::{Kind, Move};
use super::{Deltas, Region, Turned, added};
use crate::hierarchy::{Layout, Level, Odd, Site, Slot};
use crate::surface::Surface;
use rustc_hash::{FxHashMap, FxHashSet};

/// Wavelet coefficients of several levels, coarse to fine, with their share of each component of the delta; sorted by odd
/// vertex.
pub(super) type Details = Vec<(Level, Vec<(Odd, Weights)>)>;

/// A function on the vertices of a level, sorted by slot.
type Values = Vec<(Slot, Weights)>;

/// Levels above the wavelet's own over which it is refined smoothly: what is finer is flat to the eye.
const SMOOTH_LEVELS: u8 = 4;
/// Levels on which the shares are looked for: finer ones hardly change them.
const SHARING_LEVELS: u8 = 2;
/// How often the shares are corrected, and by how much of what `c^j` still moves. Spread smoothly, a share counts between a
/// quarter and all of itself, so that each time at most six tenths of the error remain.
const CORRECTIONS: usize = 6;
const CORRECTION: f64 = 1.6;
/// Shares of a pull that are too small to be seen.
const LEAST: f64 = 1e-5;

impl Pulled {
    /// The reach of a pull of wavelet coefficients.
    pub(super) fn of_wavelets(surface: &Surface, pull: &Pull) -> Result<Self, EditError> {
        if pull.v < 3 {
            return Err(EditError::WaveletVersion);
        }
        let (Some(vertex), None) = (pull.vertex, pull.at) else { return Err(EditError::WaveletHold) };
        let words = Move {
            kind: Kind::Wavelet,
            level: pull.level,
            vertex,
            delta: pull.delta,
            radius: pull.radius,
            falloff: pull.falloff,
            mirror: pull.mirror,
            v: Move::LATEST_VERSION,
        };
        let (Region::Wavelets(level, odds), without_partner) = Region::of(surface, &words)? else {
            unreachable!("a move of wavelets has a region of wavelets")
        };
        let held = Odd(vertex - surface.hierarchy().layout(level).len());
        let mut details = match pull.spread {
            Spread::Hat => vec![(level, odds)],
            Spread::Smooth => smooth(surface, level, odds),
        };
        let reached = value_at(surface, &details, level, held);
        let scale = if reached > 0.0 { 1.0 / reached } else { 1.0 };
        for (level, of_level) in &mut details {
            let (coarse, fine) =
                (surface.hierarchy().layout(*level), surface.hierarchy().layout(level.finer()));
            of_level.retain_mut(|(odd, w)| {
                let freedom = surface.freedom(level.finer(), fine.slot(coarse.odd_site(*odd)));
                *w = w.map(|x| x * scale * freedom);
                w.iter().any(|x| x.abs() >= LEAST)
            });
        }
        details.retain(|(_, of_level)| !of_level.is_empty());
        Ok(Self { level: level.finer(), weights: Vec::new(), details, without_partner })
    }

    /// The integers that a delta, in steps, adds: each weight times the delta, rounded once.
    pub fn deltas(&self, delta: [i32; 3]) -> Deltas {
        let scaling = self.moved_by(delta);
        let scaling = (!scaling.is_empty()).then_some((self.level, scaling));
        Deltas { scaling, wavelets: self.details_between([[0; 3], delta]), hidden: Vec::new() }
    }

    /// What is missing from the detail that one delta adds to that which another adds.
    pub(crate) fn details_between(&self, deltas: [[i32; 3]; 2]) -> Turned {
        let of_level = |(level, region): &(Level, Vec<(Odd, Weights)>)| (*level, added(region, deltas));
        self.details.iter().map(of_level).collect()
    }
}

/// The details of smooth wavelets with these shares.
fn smooth(surface: &Surface, level: Level, odds: Vec<(Odd, Weights)>) -> Details {
    let hierarchy = surface.hierarchy();
    let (coarse, fine) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
    let above = |levels: u8| Level((level.0 + levels).min(surface.finest().0)).max(level.finer());
    let parents: Vec<Site> = odds.iter().flat_map(|&(odd, _)| coarse.parents(coarse.odd_site(odd))).collect();
    let rings = surface.form().wavelet.disc_radius().unwrap_or(0);
    let mut near: Vec<Slot> = coarse.disc(&parents, rings).into_iter().map(|s| coarse.slot(s)).collect();
    near.sort_unstable();
    let hats: Values = odds.into_iter().map(|(odd, w)| (fine.slot(coarse.odd_site(odd)), w)).collect();

    let up_to = above(SHARING_LEVELS);
    let own = refined(hierarchy, level.finer(), hats.clone(), up_to);
    let mut shares: Values = near.iter().map(|&slot| (slot, [0.0; 3])).collect();
    for _ in 0..CORRECTIONS {
        let others = refined(hierarchy, level, shares.clone(), up_to);
        let (_, left) = analysed(surface, difference(&own, &others), up_to, level);
        let left: FxHashMap<Slot, Weights> = left.into_iter().collect();
        for (slot, share) in &mut shares {
            if let Some(left) = left.get(slot) {
                *share = std::array::from_fn(|c| share[c] + CORRECTION * left[c]);
            }
        }
    }
    let up_to = above(SMOOTH_LEVELS);
    let own = refined(hierarchy, level.finer(), hats, up_to);
    let others = refined(hierarchy, level, shares, up_to);
    analysed(surface, difference(&own, &others), up_to, level).0
}

/// The difference of two functions on the vertices of a level, both sorted by slot.
fn difference(a: &[(Slot, Weights)], b: &[(Slot, Weights)]) -> Values {
    let negated = b.iter().map(|&(slot, w)| (slot, w.map(|x| -x)));
    let mut all: Values = a.iter().copied().chain(negated).collect();
    // Stable: where both have a vertex, `a` comes first.
    all.sort_by_key(|&(slot, _)| slot);
    let sum = |of_slot: &[(Slot, Weights)]| {
        let zero: Weights = [0.0; 3];
        (of_slot[0].0, of_slot.iter().fold(zero, |sum, (_, w)| std::array::from_fn(|c| sum[c] + w[c])))
    };
    all.chunk_by(|a, b| a.0 == b.0).map(sum).collect()
}

/// The analysis of a function given on the vertices of a level `from` down to a level `to`: the details of every level
/// between, and `c^to`. Linear, in floats.
fn analysed(
    surface: &Surface,
    mut values: Vec<(Slot, Weights)>,
    from: Level,
    to: Level,
) -> (Details, Values) {
    let mut details = Details::new();
    for level in (to.0..from.0).rev().map(Level) {
        let (of_level, coarser) = one_coarser(surface, &values, level);
        details.push((level, of_level));
        values = coarser;
    }
    details.reverse();
    (details, values)
}

fn one_coarser(surface: &Surface, values: &[(Slot, Weights)], level: Level) -> (Vec<(Odd, Weights)>, Values) {
    let (coarse, fine) = (surface.hierarchy().layout(level), surface.hierarchy().layout(level.finer()));
    let by_slot: FxHashMap<Slot, Weights> = values.iter().copied().collect();
    let value = |site: Site| by_slot.get(&fine.slot(site)).copied().unwrap_or_default();
    let (mut odds, mut evens) = (FxHashSet::default(), FxHashSet::default());
    for &(slot, _) in values {
        let site = fine.site(slot);
        match Layout::coarsen(site) {
            None => {
                odds.insert(coarse.odd_at(site));
            }
            Some(even) => {
                evens.insert(coarse.slot(even));
                fine.for_each_neighbour(site, |odd| {
                    odds.insert(coarse.odd_at(odd));
                });
            }
        }
    }
    let mut odds: Vec<Odd> = odds.into_iter().collect();
    odds.sort_unstable();
    let detail = |odd: Odd| {
        let site = coarse.odd_site(odd);
        let [u, w] = coarse.parents(site).map(|parent| value(Layout::refine(parent)));
        let own = value(site);
        let detail: Weights = std::array::from_fn(|c| own[c] - 0.5 * (u[c] + w[c]));
        (detail != [0.0; 3]).then_some((odd, detail))
    };
    let details: Vec<(Odd, Weights)> = odds.into_iter().filter_map(detail).collect();
    if let Some(rings) = surface.form().wavelet.disc_radius() {
        let parents: Vec<Site> =
            details.iter().flat_map(|&(odd, _)| coarse.parents(coarse.odd_site(odd))).collect();
        evens.extend(coarse.disc(&parents, rings).into_iter().map(|site| coarse.slot(site)));
    }
    let mut evens: Vec<Slot> = evens.into_iter().collect();
    evens.sort_unstable();
    let by_odd: FxHashMap<Odd, Weights> = details.iter().copied().collect();
    let updated = |slot: Slot| {
        let site = coarse.site(slot);
        let (own, update) = (value(Layout::refine(site)), update(surface, level, site, &by_odd));
        (slot, std::array::from_fn(|c| own[c] + update[c]))
    };
    let coarser = evens.into_iter().map(updated).filter(|(_, w)| *w != [0.0; 3]).collect();
    (details, coarser)
}

/// What details of a level add to an even vertex: a sum in ascending order of the odd vertices, whatever the order in which the
/// filters have them.
fn update(surface: &Surface, level: Level, even: Site, details: &FxHashMap<Odd, Weights>) -> Weights {
    let mut taps: Vec<(Odd, i32)> = Vec::new();
    surface.filters().for_each_tap(surface.hierarchy().layout(level), even, |odd, weight| {
        if details.contains_key(&odd) {
            taps.push((odd, weight));
        }
    });
    taps.sort_unstable_by_key(|&(odd, _)| odd);
    taps.into_iter().fold([0.0; 3], |sum, (odd, weight)| {
        let (weight, detail) = (f64::from(weight) / f64::from(1 << 20), details[&odd]);
        std::array::from_fn(|c| sum[c] + weight * detail[c])
    })
}

/// How far the odd vertex of the coarsest of some details moves with them for a delta of 1 along the first axis.
fn value_at(surface: &Surface, details: &Details, level: Level, odd: Odd) -> f64 {
    let hierarchy = surface.hierarchy();
    let layout = hierarchy.layout(level);
    // As a vertex of the level finer than the coarsest details, and then of one level after another.
    let mut site = layout.odd_site(odd);
    let mut value = 0.0;
    for (of, of_level) in details {
        let by_odd: FxHashMap<Odd, Weights> = of_level.iter().copied().collect();
        if *of == level {
            let [u, w] = layout.parents(site).map(|parent| update(surface, level, parent, &by_odd)[0]);
            value += by_odd.get(&odd).map_or(0.0, |own| own[0]) - 0.5 * (u + w);
        } else {
            value -= update(surface, *of, site, &by_odd)[0];
            site = Layout::refine(site);
        }
    }
    value
}
