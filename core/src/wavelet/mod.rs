//! Weights, lifting, analysis and synthesis over a hierarchy. Knows connectivity and integers, no geometry.
//!
//! Whole levels are transformed by [`rows`]; [`lifting`] is the plain reference, which gives the same bits.

mod coarse_discs;
mod cones;
mod explicit_rows;
mod filters;
pub mod lifting;
mod regular_disc;
mod regularity;
pub mod rows;
mod solving;
pub mod weights;

pub use filters::{Filters, ValenceTooHigh};
use std::fmt;

/// Which wavelets complete the scaling functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Wavelet {
    /// No update: coarse levels are samples of the finest.
    Lazy,
    /// The k-disc wavelet, k from 0 to 2.
    Disc(u8),
}

impl Wavelet {
    /// All that exist.
    pub const ALL: [Wavelet; 4] = [Wavelet::Lazy, Wavelet::Disc(0), Wavelet::Disc(1), Wavelet::Disc(2)];

    /// The number that stands for it in files: 0 for lazy, k + 1 for a k-disc.
    pub fn code(self) -> u8 {
        match self {
            Wavelet::Lazy => 0,
            Wavelet::Disc(k) => k + 1,
        }
    }

    /// The wavelet with a given code.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|w| w.code() == code)
    }

    /// How far, in steps of level j + 1 and in any barycentric coordinate, a regular stencil reaches.
    pub(crate) fn reach(self) -> i32 {
        match self {
            Wavelet::Lazy => 0,
            Wavelet::Disc(k) => 2 * i32::from(k) + 1,
        }
    }

    /// The radius `k` of the disc that an odd vertex updates, around its edge's ends; `None` if it updates nothing.
    pub fn disc_radius(self) -> Option<u8> {
        match self {
            Wavelet::Lazy => None,
            Wavelet::Disc(k) => Some(k),
        }
    }
}

impl fmt::Display for Wavelet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Wavelet::Lazy => f.write_str("lazy"),
            Wavelet::Disc(k) => write!(f, "{k}-disc"),
        }
    }
}

/// How odd vertices are predicted. `linear` is the midpoint of the edge's ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Scheme {
    /// Piecewise linear: hat functions.
    #[default]
    Linear,
}

impl Scheme {
    /// The number that stands for it in files.
    pub fn code(self) -> u8 {
        match self {
            Scheme::Linear => 0,
        }
    }

    /// The scheme with a given code.
    pub fn from_code(code: u8) -> Option<Self> {
        (code == 0).then_some(Scheme::Linear)
    }
}

impl fmt::Display for Scheme {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("linear")
    }
}
