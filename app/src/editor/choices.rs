//! What a user chooses for an import.

use crate::opening::ImportOptions;
use bozzetto_core::conversion::{Axis, ConversionOptions, Remesh};
use bozzetto_core::surface::{DEFAULT_PRECISION, FormOptions, Placement, UpAxis};
use bozzetto_core::wavelet::{Scheme, Wavelet};

/// Units of length that the dialog offers; the first is none known.
pub(super) const UNITS: [&str; 5] = ["", "mm", "cm", "m", "in"];

/// What is imported.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ImportFrom {
    /// A mesh file, by its path as typed.
    File(String),
    /// The surface that is open, by its name.
    Surface(String),
}

/// The choices of the import dialog.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportChoices {
    /// What is imported.
    pub from: ImportFrom,
    /// Whether to convert.
    pub remesh: Remesh,
    /// So many levels; otherwise chosen from the mesh's size.
    pub levels: Option<u8>,
    /// At most so many base faces; otherwise chosen from the mesh's size.
    pub base_faces: Option<usize>,
    /// The greatest distance allowed, over the diagonal; or none is demanded.
    pub tolerance: Option<f64>,
    /// The angle in degrees above which edges stay sharp; otherwise they do on meshes that look made.
    pub sharp_angle: Option<f64>,
    /// Along which axis of the model the base mesh is its own mirror image, if it is to be.
    pub symmetric: Option<Axis>,
    /// Which wavelets.
    pub wavelet: Wavelet,
    /// Bits of precision.
    pub precision: u8,
    /// The model's up axis.
    pub up: UpAxis,
    /// The model's unit of length; empty if unknown.
    pub unit: String,
    /// What reading the mesh has shown, in a sentence.
    pub found: String,
}

impl ImportChoices {
    /// The usual choices for a file.
    pub fn file(path: String) -> Self {
        Self {
            from: ImportFrom::File(path),
            remesh: Remesh::Auto,
            levels: None,
            base_faces: None,
            tolerance: None,
            sharp_angle: None,
            symmetric: None,
            wavelet: Wavelet::Disc(2),
            precision: DEFAULT_PRECISION,
            up: UpAxis::Y,
            unit: String::new(),
            found: String::new(),
        }
    }

    /// The usual choices for converting an open surface again; its placement stays.
    pub fn surface(name: String, placement: &Placement) -> Self {
        Self {
            from: ImportFrom::Surface(name),
            remesh: Remesh::Always,
            up: placement.up,
            unit: placement.unit.clone(),
            ..Self::file(String::new())
        }
    }

    /// As options of an import.
    pub fn options(&self) -> ImportOptions {
        let Self { remesh, levels, base_faces, tolerance, sharp_angle, symmetric, .. } = *self;
        let Self { wavelet, precision, up, .. } = *self;
        ImportOptions {
            conversion: ConversionOptions { levels, remesh, base_faces, tolerance, sharp_angle, symmetric },
            form: FormOptions { scheme: Scheme::Linear, wavelet, precision, up, unit: self.unit.clone() },
        }
    }

    /// What is imported, for people.
    pub fn name(&self) -> String {
        match &self.from {
            ImportFrom::File(path) => super::shown_name(path.trim().as_ref()),
            ImportFrom::Surface(name) => name.clone(),
        }
    }
}
