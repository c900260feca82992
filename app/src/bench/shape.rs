//! The surfaces that are measured: wavy balls over few and over many base faces.

use anyhow::{Result, anyhow};
use bozzetto_core::hierarchy::{BaseMesh, Hierarchy, Layout, Level, Slot};
use bozzetto_core::mesh::{TriangleMesh, shapes};
use bozzetto_core::surface::{FormOptions, Surface};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Faces around the axis and rings of them from pole to pole: 400 faces.
const AROUND: u32 = 20;
const RINGS: u32 = 10;

/// Which base mesh.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Base {
    /// The octahedron.
    EightFaces,
    /// A globe of meridians and parallels, its poles extraordinary.
    FourHundredFaces,
}

impl Base {
    fn mesh(self) -> TriangleMesh {
        match self {
            Base::EightFaces => shapes::octahedron(),
            Base::FourHundredFaces => globe(),
        }
    }

    /// The hierarchy over it.
    ///
    /// # Errors
    /// So many levels that the vertices cannot be counted.
    pub(super) fn hierarchy(self, levels: u8) -> Result<Hierarchy> {
        let mesh = self.mesh();
        let base = BaseMesh::new(mesh.positions.len() as u32, mesh.faces, &[])?;
        Hierarchy::new(Arc::new(base), Level(levels))
            .ok_or_else(|| anyhow!("{levels} levels are more than a surface can have; ask for fewer"))
    }

    /// The ball over it, with the default wavelets.
    ///
    /// # Errors
    /// So many levels that the vertices cannot be counted.
    pub(super) fn surface(self, levels: u8) -> Result<Surface> {
        let hierarchy = self.hierarchy(levels)?;
        let corners = self.mesh().positions.into_iter().map(DVec3::from_array).collect::<Vec<_>>();
        let layout = hierarchy.layout(Level(levels));
        let positions: Vec<[f64; 3]> =
            (0..layout.len()).into_par_iter().map(|slot| wavy(layout, &corners, Slot(slot))).collect();
        Ok(Surface::from_positions(hierarchy, &positions, &FormOptions::default())?)
    }
}

/// Where a vertex lies: waves of some lengths on the ball, so that every level has details.
fn wavy(layout: &Layout, corners: &[DVec3], slot: Slot) -> [f64; 3] {
    let (face, b) = layout.chart(layout.site(slot));
    let face = layout.base().faces()[face as usize];
    let flat: DVec3 = face.iter().zip(b).map(|(&v, b)| corners[v as usize] * f64::from(b)).sum();
    let out = flat.normalize();
    let waves: f64 = [(3.0, 0.1), (17.0, 0.02), (90.0, 0.003)]
        .map(|(k, height)| height * (k * (out.x + 2.0 * out.y)).sin())
        .iter()
        .sum();
    (out * (1.0 + waves)).to_array()
}

fn globe() -> TriangleMesh {
    let at = |ring: u32, step: u32| 1 + (ring - 1) * AROUND + step % AROUND;
    let mut positions = vec![[0.0, 0.0, 1.0]];
    for ring in 1..RINGS + 1 {
        let latitude = PI * f64::from(ring) / f64::from(RINGS + 1);
        for step in 0..AROUND {
            // Every ring half a step on, so that triangles are nearly equilateral.
            let longitude = TAU * (f64::from(step) + 0.5 * f64::from(ring)) / f64::from(AROUND);
            let (x, y) = (latitude.sin() * longitude.cos(), latitude.sin() * longitude.sin());
            positions.push([x, y, latitude.cos()]);
        }
    }
    let south = positions.len() as u32;
    positions.push([0.0, 0.0, -1.0]);
    let mut faces = Vec::new();
    for step in 0..AROUND {
        faces.push([0, at(1, step), at(1, step + 1)]);
        faces.push([south, at(RINGS, step + 1), at(RINGS, step)]);
        for ring in 1..RINGS {
            let (a, b) = (at(ring, step), at(ring, step + 1));
            let (c, d) = (at(ring + 1, step), at(ring + 1, step + 1));
            faces.push([a, c, b]);
            faces.push([b, c, d]);
        }
    }
    TriangleMesh::new(positions, faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bases_have_the_faces_that_their_names_say() {
        for (base, faces) in [(Base::EightFaces, 8), (Base::FourHundredFaces, 400)] {
            let surface = base.surface(2).expect("small");
            let mesh = surface.hierarchy().base();
            assert_eq!((mesh.faces().len(), mesh.genus(), mesh.boundary_loops()), (faces, 0, 0));
        }
    }

    #[test]
    fn every_level_has_details() {
        let surface = Base::EightFaces.surface(6).expect("small");
        for level in 0..6 {
            let most = surface.wavelets(Level(level)).iter().flatten().map(|x| x.unsigned_abs()).max();
            assert!(most > Some(100), "level {level}: {most:?}");
        }
    }
}
