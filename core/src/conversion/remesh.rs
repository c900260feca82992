//! The whole conversion: clean, simplify, resample, fit, measure.

use super::approach::{Features, approach};
use super::attempts::{Attempts, Found};
use super::clean::clean_while;
use super::creases::Creases;
use super::density::Density;
use super::domain::Domain;
use super::edge_flips::{flip_edges, open_ears};
use super::fit::{FitRules, fit};
use super::halve::Half;
use super::held::Held;
use super::lattice::Lattice;
use super::lay_out::{Input, NoLattice, Spacing, lay_out};
use super::mend::Mending;
use super::mirror::{Laid, mirrored};
use super::parameterise::Parameterisation;
use super::prepared::{Prepared, beside, working_mesh};
use super::simplify::{Cancelled, simplify};
use super::size::{Size, affordable, as_is, fewest_base_faces};
use super::symmetry::{Axis, NEARLY, mirror_plane};
use super::target::Target;
use super::walk::Ground;
use super::working_mesh::WorkingMesh;
use crate::hierarchy::{Hierarchy, Level, NotABaseMesh};
use crate::mesh::{CompareError, CompareOptions, Comparison, TriangleMesh, compare_with};
use glam::DVec3;
use thiserror::Error;

/// How to convert.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct RemeshOptions {
    /// At most so many base faces; by default chosen from the size of the mesh.
    pub base_faces: Option<usize>,
    /// Levels J; by default chosen from the size of the mesh.
    pub levels: Option<u8>,
    /// The greatest distance allowed, as a fraction of the bounding-box diagonal; by default none is demanded. Levels and
    /// base faces that are not given grow until it is met, within bounds; [`Remeshed::tolerance_met`] says whether it is.
    pub tolerance: Option<f64>,
    /// Edges whose faces meet at more than this angle become sharp edges of the base mesh; in degrees, 180 for none. By
    /// default they do on meshes that look made, from 20° or 40°. Marked edges are sharp in any case, and corners of the
    /// boundary are kept.
    pub sharp_angle: Option<f64>,
    /// Makes the base mesh its own mirror image along an axis: the mesh must be nearly symmetric in a plane across it. By
    /// default it need not be.
    pub symmetric: Option<Axis>,
    /// Vertices no further apart than this, in model units, are merged. Default 0: exact duplicates only.
    pub weld: f64,
}

/// What the conversion is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Looking for subdivision connectivity, before anything is remeshed.
    Detect,
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
    /// The two sides of the mesh differ too much for a mirrored base mesh.
    #[error(
        "mirrored along {axis} the mesh is {:.1} % of its diagonal off itself (root mean square), and at most {:.1} % is nearly symmetric; turn it so that its sides face along {axis}, choose another axis, or import it without symmetry",
        rms * 100.0, NEARLY * 100.0
    )]
    NotSymmetric {
        /// The axis asked for.
        axis: Axis,
        /// Root mean square of the distance between the mesh and its mirror image, over the diagonal.
        rms: f64,
    },
    /// Half of the mesh and its mirror image do not make the topology of the mesh.
    #[error(
        "the two sides of the mesh along {axis} differ in handles, holes or parts, so no base mesh of it is symmetric; mend them to be alike, or import it without symmetry"
    )]
    SidesDiffer {
        /// The axis asked for.
        axis: Axis,
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
/// Where a tolerance is demanded, phases are gone through again with more faces until it is met or nothing more is
/// allowed; the closest result is returned.
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
    if !progress(Phase::Clean, 0.0) {
        return Err(RemeshError::Cancelled);
    }
    let go_on = || progress(Phase::Clean, 0.0);
    let cleaned = clean_while(mesh, options.weld, &go_on)?.ok_or(RemeshError::Empty)?;
    let input = cleaned.to_mesh();
    let mut frame = Frame::around(&input).ok_or(RemeshError::Empty)?;
    if let Some(axis) = options.symmetric {
        let plane = mirror_plane(&input, axis, &go_on)?;
        frame = frame.about(axis, plane);
    }
    let fewest = fewest_base_faces(cleaned.connectivity.genus(), cleaned.connectivity.boundary_loops());
    let mut prepared = Prepared::new(frame.into_unit(&input), cleaned.connectivity, &|done| {
        progress(Phase::Simplify, done)
    })?;
    if let Some(axis) = options.symmetric {
        let half = Half::of(&prepared.ground, &prepared.connectivity);
        prepared.half = Some(half.ok_or(RemeshError::SidesDiffer { axis })?);
    }
    let mut best: Option<(f64, Remeshed)> = None;
    let mut next = Some(Size::first(input.faces.len(), fewest, options));
    let mut attempts = Attempts::new();
    let mut target = None;
    while let Some(size) = next {
        let fewer_levels = options.levels.is_none() && (best.is_none() || options.tolerance.is_none());
        let unfolding = attempts.unfolding(options);
        let free = options.base_faces.is_none() && options.tolerance.is_none() && options.symmetric.is_none();
        let as_is = fewer_levels && free;
        let how = How { fewer_levels, as_is, sharp_angle: options.sharp_angle, unfolding };
        let made = match attempt(&prepared, &mut target, size, how, progress) {
            // What was made before stands.
            Err(RemeshError::TooFine { .. }) if best.is_some() => break,
            made => made?,
        };
        let unit: Vec<[f64; 3]> = made.positions.iter().map(|p| p.to_array()).collect();
        let result = TriangleMesh::new(unit, made.faces);
        let samples =
            if options.tolerance.is_some() { CLOSE_SAMPLES } else { CompareOptions::default().samples };
        let rules = CompareOptions { samples, ..CompareOptions::default() };
        let tree = target.as_ref().map(|target: &Target| &*target.tree);
        let (unit_input, tree) = match &prepared.without_rings {
            Some(input) => (input, None),
            None => (&prepared.target, tree),
        };
        let go_on = |done| progress(Phase::Measure, done);
        let measured = compare_with(unit_input, tree, &result, &rules, &go_on)?;
        let looks = target.as_ref().map_or(0, Target::looks);
        let found = Found { measured, turned: made.turned, looks };
        next = attempts.next(made.size, &found, &input, options);
        let badness = found.badness(options);
        if best.as_ref().is_none_or(|best| badness < best.0) {
            let result = Remeshed {
                hierarchy: made.hierarchy,
                positions: made.positions.iter().map(|&p| frame.to_model(p)).collect(),
                cleaned: Vec::new(),
                measured,
                tolerance_met: options.tolerance.map(|tolerance| measured.max <= tolerance),
            };
            best = Some((badness, result));
        }
    }
    let (_, best) = best.expect("a first attempt was made");
    let mut sentences = cleaned.report.sentences();
    if !mesh.sharp_edges.is_empty() && best.hierarchy.base().sharp_edges().is_empty() {
        let count = mesh.sharp_edges.len();
        sentences.push(format!(
            "none of the {count} edges marked as sharp was kept: they are no edges inside the surface, or meet in too many corners for so few base faces"
        ));
    }
    Ok(Remeshed { cleaned: sentences, ..best })
}

/// Base faces there must be for each corner of sharp edges, when no angle is given.
const FACES_PER_CORNER: usize = 4;
/// Samples on each surface when a greatest distance was promised.
const CLOSE_SAMPLES: usize = 1_000_000;

/// What one attempt makes; positions in the unit box.
struct Made {
    /// What was aimed at in the end.
    size: Size,
    hierarchy: Hierarchy,
    positions: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    /// How many of them are turned over.
    turned: usize,
}

/// How an attempt is made.
#[derive(Debug, Clone, Copy)]
struct How {
    /// Whether levels are left out if the base mesh is much larger than aimed at.
    fewer_levels: bool,
    /// Whether what lies in a tangle, and is too large to be made twice, is laid out as simplification leaves it.
    as_is: bool,
    sharp_angle: Option<f64>,
    /// See [`Mending`].
    unfolding: u64,
}

/// The conversion but for cleaning and measuring. The first attempt leaves the target to the next ones.
fn attempt<'m>(
    prepared: &'m Prepared,
    target: &mut Option<Target<'m>>,
    size: Size,
    How { fewer_levels, as_is: may_stay, sharp_angle, unfolding }: How,
    progress: &dyn Fn(Phase, f32) -> bool,
) -> Result<Made, RemeshError> {
    let check = |phase| if progress(phase, 0.0) { Ok(()) } else { Err(RemeshError::Cancelled) };
    let Size { base_faces: aim, levels, spacing, closely } = size;
    let Prepared { faces, target: input, tree, ground, connectivity, half, .. } = prepared;
    check(Phase::Simplify)?;
    let (whole, connectivity) = match half {
        None => (ground, connectivity),
        Some(half) => (&half.whole, &half.whole_connectivity),
    };
    let most_corners = aim / FACES_PER_CORNER;
    let creases = Creases::find(whole, connectivity, sharp_angle, most_corners);
    let wanted = aim as f64 * f64::from(4u32.pow(levels.into()));
    let go_on = || progress(Phase::Simplify, 0.0);
    let mut density = Density::new_while(whole, connectivity, wanted, &creases, &go_on)?;
    let (mesh, connectivity, sides, mut working) = match half {
        None => (whole, connectivity, 1, working_mesh(whole, connectivity).with_creases(creases.clone())),
        Some(half) => {
            density = density.of_first(half.mesh.positions.len());
            let working = working_mesh(&half.mesh, &half.connectivity).with_seam(half.seam.clone());
            (&half.mesh, &half.connectivity, 2, working.with_creases(half.creases(&creases)))
        }
    };
    let mut map = Parameterisation::new(mesh.faces.len() as u32);
    open_ears(&mut working, &mut map);
    beside(
        |go_on| {
            if target.is_none() {
                *target = Target::new_while(input, tree.as_ref(), go_on);
            }
        },
        || simplify(&mut working, &mut map, aim / sides, &density, &|done| progress(Phase::Simplify, done)),
    )?;
    open_ears(&mut working, &mut map);
    if may_stay
        && prepared.connectivity.genus() >= MANY_HANDLES
        && tiny_part(&working) > MOST_TINY
        && let Some(size) = as_is(size, ground.faces.len())
    {
        let how = How { fewer_levels: false, as_is: false, sharp_angle, unfolding };
        return attempt(prepared, target, size, how, progress);
    }
    if spacing != Spacing::AsIs {
        flip_edges(&mut working, &mut map);
    }

    check(Phase::Resample)?;
    let domain = Domain::new(&working, &map)?;
    let base_faces = sides * domain.base.faces().len();
    if fewer_levels && let Some(size) = affordable(size, base_faces, *faces) {
        let how = How { fewer_levels: false, as_is: false, sharp_angle, unfolding };
        return attempt(prepared, target, size, how, progress);
    }
    let ground = Ground { mesh, connectivity };
    let laid = lay_out(
        &Input { mesh, ground: &ground, domain: &domain },
        &mut density,
        Level(levels),
        spacing,
        &|done| progress(Phase::Relax, done),
    );
    let (lattice, places) = laid.map_err(|why| match why {
        NoLattice::TooFine => RemeshError::TooFine { base_faces, levels },
        NoLattice::Cancelled => RemeshError::Cancelled,
    })?;
    let sheets = places.points.iter().map(|point| ground.normal(point.face));
    let mut laid = if half.is_some() {
        let laid: Vec<(DVec3, DVec3)> = places.at.iter().copied().zip(sheets).collect();
        let pinned: Vec<bool> = working.live_vertices().map(|v| creases.corners[v as usize]).collect();
        mirrored(&lattice, &domain, &laid, &pinned)?.ok_or(RemeshError::TooFine { base_faces, levels })?
    } else {
        let (sheets, pinned) = (sheets.collect(), domain.pinned.clone());
        let Lattice { hierarchy, fitted, .. } = lattice;
        Laid { hierarchy, fitted, places: places.at, sheets, pinned }
    };
    check(Phase::Fit)?;
    let near = target.take().ok_or(RemeshError::Empty)?.sampled(laid.fitted.pattern.faces().len());
    let near = target.insert(near);
    let (mut mesh, mut creases) = (whole, creases);
    if half.is_some() {
        let own = Creases::find(&prepared.ground, &prepared.connectivity, sharp_angle, most_corners);
        if own.edges().next().is_some() {
            (mesh, creases) = (&prepared.ground, own);
        }
        approach(near, &Features { mesh, creases: &creases }, &mut laid, &|| progress(Phase::Fit, 0.0))?;
    }
    let Laid { hierarchy, mut fitted, places, sheets, pinned } = laid;
    fitted.held = Held::new(&hierarchy, &pinned, &places, mesh, &creases);
    let rules = match (spacing, closely) {
        (Spacing::AsIs, _) => FIT_AS_IS,
        (_, true) => FIT_CLOSELY,
        (_, false) => FIT,
    };
    let fit = fit(near, &fitted, places.clone(), &rules, &|done| progress(Phase::Fit, FITTED * done))?;
    let briefly = spacing == Spacing::AsIs;
    let mending =
        Mending { target: near, fitted: &fitted, sheets: &sheets, places: &places, unfolding, briefly };
    let (positions, turned) =
        mending.run(fit, &|done| progress(Phase::Fit, FITTED + (1.0 - FITTED) * done))?;
    Ok(Made { size, hierarchy, positions, faces: fitted.pattern.faces().to_vec(), turned })
}

/// A base face is tiny below this part of the mean area.
const TINY: f64 = 0.01;
/// Where more than this part of the base faces is tiny, and there are many handles, they lie round tunnels much narrower than
/// they, as noise leaves them in scans; on the surface of such a base mesh hundreds of faces would be turned over.
const MOST_TINY: f64 = 0.05;
/// Fewer handles are no tangle, whatever is tiny: a bust of a million faces has small ones about its ears.
const MANY_HANDLES: u32 = 5;

/// What part of the faces is tiny.
fn tiny_part(mesh: &WorkingMesh) -> f64 {
    let area = |f: u32| {
        let [a, b, c] = mesh.corners(f);
        (b - a).cross(c - a).length()
    };
    let areas: Vec<f64> = mesh.live_faces().map(area).collect();
    let mean = areas.iter().sum::<f64>() / areas.len().max(1) as f64;
    areas.iter().filter(|area| **area < TINY * mean).count() as f64 / areas.len().max(1) as f64
}

/// On four scans the first two steps take out most of the error, and no step after the sixth any.
const FIT: FitRules = FitRules { steps: 6, rough: 3, boost_from: 3, smoothing: 0.015 };

/// Where the input bends at every edge, vertices come to lie along its edges if little holds them evenly apart: on two
/// such models the error is a sixth less, and angles are a little less even.
const FIT_CLOSELY: FitRules = FitRules { smoothing: 0.003, ..FIT };
/// What lies on the input but in few places hardly moves.
const FIT_AS_IS: FitRules = FitRules { steps: 3, rough: 0, boost_from: 1, smoothing: 0.003 };

/// What fitting takes of its phase; mending takes the rest.
const FITTED: f32 = 0.8;

/// Where the model lies; the work is done in a box of diagonal 1 around 0, or about where its mirror plane is x = 0.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    centre: DVec3,
    diagonal: f64,
    /// Which axis of the model is x.
    first: usize,
}

impl Frame {
    pub(super) fn around(mesh: &TriangleMesh) -> Option<Self> {
        let bounds = mesh.bounds()?;
        let (min, max) = (DVec3::from(bounds.min), DVec3::from(bounds.max));
        let diagonal = bounds.diagonal();
        (diagonal > 0.0 && diagonal.is_finite()).then(|| Self {
            centre: min + (max - min) * 0.5,
            diagonal,
            first: 0,
        })
    }

    /// With the plane across an axis as x = 0; the others follow in turn, so nothing is turned inside out.
    fn about(mut self, axis: Axis, plane: f64) -> Self {
        self.first = axis.index();
        self.centre[self.first] = plane;
        self
    }

    pub(super) fn into_unit(self, mesh: &TriangleMesh) -> TriangleMesh {
        let positions = mesh.positions.iter().map(|&p| self.to_unit(p).to_array()).collect();
        TriangleMesh { positions, ..mesh.clone() }
    }

    pub(super) fn to_unit(self, p: [f64; 3]) -> DVec3 {
        let mut unit = ((DVec3::from(p) - self.centre) / self.diagonal).to_array();
        unit.rotate_left(self.first);
        unit.into()
    }

    pub(super) fn to_model(self, p: DVec3) -> [f64; 3] {
        let mut turned = p.to_array();
        turned.rotate_right(self.first);
        (DVec3::from(turned) * self.diagonal + self.centre).to_array()
    }
}

#[cfg(test)]
mod tests;
