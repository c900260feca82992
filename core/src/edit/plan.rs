//! Planning: from an edit in model units to integers, with every reason to refuse found before anything changes.

use super::brush_stroke::BrushStroke;
use super::equalise::plan_equalise;
use super::hide::plan_hide;
use super::levels::reshaped;
use super::pull::{Pull, Pulled};
use super::region::{neighbourhood_of_odd, neighbourhood_of_slot};
use super::stroke::Dab;
use super::vocabulary::{Edit, Gain, Kind, Move};
use super::weighted::weighted_steps;
use crate::hierarchy::{Level, Odd, PublicId, Slot};
use crate::surface::{LIMIT, NotReshaped, Surface, Vector};
use thiserror::Error;

/// Why an edit is refused. A refused edit changes nothing.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum EditError {
    /// There is no such level.
    #[error("level {level} does not exist: {kind} coefficients run over levels 0 to {last}")]
    UnknownLevel {
        /// The level asked for.
        level: u8,
        /// The kind of coefficient.
        kind: Kind,
        /// The last level there is.
        last: u8,
    },
    /// The surface is its own base mesh and has no wavelets.
    #[error("this surface has one level only and so no wavelet coefficients")]
    NoWavelets,
    /// There is no such vertex at the level.
    #[error("{kind} vertex {vertex} does not exist at level {level}: ids there run from {first} to {last}")]
    UnknownVertex {
        /// The kind of coefficient.
        kind: Kind,
        /// The id asked for.
        vertex: u32,
        /// The level.
        level: u8,
        /// The lowest id.
        first: u32,
        /// The highest id.
        last: u32,
    },
    /// A delta is not a number or far too large.
    #[error("the delta is not finite or reaches beyond what the surface's precision can hold")]
    Delta,
    /// A radius is not a positive number.
    #[error("a radius must be a positive number, and {radius} is not")]
    Radius {
        /// The radius asked for.
        radius: f64,
    },
    /// A falloff without a radius.
    #[error("a falloff needs a radius")]
    FalloffWithoutRadius,
    /// A gain is not a number.
    #[error("a gain factor must be a finite number")]
    Factor,
    /// A stroke with a number that means nothing.
    #[error("a stroke needs a positive radius, finite numbers and at most 4096 dabs")]
    Stroke,
    /// A pull of nothing, or of two things.
    #[error("a pull needs either the \"vertex\" it holds or the place \"at\" which it holds the surface")]
    Hold,
    /// A level cannot be added or taken away.
    #[error("{0}")]
    Levels(#[from] NotReshaped),
    /// A base face that does not exist.
    #[error("base face {face} does not exist: they run from 0 to {last}")]
    UnknownFace {
        /// The face asked for.
        face: u32,
        /// The last there is.
        last: u32,
    },
    /// Copying without a place to copy from.
    #[error("copying detail needs the place it comes \"from\"")]
    NoSource,
    /// The result would leave the range of coordinates.
    #[error("the edit would take the surface beyond the range of its coordinates, ±2^27 steps")]
    BeyondLimit,
    /// A version of the operation that this program does not know.
    #[error("version {version} of this operation is not known here; a newer Bozzetto wrote it")]
    UnknownVersion {
        /// The version asked for.
        version: u32,
    },
}

/// An edit in integers.
#[derive(Debug, Clone)]
pub enum Plan {
    /// Additions to `c^j`.
    Scaling(Level, Vec<(Slot, Vector)>),
    /// Additions to `d^j`.
    Wavelets(Level, Vec<(Odd, Vector)>),
    /// All of `d^j` anew, for some levels, coarse to fine.
    Details(Vec<(Level, Vec<Vector>)>),
    /// Another hierarchy.
    Levels(Box<Surface>),
    /// Vertices of the finest level that are hidden, or shown again.
    Hidden(Vec<Slot>),
    /// Additions to `c^j`, after which the detail of a level and finer ones turns with the surface.
    Follow(Level, Pulled, Vector),
    /// Dab after dab, each planned from what those before have left.
    Stroke(Box<BrushStroke>, Vec<Dab>),
}

/// Turns an edit into integers. Reads the surface, changes nothing. Cost: the neighbourhood, or for a gain the level.
///
/// # Errors
/// Every reason to refuse but [`EditError::BeyondLimit`] for moves, which only applying can find.
pub fn plan(surface: &Surface, edit: &Edit) -> Result<Plan, EditError> {
    // Strokes know the versions of their tools.
    if edit.version() != 1 && !matches!(edit, Edit::Stroke(_)) {
        return Err(EditError::UnknownVersion { version: edit.version() });
    }
    match edit {
        Edit::Move(edit) => plan_move(surface, edit),
        Edit::Gain(edit) => plan_gain(surface, edit),
        Edit::Pull(edit) => plan_pull(surface, edit),
        Edit::Equalise(edit) => Ok(Plan::Details(plan_equalise(surface, edit)?)),
        Edit::Levels(edit) => Ok(Plan::Levels(Box::new(reshaped(surface, edit)?))),
        Edit::Hide(edit) => Ok(Plan::Hidden(plan_hide(surface, edit)?)),
        Edit::Stroke(stroke) => {
            Ok(Plan::Stroke(Box::new(BrushStroke::begin(surface, stroke.clone())?), stroke.dabs.clone()))
        }
    }
}

fn plan_move(surface: &Surface, edit: &Move) -> Result<Plan, EditError> {
    let region = Region::of(surface, edit)?;
    let delta = surface.form().placement.vector_to_steps(edit.delta).ok_or(EditError::Delta)?;
    Ok(region.moved_by(delta))
}

/// The coefficients a move reaches, with their weights from 1 down to 0. Found once, at the start of a stroke.
#[derive(Debug, Clone, PartialEq)]
pub enum Region {
    /// Scaling coefficients of a level, sorted by slot.
    Scaling(Level, Vec<(Slot, f64)>),
    /// Wavelet coefficients of a level.
    Wavelets(Level, Vec<(Odd, f64)>),
    /// Scaling coefficients, with a share of each component.
    Pulled(Pulled),
}

impl Region {
    /// The region of a move, whatever its delta. Cost: the neighbourhood.
    ///
    /// # Errors
    /// Unknown level or vertex, or a radius or falloff that makes no sense.
    pub fn of(surface: &Surface, edit: &Move) -> Result<Self, EditError> {
        let level = existing_level(surface, edit.kind, edit.level)?;
        let layout = surface.hierarchy().layout(level);
        let (first, count) = match edit.kind {
            Kind::Scaling => (0, layout.len()),
            Kind::Wavelet => (layout.len(), layout.odd_len()),
        };
        let (vertex, last) = (edit.vertex, first + count - 1);
        if !(first..=last).contains(&vertex) {
            return Err(EditError::UnknownVertex { kind: edit.kind, vertex, level: edit.level, first, last });
        }
        let falloff = edit.falloff.unwrap_or_default();
        let radius = match edit.radius {
            None if edit.falloff.is_some() => return Err(EditError::FalloffWithoutRadius),
            Some(radius) if !(radius.is_finite() && radius > 0.0) => {
                return Err(EditError::Radius { radius });
            }
            radius => radius.map(|r| r / surface.form().placement.step),
        };
        Ok(match edit.kind {
            Kind::Scaling => {
                let slot = layout.slot(layout.site_of(PublicId(vertex)));
                let mut region = match radius {
                    None => vec![(slot, 0.0)],
                    Some(radius) => neighbourhood_of_slot(surface, level, slot, radius),
                };
                // In the order of storage, which following a hand goes through again and again.
                region.sort_unstable_by_key(|&(slot, _)| slot);
                Region::Scaling(level, region.into_iter().map(|(s, t)| (s, falloff.weight(t))).collect())
            }
            Kind::Wavelet => {
                let odd = Odd(vertex - first);
                let region = match radius {
                    None => vec![(odd, 0.0)],
                    Some(radius) => neighbourhood_of_odd(surface, level, odd, radius),
                };
                Region::Wavelets(level, region.into_iter().map(|(o, t)| (o, falloff.weight(t))).collect())
            }
        })
    }

    /// The integers that a delta, in steps, adds: each weight times the delta, rounded once.
    pub fn moved_by(&self, delta: Vector) -> Plan {
        match self {
            Region::Scaling(level, region) => Plan::Scaling(*level, added(region, [[0; 3], delta])),
            Region::Wavelets(level, region) => Plan::Wavelets(*level, added(region, [[0; 3], delta])),
            Region::Pulled(pulled) => Plan::Scaling(pulled.level, pulled.moved_by(delta)),
        }
    }
}

/// What is missing from the integers that one delta adds to those that another adds.
pub(crate) fn added<T: Copy>(region: &[(T, f64)], deltas: [Vector; 2]) -> Vec<(T, Vector)> {
    let weights: Vec<[f64; 3]> = region.iter().map(|&(_, weight)| [weight; 3]).collect();
    let mut steps = Vec::new();
    weighted_steps(&weights, deltas, &mut steps);
    region.iter().zip(steps).map(|(&(at, _), step)| (at, step)).collect()
}

fn plan_pull(surface: &Surface, edit: &Pull) -> Result<Plan, EditError> {
    let pulled = Pulled::of(surface, edit)?;
    let delta = surface.form().placement.vector_to_steps(edit.delta).ok_or(EditError::Delta)?;
    Ok(if edit.follow {
        Plan::Follow(Level(edit.level), pulled, delta)
    } else {
        Plan::Scaling(pulled.level, pulled.moved_by(delta))
    })
}

fn plan_gain(surface: &Surface, edit: &Gain) -> Result<Plan, EditError> {
    if !edit.factor.is_finite() {
        return Err(EditError::Factor);
    }
    let level = existing_level(surface, Kind::Wavelet, edit.level)?;
    let scaled = |x: i32| {
        let x = (f64::from(x) * edit.factor).round();
        (x.abs() <= f64::from(LIMIT)).then_some(x as i32)
    };
    let details: Option<Vec<Vector>> =
        surface.wavelets(level).iter().map(|d| Some([scaled(d[0])?, scaled(d[1])?, scaled(d[2])?])).collect();
    Ok(Plan::Details(vec![(level, details.ok_or(EditError::BeyondLimit)?)]))
}

pub(super) fn existing_level(surface: &Surface, kind: Kind, level: u8) -> Result<Level, EditError> {
    let finest = surface.finest().0;
    let last = match (kind, finest) {
        (Kind::Scaling, _) => finest,
        (Kind::Wavelet, 0) => return Err(EditError::NoWavelets),
        (Kind::Wavelet, _) => finest - 1,
    };
    if level > last { Err(EditError::UnknownLevel { level, kind, last }) } else { Ok(Level(level)) }
}
