//! Making a surface cheaper to write: its detail is brought along normals.
//!
//! Based on: Guskov, Vidimče, Sweldens, Schröder, "Normal Meshes", SIGGRAPH 2000; Khodakovsky, Guskov, "Compression of
//! Normal Meshes", 2003. Where those build a mesh from coarse to fine by piercing, here one that is fitted already is drawn
//! along itself to where its detail has no part in the surface. That also works in a lifted transform, whose coarse
//! positions are not on the surface.

use super::progressive::Straightened;
use crate::conversion::move_along;
use crate::conversion::remesh::RemeshError;
use crate::hierarchy::Hierarchy;
use crate::mesh::TriangleMesh;
use crate::wavelet::{ValenceTooHigh, Wavelet};
use thiserror::Error;

/// Why a surface was not fitted again.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum NotNormal {
    /// The base mesh cannot have these wavelets.
    #[error(transparent)]
    Valence(#[from] ValenceTooHigh),
    /// The mesh has no surface, or the progress function asked to stop.
    #[error(transparent)]
    Fit(#[from] RemeshError),
}

/// A surface that was converted from a mesh, fitted to it again so that a stream's details lie along normals as nearly as
/// the mesh allows: nearly half of a small file tells of their parts in the surface. The coarsest levels, of fewer than
/// some hundred faces, keep those, for they say where things are. Positions are in model units, by slot of the finest level;
/// `progress` gets the share that is done and returns whether to go on. Cost: some two fits; see [`move_along`].
///
/// # Errors
/// See [`NotNormal`].
pub fn normal_mesh(
    mesh: &TriangleMesh,
    hierarchy: &Hierarchy,
    positions: &[[f64; 3]],
    wavelet: Wavelet,
    progress: &dyn Fn(f32) -> bool,
) -> Result<Vec<[f64; 3]>, NotNormal> {
    let straightened = Straightened::new(hierarchy, wavelet)?;
    Ok(move_along(mesh, hierarchy, positions, &|positions| straightened.of(positions), progress)?)
}
