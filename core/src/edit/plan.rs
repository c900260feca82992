//! Planning: from an edit in model units to integers, with every reason to refuse found before anything changes.

use super::brush_stroke::BrushStroke;
use super::deltas::Deltas;
use super::equalise::{multiplied, plan_equalise};
use super::follow::Follow;
use super::hide::plan_hide;
use super::levels::reshaped;
use super::moved_region::Region;
use super::pull::{Pull, Pulled};
use super::stroke::Dab;
use super::vocabulary::{Edit, Gain, Kind, Move};
use crate::hierarchy::{Level, Odd, Slot};
use crate::memory::Buffer;
use crate::surface::{NotReshaped, Surface, Vector};
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
    /// A mirrored move of the version that knows no mirrors.
    #[error("a \"mirror\" needs version 2 of the move: add \"v\":2")]
    MirrorVersion,
    /// A pull of wavelets of a version that knows none.
    #[error("a pull of \"kind\" wavelet needs version 3: add \"v\":3")]
    WaveletVersion,
    /// A pull of wavelets by a place.
    #[error(
        "a pull of \"kind\" wavelet needs the \"vertex\" that it holds, and no place \"at\" which it holds the surface"
    )]
    WaveletHold,
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
    /// Additions to coefficients of several levels.
    Pulled(Deltas),
    /// All of `d^j` anew, for some levels, coarse to fine.
    Details(Vec<(Level, Buffer<Vector>)>),
    /// Another hierarchy.
    Levels(Box<Surface>),
    /// Vertices of the finest level that are hidden, or shown again.
    Hidden(Vec<Slot>),
    /// Additions to `c^j`, after which the detail of a level and finer ones turns with the surface.
    Follow(Follow, Pulled, Vector),
    /// Dab after dab, each planned from what those before have left.
    Stroke(Box<BrushStroke>, Vec<Dab>),
}

/// Turns an edit into integers. Reads the surface, changes nothing. Cost: the neighbourhood, or for a gain the level.
///
/// # Errors
/// Every reason to refuse but [`EditError::BeyondLimit`] for moves, which only applying can find.
pub fn plan(surface: &Surface, edit: &Edit) -> Result<Plan, EditError> {
    // Some know their versions themselves.
    if edit.version() != 1 && !matches!(edit, Edit::Stroke(_) | Edit::Pull(_) | Edit::Move(_)) {
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
    let (region, _) = Region::of(surface, edit)?;
    let delta = surface.form().placement.vector_to_steps(edit.delta).ok_or(EditError::Delta)?;
    Ok(region.moved_by(delta))
}

fn plan_pull(surface: &Surface, edit: &Pull) -> Result<Plan, EditError> {
    let pulled = Pulled::of(surface, edit)?;
    let delta = surface.form().placement.vector_to_steps(edit.delta).ok_or(EditError::Delta)?;
    Ok(if edit.follow {
        Plan::Follow(Follow::new(Level(edit.level), edit.v), pulled, delta)
    } else {
        Plan::Pulled(pulled.deltas(delta))
    })
}

fn plan_gain(surface: &Surface, edit: &Gain) -> Result<Plan, EditError> {
    if !edit.factor.is_finite() {
        return Err(EditError::Factor);
    }
    let level = existing_level(surface, Kind::Wavelet, edit.level)?;
    let details = multiplied(surface.wavelets(level), &None, edit.factor);
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
