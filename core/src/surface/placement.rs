//! Where the integer surface stands in the model's own space.

use thiserror::Error;

/// Which axis of the model points up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum UpAxis {
    /// The y axis, as in most model files.
    #[default]
    Y,
    /// The z axis, as in most scans and CAD files.
    Z,
    /// The x axis, as in some files of machine parts.
    X,
}

impl UpAxis {
    /// All of them, the usual one first.
    pub const ALL: [UpAxis; 3] = [UpAxis::Y, UpAxis::Z, UpAxis::X];

    /// The number that stands for it in files.
    pub fn code(self) -> u8 {
        match self {
            UpAxis::Y => 0,
            UpAxis::Z => 1,
            UpAxis::X => 2,
        }
    }

    /// The axis with a given code.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|up| up.code() == code)
    }
}

impl std::fmt::Display for UpAxis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            UpAxis::Y => "y",
            UpAxis::Z => "z",
            UpAxis::X => "x",
        })
    }
}

/// Precision in bits when nothing else is asked for.
pub const DEFAULT_PRECISION: u8 = 24;

/// The range of precisions: steps of half the longest bounding-box side × 2^−bits.
pub const PRECISIONS: std::ops::RangeInclusive<u8> = 8..=25;

/// Coordinates and coefficients stay within ± this many steps.
pub const LIMIT: i32 = 1 << 27;

/// Why positions cannot be placed on the integer lattice.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum NotPlaceable {
    /// All vertices coincide.
    #[error("all vertices lie at one point")]
    NoExtent,
    /// A coordinate is not a finite number.
    #[error("vertex {vertex} has a coordinate that is not a finite number")]
    NotFinite {
        /// The vertex.
        vertex: usize,
    },
    /// The model is so far from its origin or so small that steps vanish.
    #[error("the model spans {extent:e} units, outside what 64-bit numbers can place")]
    Extent {
        /// The longest side of the bounding box.
        extent: f64,
    },
    /// The precision is out of range.
    #[error("a precision of {bits} bits is outside 8 to 25")]
    Precision {
        /// The precision asked for.
        bits: u8,
    },
}

/// Origin, step, up axis and unit: `x = origin + step · i`.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Model position of the lattice's zero: the middle of the bounding box at import.
    pub origin: [f64; 3],
    /// Model length of one step, `q`.
    pub step: f64,
    /// The model's up axis.
    pub up: UpAxis,
    /// The model's unit of length, free text; empty if unknown.
    pub unit: String,
}

impl Placement {
    /// The placement of a set of model positions: `q` = half the longest bounding-box side × 2^−bits.
    ///
    /// # Errors
    /// See [`NotPlaceable`].
    pub fn around(positions: &[[f64; 3]], bits: u8) -> Result<Self, NotPlaceable> {
        if !PRECISIONS.contains(&bits) {
            return Err(NotPlaceable::Precision { bits });
        }
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for (vertex, p) in positions.iter().enumerate() {
            if p.iter().any(|x| !x.is_finite()) {
                return Err(NotPlaceable::NotFinite { vertex });
            }
            for c in 0..3 {
                low[c] = low[c].min(p[c]);
                high[c] = high[c].max(p[c]);
            }
        }
        let extent = (0..3).map(|c| high[c] - low[c]).fold(0.0, f64::max);
        if extent == 0.0 || positions.is_empty() {
            return Err(NotPlaceable::NoExtent);
        }
        let step = extent * 0.5 / f64::from(1u32 << bits);
        if !(1e-290..1e290).contains(&step) {
            return Err(NotPlaceable::Extent { extent });
        }
        let origin = std::array::from_fn(|c| low[c] * 0.5 + high[c] * 0.5);
        Ok(Self { origin, step, up: UpAxis::default(), unit: String::new() })
    }

    /// The nearest lattice point. Model positions within a few bounding boxes of the origin fit.
    pub fn to_steps(&self, p: [f64; 3]) -> [i32; 3] {
        std::array::from_fn(|c| ((p[c] - self.origin[c]) / self.step).round() as i32)
    }

    /// The model position of a lattice point.
    pub fn to_model(&self, i: [i32; 3]) -> [f64; 3] {
        std::array::from_fn(|c| self.origin[c] + self.step * f64::from(i[c]))
    }

    /// A model vector in whole steps, or `None` if a component is not finite or beyond [`LIMIT`].
    pub fn vector_to_steps(&self, v: [f64; 3]) -> Option<[i32; 3]> {
        let steps = v.map(|x| (x / self.step).round());
        steps.iter().all(|s| s.abs() <= f64::from(LIMIT)).then(|| steps.map(|s| s as i32))
    }

    /// A vector of whole steps in model units.
    pub fn vector_to_model(&self, i: [i32; 3]) -> [f64; 3] {
        i.map(|i| self.step * f64::from(i))
    }

    /// The shortest decimals that [`Placement::vector_to_steps`] reads back as these steps.
    pub fn shortest_decimals(&self, i: [i32; 3]) -> [f64; 3] {
        i.map(|steps| {
            let exact = self.step * f64::from(steps);
            (0..17)
                .filter_map(|digits| format!("{exact:.digits$e}").parse::<f64>().ok())
                .find(|x| (x / self.step).round() == f64::from(steps))
                .unwrap_or(exact)
        })
    }
}
