//! The words of an edit: what the editor does, what a log records and what a script says.
//!
//! An edit carries its operation's version (`"v"`, 1 by default). A version once landed is never changed, only
//! joined by a new one, so old logs replay to the same bits for ever.

use super::equalise::Equalise;
use super::hide::Hide;
use super::levels::Levels;
use super::pull::Pull;
use super::stroke::{Mirror, Stroke};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Scaling coefficient or wavelet coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// `c_i^j`: the surface follows the hat function of level j, finer detail rides along.
    Scaling,
    /// `d_i^j`: the surface follows the wavelet, the coarser shape stays.
    Wavelet,
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Kind::Scaling => "scaling",
            Kind::Wavelet => "wavelet",
        })
    }
}

/// How a neighbourhood move fades from 1 at the edited vertex to 0 at the radius; `t` is distance over radius.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Falloff {
    /// `(1 − t²)²`: flat at both ends.
    #[default]
    Smooth,
    /// `1 − t`.
    Linear,
    /// `(1 − t)²`: a peak.
    Sharp,
    /// 1 everywhere.
    Constant,
}

impl Falloff {
    /// The weight at `t` from 0 to 1.
    pub fn weight(self, t: f64) -> f64 {
        match self {
            Falloff::Smooth => {
                let rest = 1.0 - t * t;
                rest * rest
            }
            Falloff::Linear => 1.0 - t,
            Falloff::Sharp => (1.0 - t) * (1.0 - t),
            Falloff::Constant => 1.0,
        }
    }
}

/// Moves one coefficient, or with a radius its neighbourhood.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Move {
    /// Scaling or wavelet.
    pub kind: Kind,
    /// The level of the coefficients.
    pub level: u8,
    /// The public id of the edited vertex.
    pub vertex: u32,
    /// What is added, in model units.
    pub delta: [f64; 3],
    /// Straight-line reach in model units, between the level's positions at the start of the edit; none: one
    /// coefficient.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub radius: Option<f64>,
    /// How the move fades towards the radius.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub falloff: Option<Falloff>,
    /// Planes that mirror it, from version 2 on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mirror: Option<Mirror>,
    /// Version of the operation.
    #[serde(default = "first", skip_serializing_if = "is_first")]
    pub v: u32,
}

/// Multiplies all wavelet coefficients of one level.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gain {
    /// The level of the wavelets.
    pub level: u8,
    /// 0 erases the level's detail, 1 leaves it, more exaggerates it.
    pub factor: f64,
    /// Version of the operation.
    #[serde(default = "first", skip_serializing_if = "is_first")]
    pub v: u32,
}

/// One edit: one line of a log, one undo step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "edit", rename_all = "lowercase")]
pub enum Edit {
    /// See [`Move`].
    Move(Move),
    /// See [`Gain`].
    Gain(Gain),
    /// See [`Pull`].
    Pull(Pull),
    /// See [`Stroke`].
    Stroke(Stroke),
    /// See [`Equalise`].
    Equalise(Equalise),
    /// See [`Levels`].
    Levels(Levels),
    /// See [`Hide`].
    Hide(Hide),
}

impl Edit {
    /// The version of the operation.
    pub fn version(&self) -> u32 {
        match self {
            Edit::Move(edit) => edit.v,
            Edit::Gain(edit) => edit.v,
            Edit::Pull(edit) => edit.v,
            Edit::Stroke(edit) => edit.v,
            Edit::Equalise(edit) => edit.v,
            Edit::Levels(edit) => edit.v,
            Edit::Hide(edit) => edit.v,
        }
    }
}

impl Move {
    /// The newest version of what it does; older ones replay as they did.
    pub const LATEST_VERSION: u32 = 2;
}

impl fmt::Display for Edit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Edit::Move(edit) => {
                write!(f, "Move {} {} at level {}", edit.kind, edit.vertex, edit.level)?;
                if edit.radius.is_some() { f.write_str(" and around") } else { Ok(()) }
            }
            Edit::Gain(edit) => write!(f, "Gain level {} × {}", edit.level, edit.factor),
            Edit::Pull(edit) => edit.fmt(f),
            Edit::Stroke(edit) => edit.fmt(f),
            Edit::Equalise(edit) => edit.fmt(f),
            Edit::Levels(edit) => edit.fmt(f),
            Edit::Hide(edit) => edit.fmt(f),
        }
    }
}

pub(super) fn first() -> u32 {
    1
}

pub(super) fn is_first(version: &u32) -> bool {
    *version == 1
}
