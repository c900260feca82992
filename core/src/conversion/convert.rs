//! From a triangle mesh to a hierarchy with positions: a mesh with subdivision connectivity keeps its vertices, any
//! other can stand as its own base mesh.

use crate::hierarchy::detection::{Detected, detect, own_base};
use crate::hierarchy::{FINEST_LEVEL, Hierarchy, NotABaseMesh};
use crate::mesh::connectivity::NotManifold;
use crate::mesh::{Connectivity, TriangleMesh};
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

/// How to convert.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ConversionOptions {
    /// At most so many levels.
    pub levels: Option<u8>,
    /// Whether to look for subdivision connectivity.
    pub remesh: Remesh,
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
}

/// Why a mesh cannot be converted.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum ConversionError {
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
}

/// Converts a mesh. Linear in its faces.
///
/// # Errors
/// See [`ConversionError`].
pub fn convert(mesh: &TriangleMesh, options: &ConversionOptions) -> Result<Converted, ConversionError> {
    if mesh.faces.is_empty() {
        return Err(ConversionError::Empty);
    }
    if options.remesh == Remesh::Always {
        return Err(ConversionError::Remesh);
    }
    let vertices = mesh.positions.len() as u32;
    let detected = detect(vertices, &mesh.faces, options.levels.unwrap_or(FINEST_LEVEL))?;
    let (Detected { hierarchy, source }, found) = match detected {
        Some(detected) => (detected, true),
        None if options.remesh == Remesh::Never => (own_base_of_used(mesh)?, false),
        None => return Err(ConversionError::NoSubdivisionConnectivity),
    };
    let unused = mesh.positions.len() - source.len();
    let cleaned = (unused > 0).then(|| format!("{unused} vertices that no face uses were left out"));
    let positions = source.par_iter().map(|&v| mesh.positions[v as usize]).collect();
    Ok(Converted {
        hierarchy,
        positions,
        source: found.then_some(source),
        cleaned: cleaned.into_iter().collect(),
    })
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
