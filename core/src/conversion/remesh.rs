//! The whole conversion: clean, simplify, resample, fit, measure.

use super::clean::clean;
use super::creases::Creases;
use super::density::Density;
use super::domain::Domain;
use super::edge_flips::{flip_edges, open_ears};
use super::fit::{FitRules, fit};
use super::held::Held;
use super::lattice::Lattice;
use super::lay_out::{Input, NoLattice, lay_out};
use super::parameterise::Parameterisation;
use super::pulls::Target;
use super::simplify::{Cancelled, simplify};
use super::walk::Ground;
use super::working_mesh::WorkingMesh;
use crate::hierarchy::{Hierarchy, Level, NotABaseMesh};
use crate::mesh::{CompareError, CompareOptions, Comparison, TriangleMesh, compare};
use glam::DVec3;
use thiserror::Error;

/// How to convert.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RemeshOptions {
    /// At most so many base faces; by default chosen from the size of the mesh.
    pub base_faces: Option<usize>,
    /// Levels J; by default chosen from the size of the mesh.
    pub levels: Option<u8>,
    /// The greatest distance allowed, as a fraction of the bounding-box diagonal; by default none is demanded. It is
    /// compared with what is measured, in [`Remeshed::tolerance_met`].
    pub tolerance: Option<f64>,
    /// Edges whose faces meet at more than this angle become sharp edges of the base mesh; in degrees, 180 for none. By
    /// default they do on meshes that look made, from 20° or 40°. Corners of the boundary are kept in any case.
    pub sharp_angle: Option<f64>,
    /// Vertices no further apart than this, in model units, are merged. Default 0: exact duplicates only.
    pub weld: f64,
}

/// What the conversion is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Repairing the input.
    Clean,
    /// Collapsing edges to the base mesh.
    Simplify,
    /// Placing the vertices of the finest level on the input.
    Resample,
    /// Spacing them evenly.
    Relax,
    /// Moving them so that the surfaces are close everywhere.
    Fit,
    /// Measuring the distance.
    Measure,
}

/// A converted mesh.
#[derive(Debug, Clone)]
pub struct Remeshed {
    /// Base mesh and levels.
    pub hierarchy: Hierarchy,
    /// Positions by slot of the finest level, in model units.
    pub positions: Vec<[f64; 3]>,
    /// What was repaired in the input, one sentence each.
    pub cleaned: Vec<String>,
    /// The distance between the cleaned input and the result.
    pub measured: Comparison,
    /// Whether the greatest distance measured is within the tolerance; `None` if none was demanded.
    pub tolerance_met: Option<bool>,
}

/// Why a mesh was not converted.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum RemeshError {
    /// There is no surface.
    #[error("the mesh has no face with area, so there is no surface; export it with its triangles")]
    Empty,
    /// Too many vertices.
    #[error("{base_faces} base faces at {levels} levels are too many; choose fewer levels")]
    TooFine {
        /// Base faces.
        base_faces: usize,
        /// Levels.
        levels: u8,
    },
    /// The simplified mesh is no base mesh.
    #[error("the simplified mesh cannot be a base mesh: {0}; please report the model")]
    NotABaseMesh(#[from] NotABaseMesh),
    /// The result could not be measured.
    #[error(transparent)]
    Measure(#[from] CompareError),
    /// The progress function asked to stop.
    #[error("the conversion was cancelled")]
    Cancelled,
}

impl From<Cancelled> for RemeshError {
    fn from(_: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Converts any mesh. `progress` takes the phase and the fraction of it that is done, and returns whether to go on.
///
/// Deterministic at any number of threads. Cost: some 8 s for 100,000 faces on two threads.
///
/// # Errors
/// See [`RemeshError`].
pub fn remesh(
    mesh: &TriangleMesh,
    options: &RemeshOptions,
    progress: &dyn Fn(Phase, f32) -> bool,
) -> Result<Remeshed, RemeshError> {
    let check = |phase, done| if progress(phase, done) { Ok(()) } else { Err(RemeshError::Cancelled) };
    check(Phase::Clean, 0.0)?;
    let cleaned = clean(mesh, options.weld).ok_or(RemeshError::Empty)?;
    let input = cleaned.to_mesh();
    let frame = Frame::around(&input).ok_or(RemeshError::Empty)?;
    let unit = frame.into_unit(&input);
    let (target, levels) = sizes(&unit, options);

    check(Phase::Simplify, 0.0)?;
    let places = unit.positions.iter().map(|&p| DVec3::from(p)).collect();
    let most_corners = target / FACES_PER_CORNER;
    let creases = Creases::find(&unit, &cleaned.connectivity, options.sharp_angle, most_corners);
    let mut working = WorkingMesh::new(places, &cleaned.connectivity).with_creases(creases.clone());
    let mut map = Parameterisation::new(unit.faces.len() as u32);
    open_ears(&mut working, &mut map);
    let wanted = target as f64 * f64::from(4u32.pow(levels.into()));
    let mut density = Density::new(&unit, &cleaned.connectivity, wanted, &creases);
    simplify(&mut working, &mut map, target, &density, &|done| progress(Phase::Simplify, done))?;
    open_ears(&mut working, &mut map);
    flip_edges(&mut working, &mut map);

    check(Phase::Resample, 0.0)?;
    let domain = Domain::new(&working, &map)?;
    let ground = Ground { mesh: &unit, connectivity: &cleaned.connectivity };
    let laid = lay_out(
        &Input { mesh: &unit, ground: &ground, domain: &domain },
        &mut density,
        Level(levels),
        &|done| progress(Phase::Relax, done),
    );
    let (lattice, places) = laid.map_err(|why| match why {
        NoLattice::TooFine => RemeshError::TooFine { base_faces: domain.base.faces().len(), levels },
        NoLattice::Cancelled => RemeshError::Cancelled,
    })?;
    let held = Held::new(&lattice, &domain, &places.at, &unit, &creases);
    let Lattice { hierarchy, mut fitted, .. } = lattice;
    fitted.held = held;
    let near = Target::new(&unit, fitted.pattern.faces().len()).ok_or(RemeshError::Empty)?;
    check(Phase::Fit, 0.0)?;
    let positions = fit(&near, &fitted, places.at, &FIT, &|done| progress(Phase::Fit, done))?;

    check(Phase::Measure, 0.0)?;
    let positions: Vec<[f64; 3]> = positions.iter().map(|&p| frame.to_model(p)).collect();
    let result = TriangleMesh { positions, faces: hierarchy.triangles(Level(levels)) };
    let measured =
        compare(&input, &result, &CompareOptions::default(), &|done| progress(Phase::Measure, done))?;
    Ok(Remeshed {
        hierarchy,
        positions: result.positions,
        cleaned: cleaned.report.sentences(),
        measured,
        tolerance_met: options.tolerance.map(|tolerance| measured.max <= tolerance),
    })
}

/// On four scans the first two steps take out most of the error, and no step after the sixth any.
const FIT: FitRules = FitRules { steps: 6, rough: 3, boost_from: 3, smoothing: 0.015 };

/// Where the model lies; the work is done in a box of diagonal 1 around 0.
#[derive(Debug, Clone, Copy)]
struct Frame {
    centre: DVec3,
    diagonal: f64,
}

impl Frame {
    fn around(mesh: &TriangleMesh) -> Option<Self> {
        let bounds = mesh.bounds()?;
        let (min, max) = (DVec3::from(bounds.min), DVec3::from(bounds.max));
        let diagonal = bounds.diagonal();
        (diagonal > 0.0 && diagonal.is_finite()).then(|| Self { centre: min + (max - min) * 0.5, diagonal })
    }

    fn into_unit(self, mesh: &TriangleMesh) -> TriangleMesh {
        let unit = |&p: &[f64; 3]| ((DVec3::from(p) - self.centre) / self.diagonal).to_array();
        TriangleMesh { positions: mesh.positions.iter().map(unit).collect(), faces: mesh.faces.clone() }
    }

    fn to_model(self, p: DVec3) -> [f64; 3] {
        (p * self.diagonal + self.centre).to_array()
    }
}

/// Faces of the finest level by default, for each face of the input.
const FINENESS: f64 = 2.5;
/// Levels by default.
const LEVELS: u8 = 4;
/// Base faces there must be for each corner of sharp edges, when no angle is given.
const FACES_PER_CORNER: usize = 4;
/// The fewest base faces aimed at by default.
const FEWEST_BASE_FACES: usize = 200;

/// Base faces and levels from the options and the size of the input.
fn sizes(mesh: &TriangleMesh, options: &RemeshOptions) -> (usize, u8) {
    let finest = mesh.faces.len() as f64 * FINENESS;
    let levels = options.levels.unwrap_or_else(|| {
        let per_face = finest / options.base_faces.unwrap_or(FEWEST_BASE_FACES) as f64;
        (0..=LEVELS).rev().find(|&j| f64::from(4u32.pow(j.into())) <= per_face).unwrap_or(0).max(1)
    });
    let faces = options.base_faces.unwrap_or((finest / f64::from(4u32.pow(levels.min(12).into()))) as usize);
    (faces.max(4), levels)
}

#[cfg(test)]
mod tests;
