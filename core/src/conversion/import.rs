//! From a triangle mesh to a surface: a mesh with subdivision connectivity keeps its vertices exactly (to half a
//! step), any other can stand as its own base mesh.

use crate::hierarchy::detection::{Detected, detect, own_base};
use crate::hierarchy::{FINEST_LEVEL, Hierarchy, NotABaseMesh};
use crate::mesh::connectivity::NotManifold;
use crate::mesh::{Connectivity, TriangleMesh};
use crate::surface::{DEFAULT_PRECISION, Form, NotPlaceable, Placement, Surface, UpAxis};
use crate::wavelet::{Scheme, ValenceTooHigh, Wavelet};
use rayon::prelude::*;
use thiserror::Error;

/// Whether to look for subdivision connectivity, and what to do without it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Remesh {
    /// Use it where it is there; otherwise convert the mesh.
    #[default]
    Auto,
    /// Convert the mesh in any case.
    Always,
    /// Use it where it is there; otherwise the mesh is its own base mesh, J = 0.
    Never,
}

/// How to import.
#[derive(Debug, Clone)]
pub struct ImportOptions {
    /// Which wavelets.
    pub wavelet: Wavelet,
    /// How odd vertices are predicted.
    pub scheme: Scheme,
    /// At most so many levels.
    pub levels: Option<u8>,
    /// Bits of precision.
    pub precision: u8,
    /// Whether to look for subdivision connectivity.
    pub remesh: Remesh,
    /// The model's up axis.
    pub up: UpAxis,
    /// The model's unit, free text.
    pub unit: String,
}

impl Default for ImportOptions {
    fn default() -> Self {
        Self {
            wavelet: Wavelet::Disc(2),
            scheme: Scheme::Linear,
            levels: None,
            precision: DEFAULT_PRECISION,
            remesh: Remesh::Auto,
            up: UpAxis::Y,
            unit: String::new(),
        }
    }
}

/// A fresh surface.
#[derive(Debug, Clone)]
pub struct Imported {
    /// The surface.
    pub surface: Surface,
    /// For each slot of level J the index of its vertex in the mesh, where that had subdivision connectivity.
    pub source: Option<Vec<u32>>,
    /// What was done to the mesh on the way, one sentence each.
    pub cleaned: Vec<String>,
}

/// Why a mesh cannot be imported.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum ImportError {
    /// The mesh has no faces.
    #[error("the mesh has no faces, so there is no surface; export it with its triangles")]
    Empty,
    /// The mesh is no manifold.
    #[error("{0}; repair the mesh there (vertices and faces count from 0)")]
    NotManifold(#[from] NotManifold),
    /// The mesh cannot be its own base mesh.
    #[error("{0}; repair the mesh there (vertices and faces count from 0)")]
    NotABaseMesh(#[from] NotABaseMesh),
    /// No subdivision connectivity, and conversion was needed.
    #[error(
        "the mesh has no subdivision connectivity (no base mesh whose faces split 1 to 4 give it); \
         take it as its own base mesh with --remesh never"
    )]
    NoSubdivisionConnectivity,
    /// Remeshing was asked for.
    #[error("remeshing is not available; leave out --remesh always")]
    Remesh,
    /// The positions cannot be placed.
    #[error("{0}; check the model's coordinates")]
    NotPlaceable(#[from] NotPlaceable),
    /// A neighbourhood is too large.
    #[error("{0}")]
    Valence(#[from] ValenceTooHigh),
}

/// Imports a mesh. Linear in its faces.
///
/// # Errors
/// See [`ImportError`].
pub fn import(mesh: &TriangleMesh, options: &ImportOptions) -> Result<Imported, ImportError> {
    if mesh.faces.is_empty() {
        return Err(ImportError::Empty);
    }
    let vertices = mesh.positions.len() as u32;
    if options.remesh == Remesh::Always {
        return Err(ImportError::Remesh);
    }
    let mut cleaned = Vec::new();
    let detected = detect(vertices, &mesh.faces, options.levels.unwrap_or(FINEST_LEVEL))?;
    let (Detected { hierarchy, source }, found) = match detected {
        Some(detected) => (detected, true),
        None if options.remesh == Remesh::Never => (own_base_of_used(mesh)?, false),
        None => return Err(ImportError::NoSubdivisionConnectivity),
    };
    let unused = mesh.positions.len() - source.len();
    if unused > 0 {
        cleaned.push(format!("{unused} vertices that no face uses were left out"));
    }
    let surface = place(hierarchy, &source, mesh, options)?;
    Ok(Imported { surface, source: found.then_some(source), cleaned })
}

/// The mesh as its own base, without vertices of no face.
fn own_base_of_used(mesh: &TriangleMesh) -> Result<Detected, ImportError> {
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

fn place(
    hierarchy: Hierarchy,
    source: &[u32],
    mesh: &TriangleMesh,
    options: &ImportOptions,
) -> Result<Surface, ImportError> {
    let positions: Vec<[f64; 3]> = source.par_iter().map(|&v| mesh.positions[v as usize]).collect();
    surface_from_positions(hierarchy, &positions, options)
}

/// A surface from model positions by slot of the finest level.
///
/// # Errors
/// Positions that cannot be placed, or a base mesh whose valences the wavelet cannot serve.
pub fn surface_from_positions(
    hierarchy: Hierarchy,
    positions: &[[f64; 3]],
    options: &ImportOptions,
) -> Result<Surface, ImportError> {
    let mut placement = Placement::around(positions, options.precision)?;
    placement.up = options.up;
    placement.unit = options.unit.clone();
    let finest = positions.par_iter().map(|&p| placement.to_steps(p)).collect();
    let form =
        Form { scheme: options.scheme, wavelet: options.wavelet, precision: options.precision, placement };
    Ok(Surface::from_finest(hierarchy, form, finest)?)
}
