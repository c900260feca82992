//! What a surface is besides connectivity and coefficients, and surfaces made from positions.

use super::{DEFAULT_PRECISION, NotPlaceable, Placement, Surface, UpAxis};
use crate::hierarchy::Hierarchy;
use crate::memory::Buffer;
use crate::wavelet::{Scheme, ValenceTooHigh, Wavelet};
use thiserror::Error;

/// What a surface is besides connectivity and coefficients.
#[derive(Debug, Clone, PartialEq)]
pub struct Form {
    /// How odd vertices are predicted.
    pub scheme: Scheme,
    /// Which wavelets.
    pub wavelet: Wavelet,
    /// Bits of precision at import.
    pub precision: u8,
    /// Where the lattice lies in model space.
    pub placement: Placement,
}

/// The choices from which a form is made; the placement follows from the positions.
#[derive(Debug, Clone, PartialEq)]
pub struct FormOptions {
    /// How odd vertices are predicted.
    pub scheme: Scheme,
    /// Which wavelets.
    pub wavelet: Wavelet,
    /// Bits of precision.
    pub precision: u8,
    /// The model's up axis.
    pub up: UpAxis,
    /// The model's unit, free text.
    pub unit: String,
}

impl Default for FormOptions {
    fn default() -> Self {
        Self {
            scheme: Scheme::Linear,
            wavelet: Wavelet::Disc(2),
            precision: DEFAULT_PRECISION,
            up: UpAxis::Y,
            unit: String::new(),
        }
    }
}

/// Bytes that the name of a unit may take.
const LONGEST_UNIT: usize = 64;

/// Why positions over a hierarchy make no surface.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum NotASurface {
    /// The positions cannot be placed.
    #[error("{0}; check the model's coordinates")]
    NotPlaceable(#[from] NotPlaceable),
    /// The unit's name is not a name.
    #[error("the unit is {bytes} bytes long, more than 64; give a short name such as mm")]
    Unit {
        /// Its length.
        bytes: usize,
    },
    /// A neighbourhood is too large.
    #[error("{0}")]
    Valence(#[from] ValenceTooHigh),
}

impl Surface {
    /// A surface from model positions by slot of the finest level, each rounded to the nearest step. `O(n_J)`.
    ///
    /// # Errors
    /// Positions that cannot be placed, a unit that is no name, or a base mesh whose valences the wavelet cannot serve.
    ///
    /// # Panics
    /// If there are not exactly `n_J` positions.
    pub fn from_positions(
        hierarchy: Hierarchy,
        positions: &[[f64; 3]],
        options: &FormOptions,
    ) -> Result<Self, NotASurface> {
        if options.unit.len() > LONGEST_UNIT {
            return Err(NotASurface::Unit { bytes: options.unit.len() });
        }
        let mut placement = Placement::around(positions, options.precision)?;
        placement.up = options.up;
        placement.unit.clone_from(&options.unit);
        let finest = Buffer::of(positions.len(), |at| placement.to_steps(positions[at]));
        let FormOptions { scheme, wavelet, precision, .. } = *options;
        Ok(Self::from_finest(hierarchy, Form { scheme, wavelet, precision, placement }, finest)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hierarchy::{BaseMesh, Level};
    use crate::mesh::shapes;
    use std::sync::Arc;

    #[test]
    fn a_unit_is_a_short_name() {
        let mesh = shapes::tetrahedron();
        let base = BaseMesh::new(4, mesh.faces, &[]).expect("a base mesh");
        let hierarchy = Hierarchy::new(Arc::new(base), Level(0)).expect("small");
        let with = |unit: String| {
            let options = FormOptions { unit, ..FormOptions::default() };
            Surface::from_positions(hierarchy.clone(), &mesh.positions, &options).err()
        };
        assert_eq!(with("mm".into()), None);
        assert_eq!(with("x".repeat(70_000)), Some(NotASurface::Unit { bytes: 70_000 }));
    }
}
