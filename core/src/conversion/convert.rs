//! From a triangle mesh to a hierarchy with positions: a mesh with subdivision connectivity keeps its vertices, any
//! other is remeshed or can stand as its own base mesh.

use super::aside::Aside;
use super::clean::CleanReport;
use super::clean::weld::equal;
use super::marks::mark;
use super::remesh::{Phase, RemeshError, RemeshOptions, remesh};
use super::symmetry::Axis;
use crate::hierarchy::detection::{Detected, detect_while, own_base};
use crate::hierarchy::{FINEST_LEVEL, Hierarchy, NotABaseMesh};
use crate::mesh::connectivity::NotManifold;
use crate::mesh::{Comparison, Connectivity, TriangleMesh};
use rayon::prelude::*;
use thiserror::Error;

/// Whether to look for subdivision connectivity, and what to do without it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Remesh {
    /// Use it where it is there, in the mesh as it is or with vertices at exactly the same place made one; otherwise
    /// repair and remesh.
    #[default]
    Auto,
    /// Repair and remesh in any case.
    Always,
    /// Use it where it is there; otherwise the mesh is its own base mesh, J = 0. A mesh that is no manifold is refused.
    Never,
}

/// How to convert.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ConversionOptions {
    /// At most so many levels, or when the mesh is remeshed, so many.
    pub levels: Option<u8>,
    /// Whether to look for subdivision connectivity.
    pub remesh: Remesh,
    /// When the mesh is remeshed: at most so many base faces; by default chosen from its size.
    pub base_faces: Option<usize>,
    /// When the mesh is remeshed: the greatest distance allowed, over the bounding-box diagonal.
    pub tolerance: Option<f64>,
    /// When the mesh is remeshed: edges sharper than this angle in degrees are kept sharp; by default on meshes that
    /// look made.
    pub sharp_angle: Option<f64>,
    /// When the mesh is remeshed: along which axis the base mesh is its own mirror image; the mesh must be nearly symmetric.
    pub symmetric: Option<Axis>,
}

/// A hierarchy with positions.
#[derive(Debug, Clone)]
pub struct Converted {
    /// The meshes without positions.
    pub hierarchy: Hierarchy,
    /// Model positions by slot of the finest level.
    pub positions: Vec<[f64; 3]>,
    /// For each slot of the finest level the index of its vertex in the mesh, where that had subdivision connectivity.
    pub source: Option<Vec<u32>>,
    /// What was done to the mesh on the way, one sentence each.
    pub cleaned: Vec<String>,
    /// The distance between the cleaned mesh and the positions, if the mesh was remeshed; else they are its own.
    pub measured: Option<Comparison>,
}

/// The least side of a bounding box that can be remeshed, in model units: squares of squares stay in the range of `f64`.
const LEAST_EXTENT: f64 = 1e-60;

/// Why a mesh cannot be converted.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum ConversionError {
    /// The mesh has no faces.
    #[error("the mesh has no faces, so there is no surface; export it with its triangles")]
    Empty,
    /// The mesh is too small to compute with.
    #[error(
        "the mesh is less than {LEAST_EXTENT:e} units across, too small to compute with; scale it up and export it again"
    )]
    TooSmall,
    /// The mesh is no manifold.
    #[error(
        "{0}; repair the mesh there (vertices and faces count from 0), or import it with --remesh auto, which repairs and converts it"
    )]
    NotManifold(#[from] NotManifold),
    /// The mesh cannot be its own base mesh.
    #[error("{0}; repair the mesh there (vertices and faces count from 0)")]
    NotABaseMesh(#[from] NotABaseMesh),
    /// The mesh could not be remeshed.
    #[error(transparent)]
    Remesh(#[from] RemeshError),
    /// Positions that were put aside cannot be read any more.
    #[error(
        "the folder for temporary files does not give back what was put there ({0}); see to it and import again"
    )]
    Aside(String),
}

/// Converts a mesh: by its subdivision connectivity, as its own base mesh, or by remeshing. Linear in its faces but for
/// remeshing; see [`remesh`].
///
/// # Errors
/// See [`ConversionError`].
pub fn convert(mesh: &TriangleMesh, options: &ConversionOptions) -> Result<Converted, ConversionError> {
    convert_with_progress(mesh, options, &|_, _| true)
}

/// [`convert`], saying what remeshing does: `progress` gets the phase and the share of it done, and returns whether to
/// go on.
///
/// # Errors
/// See [`ConversionError`].
pub fn convert_with_progress(
    mesh: &TriangleMesh,
    options: &ConversionOptions,
    progress: &dyn Fn(Phase, f32) -> bool,
) -> Result<Converted, ConversionError> {
    check(mesh)?;
    let detected = match options.remesh {
        Remesh::Always => Ok(None),
        _ => detect_in(mesh.positions.len(), &mesh.faces, options, progress)?,
    };
    convert_detected(mesh, options, detected, progress)
}

/// Meshes with more vertices wait for their connectivity without their positions.
const PUT_ASIDE_FROM: usize = 1 << 20;

/// [`convert_with_progress`] of a mesh that is not needed afterwards. The result is the same; a large mesh with subdivision
/// connectivity takes a third less memory, since its positions are in a scratch file while that is found, and its faces are
/// let go before the positions come back.
///
/// # Errors
/// See [`ConversionError`].
pub fn convert_owned(
    mesh: TriangleMesh,
    options: &ConversionOptions,
    progress: &dyn Fn(Phase, f32) -> bool,
) -> Result<Converted, ConversionError> {
    convert_putting_aside(mesh, options, progress, PUT_ASIDE_FROM)
}

fn convert_putting_aside(
    mut mesh: TriangleMesh,
    options: &ConversionOptions,
    progress: &dyn Fn(Phase, f32) -> bool,
    from: usize,
) -> Result<Converted, ConversionError> {
    let count = mesh.positions.len();
    if options.remesh == Remesh::Always || count < from {
        return convert_with_progress(&mesh, options, progress);
    }
    check(&mesh)?;
    let Ok(aside) = Aside::put(&mesh.positions) else {
        return convert_with_progress(&mesh, options, progress);
    };
    mesh.positions = Vec::new();
    let detected = detect_in(count, &mesh.faces, options, progress)?;
    let back = || aside.take(count).map_err(|error| ConversionError::Aside(error.to_string()));
    if let Ok(Some(detected)) = detected {
        let marks = mesh.sharp_edges;
        drop(mesh.faces);
        return Ok(kept((detected, Kind::AsItIs, marks), &back()?, options));
    }
    mesh.positions = back()?;
    convert_detected(&mesh, options, detected, progress)
}

/// Refuses a mesh without faces or with faces of vertices that do not exist.
fn check(mesh: &TriangleMesh) -> Result<(), ConversionError> {
    if mesh.faces.is_empty() {
        return Err(ConversionError::Empty);
    }
    let missing = |&v: &u32| v as usize >= mesh.positions.len();
    if let Some((face, &vertex)) =
        (0u32..).zip(&mesh.faces).find_map(|(f, face)| Some((f, face.iter().find(|v| missing(v))?)))
    {
        return Err(NotManifold::MissingVertex { face, vertex }.into());
    }
    Ok(())
}

/// Converts a mesh by what was found of its connectivity.
fn convert_detected(
    mesh: &TriangleMesh,
    options: &ConversionOptions,
    detected: Result<Option<Detected>, NotManifold>,
    progress: &dyn Fn(Phase, f32) -> bool,
) -> Result<Converted, ConversionError> {
    let own = || mesh.sharp_edges.clone();
    let found = match options.remesh {
        Remesh::Always => return remeshed(mesh, options, progress),
        Remesh::Auto => match detected.ok().flatten() {
            Some(detected) => (detected, Kind::AsItIs, own()),
            None => match detect_welded(mesh, options, progress)? {
                Some(Welded { detected, merged, marks }) => (detected, Kind::Welded(merged), marks),
                None => return remeshed(mesh, options, progress),
            },
        },
        Remesh::Never => match detected? {
            Some(detected) => (detected, Kind::AsItIs, own()),
            None => (own_base_of_used(mesh)?, Kind::OwnBase, own()),
        },
    };
    Ok(kept(found, &mesh.positions, options))
}

/// A mesh that keeps its vertices, of which these are the positions.
fn kept(
    (detected, kind, marks): (Detected, Kind, Vec<[u32; 2]>),
    positions: &[[f64; 3]],
    options: &ConversionOptions,
) -> Converted {
    let merged = if let Kind::Welded(merged) = kind { merged } else { 0 };
    let report = CleanReport {
        welded: merged,
        unreferenced: positions.len() - detected.source.len() - merged,
        ..CleanReport::default()
    };
    let (Detected { hierarchy, source }, left) = mark(detected, &marks);
    let mut cleaned = report.sentences();
    if left > 0 {
        cleaned.push(format!(
            "{left} of {} edges marked as sharp stay smooth: they do not run all along an edge of the base mesh",
            marks.len()
        ));
    }
    if let Some(axis) = options.symmetric {
        cleaned.push(format!(
            "the mesh keeps its own vertices, so its base mesh was not made symmetric along {axis}; that needs converting it in any case"
        ));
    }
    let positions = source.par_iter().map(|&v| positions[v as usize]).collect();
    let source = (kind != Kind::OwnBase).then_some(source);
    Converted { hierarchy, positions, source, cleaned, measured: None }
}

/// How a mesh came to a hierarchy without remeshing.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// It has subdivision connectivity.
    AsItIs,
    /// It has subdivision connectivity where so many vertices are merged with another.
    Welded(usize),
    /// It is its own base mesh.
    OwnBase,
}

/// What is found of the connectivity of faces.
fn detect_in(
    vertices: usize,
    faces: &[[u32; 3]],
    options: &ConversionOptions,
    progress: &dyn Fn(Phase, f32) -> bool,
) -> Result<Result<Option<Detected>, NotManifold>, RemeshError> {
    let levels = options.levels.unwrap_or(FINEST_LEVEL);
    detect_while(vertices as u32, faces, levels, &|| progress(Phase::Detect, 0.0))
        .map_err(|_| RemeshError::Cancelled)
}

/// Subdivision connectivity of a mesh with vertices at exactly the same place made one.
struct Welded {
    detected: Detected,
    /// How many vertices were merged with another.
    merged: usize,
    /// The mesh's sharp edges between the vertices left.
    marks: Vec<[u32; 2]>,
}

/// `None` if there are no such vertices: seams of textures and soups have them.
fn detect_welded(
    mesh: &TriangleMesh,
    options: &ConversionOptions,
    progress: &dyn Fn(Phase, f32) -> bool,
) -> Result<Option<Welded>, RemeshError> {
    let mut used = vec![false; mesh.positions.len()];
    mesh.faces.iter().flatten().for_each(|&v| used[v as usize] = true);
    let first = equal(&mesh.positions, &used);
    let merged = (0u32..).zip(&first).filter(|(v, other)| v != *other).count();
    if merged == 0 {
        return Ok(None);
    }
    let faces: Vec<[u32; 3]> = mesh.faces.iter().map(|face| face.map(|v| first[v as usize])).collect();
    let Some(detected) = detect_in(mesh.positions.len(), &faces, options, progress)?.ok().flatten() else {
        return Ok(None);
    };
    let ends = mesh.sharp_edges.iter().map(|ends| ends.map(|v| first[v as usize])).collect();
    let marks = TriangleMesh::default().with_sharp_edges(ends).sharp_edges;
    Ok(Some(Welded { detected, merged, marks }))
}

fn remeshed(
    mesh: &TriangleMesh,
    options: &ConversionOptions,
    progress: &dyn Fn(Phase, f32) -> bool,
) -> Result<Converted, ConversionError> {
    let extent =
        mesh.bounds().map_or(0.0, |bounds| (0..3).map(|k| bounds.max[k] - bounds.min[k]).fold(0.0, f64::max));
    if extent > 0.0 && extent < LEAST_EXTENT {
        return Err(ConversionError::TooSmall);
    }
    let ConversionOptions { levels, base_faces, tolerance, sharp_angle, symmetric, .. } = *options;
    let remeshing =
        RemeshOptions { base_faces, levels, tolerance, sharp_angle, symmetric, ..RemeshOptions::default() };
    let made = remesh(mesh, &remeshing, progress)?;
    let (hierarchy, positions, cleaned) = (made.hierarchy, made.positions, made.cleaned);
    Ok(Converted { hierarchy, positions, source: None, cleaned, measured: Some(made.measured) })
}

/// The mesh as its own base, without vertices of no face.
fn own_base_of_used(mesh: &TriangleMesh) -> Result<Detected, ConversionError> {
    let connectivity = Connectivity::build(mesh.positions.len() as u32, mesh.faces.clone())?;
    let used: Vec<u32> = (0..connectivity.vertex_count())
        .filter(|&v| connectivity.outgoing(v) != crate::mesh::connectivity::NONE)
        .collect();
    let mut number = vec![0; mesh.positions.len()];
    for (id, &v) in used.iter().enumerate() {
        number[v as usize] = id as u32;
    }
    let faces: Vec<[u32; 3]> = connectivity.faces().iter().map(|f| f.map(|v| number[v as usize])).collect();
    let detected = own_base(used.len() as u32, &faces)?;
    Ok(Detected { hierarchy: detected.hierarchy, source: used })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    /// Putting positions aside changes nothing of what comes out.
    #[test]
    fn an_owned_mesh_converts_as_a_lent_one() {
        let ball = shapes::subdivide(&shapes::octahedron(), 3);
        let mut marked = ball.clone().with_sharp_edges(ball.faces.iter().map(|f| [f[0], f[1]]).collect());
        marked.positions.push([9.0; 3]);
        let mut soup = ball.clone();
        soup.positions = ball.faces.iter().flatten().map(|&v| ball.positions[v as usize]).collect();
        soup.faces = (0..ball.faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        let mut missing = ball.clone();
        missing.faces[3][1] = 7000;
        let meshes = [ball, marked, soup, missing, shapes::torus(3, 5), TriangleMesh::default()];
        for (at, mesh) in meshes.into_iter().enumerate() {
            for remesh in [Remesh::Auto, Remesh::Never] {
                let options = ConversionOptions { remesh, ..ConversionOptions::default() };
                let lent = format!("{:?}", convert(&mesh, &options));
                let owned = convert_putting_aside(mesh.clone(), &options, &|_, _| true, 0);
                assert!(format!("{owned:?}") == lent, "mesh {at}, {remesh:?}");
            }
        }
    }

    /// Looking for subdivision connectivity can be stopped too, at any question, in a mesh as it is and in one that is welded.
    #[test]
    fn detection_can_be_stopped() {
        let ball = shapes::subdivide(&shapes::octahedron(), 3);
        let mut soup = ball.clone();
        soup.positions = ball.faces.iter().flatten().map(|&v| ball.positions[v as usize]).collect();
        soup.faces = (0..ball.faces.len() as u32).map(|f| [3 * f, 3 * f + 1, 3 * f + 2]).collect();
        for mesh in [ball, soup] {
            let asked = std::cell::Cell::new(0);
            let up_to = |last: u32| {
                asked.set(0);
                let go_on = |_, _| asked.replace(asked.get() + 1) < last;
                convert_with_progress(&mesh, &ConversionOptions::default(), &go_on).map(|_| ())
            };
            assert_eq!(up_to(u32::MAX), Ok(()));
            let all = asked.get();
            assert!(all > 8, "{all} questions");
            for last in 0..all {
                let stopped = up_to(last);
                assert_eq!(stopped, Err(RemeshError::Cancelled.into()), "question {last} of {all}");
                assert_eq!(asked.get(), last + 1, "the first no is the last question");
            }
        }
    }
}
