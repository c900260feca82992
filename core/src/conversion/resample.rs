//! `M^J` on the input surface: dyadic points of the base faces, carried back through the simplification.

use super::parameterise::{OnFace, Parameterisation};
use super::walk::Ground;
use super::working_mesh::WorkingMesh;
use crate::hierarchy::{BaseMesh, Hierarchy, Level, NotABaseMesh, Slot};
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// A base mesh and, for each of its faces, the face of the working mesh it is and which corner of that each of its
/// corners is.
#[derive(Debug)]
pub(super) struct BaseFaces {
    /// The base mesh.
    pub(super) base: BaseMesh,
    faces: Vec<(u32, [u8; 3])>,
}

/// The live faces as a base mesh; vertices in the order of the working mesh.
///
/// # Errors
/// The live faces are no base mesh, which simplification prevents.
pub(super) fn base_faces(mesh: &WorkingMesh) -> Result<BaseFaces, NotABaseMesh> {
    let mut number = vec![u32::MAX; mesh.positions.len()];
    mesh.live_faces().flat_map(|f| mesh.face(f)).for_each(|v| number[v as usize] = 0);
    let mut count = 0;
    for number in number.iter_mut().filter(|number| **number == 0) {
        *number = count;
        count += 1;
    }
    let numbered = |f: u32| mesh.face(f).map(|v| number[v as usize]);
    let base = BaseMesh::new(count, mesh.live_faces().map(numbered).collect(), &[])?;
    let sorted = |mut face: [u32; 3]| {
        face.sort_unstable();
        face
    };
    let by_corners: FxHashMap<[u32; 3], u32> = mesh.live_faces().map(|f| (sorted(numbered(f)), f)).collect();
    let faces = base
        .faces()
        .iter()
        .map(|&face| {
            let f = by_corners[&sorted(face)];
            let own = numbered(f);
            (f, face.map(|v| own.iter().position(|&w| w == v).expect("the same corners") as u8))
        })
        .collect();
    Ok(BaseFaces { base, faces })
}

/// The point of the input surface for every slot of a level. Parallel over slots; each once.
pub(super) fn resample(
    hierarchy: &Hierarchy,
    level: Level,
    faces: &BaseFaces,
    map: &Parameterisation,
) -> Vec<OnFace> {
    let layout = hierarchy.layout(level);
    let scale = 1.0 / f64::from(layout.segments());
    (0..layout.len())
        .into_par_iter()
        .map(|slot| {
            let (face, steps) = layout.chart(layout.site(Slot(slot)));
            let (working, corners) = faces.faces[face as usize];
            let mut weights = [0.0; 3];
            for (corner, step) in corners.into_iter().zip(steps) {
                weights[usize::from(corner)] = f64::from(step) * scale;
            }
            map.back(OnFace { face: working, weights })
        })
        .collect()
}

/// Where points of a surface are in space.
pub(super) fn place(ground: &Ground, points: &[OnFace]) -> Vec<DVec3> {
    points.par_iter().map(|point| ground.place(point)).collect()
}
