//! What is parameterised in the place of an input: itself, with rings in large fans, or a thinned copy of a very large one.

use super::creases::Creases;
use super::density::Density;
use super::fans::{Ringed, with_rings};
use super::halve::Half;
use super::simplify::{Cancelled, ask};
use super::thin::thin;
use super::working_mesh::WorkingMesh;
use crate::mesh::{BoundingVolumes, Connectivity, TriangleMesh};
use glam::DVec3;
use std::sync::atomic::{AtomicBool, Ordering};

/// A cleaned input in a box of diagonal 1, and the surface that is parameterised in its place: itself, with rings in large
/// fans, or where it is very large a close one of fewer faces.
pub(super) struct Prepared {
    /// Faces of the input.
    pub(super) faces: usize,
    pub(super) target: TriangleMesh,
    /// The input, where the target has rings and that has not: it is what is measured against.
    pub(super) without_rings: Option<TriangleMesh>,
    /// Of the input, where it was made meanwhile.
    pub(super) tree: Option<BoundingVolumes>,
    pub(super) ground: TriangleMesh,
    pub(super) connectivity: Connectivity<'static>,
    /// Half of that, where the base mesh is to be symmetric.
    pub(super) half: Option<Half>,
}

/// Inputs of more faces are thinned before they are parameterised: what that takes away is far smaller than the faces
/// of the result, which is fitted to the whole input.
const LARGEST_GROUND: usize = 250_000;
/// Faces left of those.
const THINNED: usize = 150_000;

impl Prepared {
    /// Without a half. `progress` takes the share done and returns whether to go on. Linear, thinning included.
    ///
    /// # Errors
    /// The answer was no.
    pub(super) fn new(
        target: TriangleMesh,
        connectivity: Connectivity<'static>,
        progress: &dyn Fn(f32) -> bool,
    ) -> Result<Self, Cancelled> {
        if target.faces.len() <= LARGEST_GROUND {
            let faces = target.faces.len();
            let mut without_rings = None;
            let (target, ground, connectivity) = match with_rings(&target, &connectivity) {
                // Points near the hub of many slivers are slow to project.
                Some(Ringed { mesh, connectivity, is_flat: true }) => {
                    without_rings = Some(target);
                    (mesh.clone(), mesh, connectivity)
                }
                Some(ringed) => (target, ringed.mesh, ringed.connectivity),
                None => (target.clone(), target, connectivity),
            };
            return Ok(Self { faces, target, without_rings, tree: None, ground, connectivity, half: None });
        }
        let mut working = working_mesh(&target, &connectivity);
        if !target.sharp_edges.is_empty() {
            working = working.with_creases(Creases::marked(&target, &connectivity));
        }
        let go_on = || progress(0.0);
        ask(&go_on)?;
        let creases = Creases::default();
        let density = Density::new_while(&target, &connectivity, THINNED as f64, &creases, &go_on)?;
        let mut tree = None;
        beside(
            |go_on| tree = BoundingVolumes::build_while(&target, &mut || go_on()).unwrap_or(None),
            || thin(&mut working, THINNED, &density, progress),
        )?;
        let ground = working.compact();
        let connectivity = Connectivity::build(ground.positions.len() as u32, ground.faces.clone())
            .expect("collapses keep a manifold");
        let faces = target.faces.len();
        Ok(Self { faces, target, without_rings: None, tree, ground, connectivity, half: None })
    }
}

/// Does one thing on another thread while this one is at work, which alone may be asked to stop; both end then.
pub(super) fn beside<T>(
    aside: impl FnOnce(&dyn Fn() -> bool) + Send,
    work: impl FnOnce() -> Result<T, Cancelled>,
) -> Result<T, Cancelled> {
    let stopped = AtomicBool::new(false);
    rayon::in_place_scope(|scope| {
        scope.spawn(|_| aside(&|| !stopped.load(Ordering::Relaxed)));
        let done = work();
        stopped.store(done.is_err(), Ordering::Relaxed);
        done
    })
}

/// A mesh as it is simplified.
pub(super) fn working_mesh(mesh: &TriangleMesh, connectivity: &Connectivity) -> WorkingMesh {
    WorkingMesh::new(mesh.positions.iter().map(|&p| DVec3::from(p)).collect(), connectivity)
}
