//! The detail equaliser: a gain for the wavelets of every level, over the whole surface or where the mask says.
//!
//! Wavelet coefficients do not see each other, so the order of levels does not matter, and a gain dragged to and fro gives
//! the bits of the last one.

use super::plan::{EditError, existing_level};
use super::vocabulary::{Kind, first, is_first};
use super::{Deltas, Edit, Step};
use crate::hierarchy::{Level, Odd};
use crate::memory::Buffer;
use crate::surface::{Changes, LIMIT, Surface, Vector};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Where an equaliser acts. Hidden vertices stay as they are in any case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Over {
    /// Everywhere.
    #[default]
    All,
    /// Where something is masked, by how much.
    Mask,
    /// Where nothing is masked, by how little.
    Free,
}

impl Over {
    fn is_all(&self) -> bool {
        *self == Self::All
    }
}

/// Multiplies the wavelet coefficients of every level by a gain of its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Equalise {
    /// By level from 0; levels beyond the list keep their detail.
    pub gains: Vec<f64>,
    /// Where.
    #[serde(default, skip_serializing_if = "Over::is_all")]
    pub over: Over,
    /// Version of the operation.
    #[serde(default = "first", skip_serializing_if = "is_first")]
    pub v: u32,
}

impl fmt::Display for Equalise {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Equalise")?;
        for (level, gain) in self.gains.iter().enumerate().filter(|(_, gain)| **gain != 1.0) {
            write!(f, " {level}: × {gain}")?;
        }
        match self.over {
            Over::All => Ok(()),
            Over::Mask => f.write_str(", masked part"),
            Over::Free => f.write_str(", free part"),
        }
    }
}

/// How much of its gain each wavelet of a level takes, from 0 to 255; none: all of it, everywhere.
type Shares = Option<Vec<u8>>;

fn shares(surface: &Surface, level: Level, over: Over) -> Shares {
    let mask = surface.mask();
    if mask.is_unused() && over != Over::Mask {
        return None;
    }
    let hierarchy = surface.hierarchy();
    let (layout, finer) = (hierarchy.layout(level), hierarchy.layout(level.finer()));
    let share = |odd: u32| {
        let slot = finer.slot(layout.odd_site(Odd(odd)));
        let fine = hierarchy.refine_slot(level.finer(), hierarchy.finest(), slot);
        match over {
            _ if mask.is_hidden(fine) => 0,
            Over::All => 255,
            Over::Mask => mask.value(fine),
            Over::Free => 255 - mask.value(fine),
        }
    };
    Some((0..layout.odd_len()).into_par_iter().with_min_len(1024).map(share).collect())
}

/// The details of a level with a gain; `None` if one would leave its range.
pub(super) fn multiplied(before: &[Vector], shares: &Shares, gain: f64) -> Option<Buffer<Vector>> {
    let scaled = |d: &Vector, factor: f64| -> Option<Vector> {
        let d = d.map(|x| (f64::from(x) * factor).round());
        d.iter().all(|x| x.abs() <= f64::from(LIMIT)).then(|| d.map(|x| x as i32))
    };
    match shares {
        None => Buffer::try_of(before.len(), |odd| scaled(&before[odd], gain)),
        Some(shares) => Buffer::try_of(before.len(), |odd| match shares[odd] {
            0 => Some(before[odd]),
            255 => scaled(&before[odd], gain),
            share => scaled(&before[odd], 1.0 + (gain - 1.0) * (f64::from(share) / 255.0)),
        }),
    }
}

/// The details of every level that an equaliser changes. `O(n_J)`.
pub(super) fn plan_equalise(
    surface: &Surface,
    edit: &Equalise,
) -> Result<Vec<(Level, Buffer<Vector>)>, EditError> {
    check(surface, edit)?;
    let mut blocks = Vec::new();
    for (level, &gain) in (0..).map(Level).zip(&edit.gains).filter(|(_, gain)| **gain != 1.0) {
        let shares = shares(surface, level, edit.over);
        let block = multiplied(surface.wavelets(level), &shares, gain).ok_or(EditError::BeyondLimit)?;
        blocks.push((level, block));
    }
    Ok(blocks)
}

fn check(surface: &Surface, edit: &Equalise) -> Result<(), EditError> {
    if edit.v != 1 {
        return Err(EditError::UnknownVersion { version: edit.v });
    }
    if !edit.gains.iter().all(|gain| gain.is_finite()) {
        return Err(EditError::Factor);
    }
    let last = edit.gains.len().saturating_sub(1).min(usize::from(u8::MAX)) as u8;
    existing_level(surface, Kind::Wavelet, last).map(drop)
}

/// An equaliser under the hand: the surface follows its gains.
#[derive(Debug, Clone)]
pub struct Equaliser {
    words: Equalise,
    before: Vec<Buffer<Vector>>,
    shares: Vec<Shares>,
    /// The finest level that follows the hand.
    reach: Level,
}

impl Equaliser {
    /// An equaliser whose gains are all 1. Cost: a copy of all coefficients.
    ///
    /// # Errors
    /// The surface has no wavelets.
    pub fn begin(surface: &Surface, over: Over) -> Result<Self, EditError> {
        let levels = surface.finest().index();
        let words = Equalise { gains: vec![1.0; levels], over, v: 1 };
        check(surface, &words)?;
        let level = |j: usize| Level(j as u8);
        Ok(Self {
            words,
            before: (0..levels).map(|j| surface.wavelets(level(j)).into()).collect(),
            shares: (0..levels).map(|j| shares(surface, level(j), over)).collect(),
            reach: surface.finest(),
        })
    }

    /// The gains and where they act.
    pub fn words(&self) -> &Equalise {
        &self.words
    }

    /// Whether every gain is 1.
    pub fn is_flat(&self) -> bool {
        self.words.gains.iter().all(|&gain| gain == 1.0)
    }

    /// Goes to other gains and synthesises up to a level; what is finer is old until the end. `O(n_reach)`, and the
    /// coefficients of levels whose gain changed.
    ///
    /// # Errors
    /// Gains that mean nothing or lead out of the range of coordinates; the surface is as it was.
    pub fn set(&mut self, surface: &mut Surface, gains: &[f64], reach: Level) -> Result<Changes, EditError> {
        let wanted = Equalise { gains: gains.to_vec(), ..self.words.clone() };
        check(surface, &wanted)?;
        let mut gains = wanted.gains;
        gains.resize(self.before.len(), 1.0);
        let mut old = Vec::new();
        for (j, &gain) in gains.iter().enumerate() {
            if gain != self.words.gains[j] {
                let block = match gain {
                    1.0 => Some(self.before[j].clone()),
                    gain => multiplied(&self.before[j], &self.shares[j], gain),
                };
                let Some(block) = block else { return Err(EditError::BeyondLimit) };
                old.push((Level(j as u8), block));
            }
        }
        // A level that had not followed so far begins with what the coarser ones are now.
        let coarsest = old.first().map(|&(level, _)| level);
        let from = if reach > self.reach { Some(Level::BASE) } else { coarsest };
        let Some(from) = from else { return Ok(Changes::nothing(surface)) };
        for (level, block) in &mut old {
            let now = std::mem::take(block);
            *block = surface.wavelets(*level).into();
            surface.put_details(*level, now);
        }
        let changes = surface.synthesise_from(from, reach);
        if changes.beyond_limit {
            old.into_iter().for_each(|(level, block)| surface.put_details(level, block));
            surface.synthesise_from(from, reach);
            return Err(EditError::BeyondLimit);
        }
        self.words.gains = gains;
        self.reach = reach;
        Ok(changes)
    }

    /// Takes everything back, bit for bit. `O(n_J)`.
    pub fn cancel(mut self, surface: &mut Surface) -> Changes {
        let flat = vec![1.0; self.before.len()];
        let finest = surface.finest();
        self.set(surface, &flat, finest).unwrap_or_else(|_| Changes::all(surface))
    }

    /// Ends it: all levels follow, and what was done becomes a step. `O(n_J)`.
    ///
    /// # Errors
    /// A level that had not followed would leave the range of coordinates; everything is then taken back.
    pub fn finish(mut self, surface: &mut Surface) -> Result<(Step, Changes), EditError> {
        let (gains, finest) = (self.words.gains.clone(), surface.finest());
        let changes = match self.set(surface, &gains, finest) {
            Ok(changes) => changes,
            Err(error) => {
                self.reach = Level::BASE;
                self.cancel(surface);
                return Err(error);
            }
        };
        let wavelets = differences(
            self.before.iter().enumerate().map(|(j, before)| (Level(j as u8), &before[..])),
            |level| surface.wavelets(level),
        );
        surface.resum(&wavelets);
        let deltas = Deltas { wavelets, ..Deltas::default() };
        let mut words = self.words;
        while words.gains.last() == Some(&1.0) {
            words.gains.pop();
        }
        Ok((Step::brushed(Edit::Equalise(words), deltas, Vec::new()), changes))
    }
}

/// What takes some details to others, level by level; levels that agree are left out.
pub(super) fn differences<'a>(
    before: impl Iterator<Item = (Level, &'a [Vector])>,
    after: impl Fn(Level) -> &'a [Vector],
) -> Vec<(Level, Vec<(Odd, Vector)>)> {
    let of_level = |(level, before): (Level, &[Vector])| {
        let after = after(level);
        let delta = |odd: usize| std::array::from_fn(|c| after[odd][c].wrapping_sub(before[odd][c]));
        let deltas: Vec<(Odd, Vector)> = (0..before.len())
            .filter(|&odd| after[odd] != before[odd])
            .map(|odd| (Odd(odd as u32), delta(odd)))
            .collect();
        (level, deltas)
    };
    before.map(of_level).filter(|(_, deltas)| !deltas.is_empty()).collect()
}
