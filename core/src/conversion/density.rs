//! Where faces are needed: a measure on the input surface whose equal parts are approximated equally well.
//!
//! A face of area `A` where the surface bends by `H` misses it by some `A H`, so its squared error is `A³ H²`. Spread
//! over a fixed number of faces the sum is least where `A³ H²` is the same for all, that is where each has the same
//! part of the measure `H^(2/3) dA`.

use super::creases::Creases;
use super::parameterise::OnFace;
use super::simplify::Cancelled;
use crate::mesh::connectivity::{Connectivity, NONE};
use crate::mesh::{BoundingVolumes, FaceIndex, TriangleMesh};
use glam::DVec3;
use rayon::prelude::*;

/// Bend below this part of the mean counts as this much: flat regions keep some faces.
const LEAST_BEND: f64 = 0.02;
/// Bend above this multiple of the mean counts as this much: a crease needs faces along it, not without end.
const MOST_BEND: f64 = 200.0;
/// Rounds of smoothing, the more the finer the input is than the surface to come.
const FEWEST_ROUNDS: f64 = 2.0;
const MOST_ROUNDS: f64 = 40.0;

/// For each vertex how many faces the surface needs there, over the mean.
#[derive(Debug, Clone)]
pub(super) struct Density {
    /// Per vertex; the mean over the area is 1, but for what was asked for since.
    pub(super) at: Vec<f64>,
    /// Without what was asked for since.
    own: Vec<f64>,
    /// Area belonging to each vertex, a third of its faces'.
    pub(super) areas: Vec<f64>,
}

impl Density {
    /// [`Density::new_while`] to the end.
    #[cfg(test)]
    pub(super) fn new(
        mesh: &TriangleMesh,
        connectivity: &Connectivity,
        faces: f64,
        creases: &Creases,
    ) -> Self {
        Self::new_while(mesh, connectivity, faces, creases, &|| true).expect("nobody asked to stop")
    }

    /// The density for an approximation by `faces` faces with edges along the creases. Linear in the mesh. `go_on` is asked
    /// after some hundredths of a second each time.
    ///
    /// # Errors
    /// The answer was no.
    pub(super) fn new_while(
        mesh: &TriangleMesh,
        connectivity: &Connectivity,
        faces: f64,
        creases: &Creases,
        go_on: &dyn Fn() -> bool,
    ) -> Result<Self, Cancelled> {
        let corner = |v: u32| DVec3::from(mesh.positions[v as usize]);
        let doubled: Vec<DVec3> = mesh
            .faces
            .par_iter()
            .map(|f| {
                let [a, b, c] = f.map(corner);
                (b - a).cross(c - a)
            })
            .collect();
        let mut areas = vec![0.0; mesh.positions.len()];
        let mut bends = vec![0.0; mesh.positions.len()];
        for (f, face) in mesh.faces.iter().enumerate() {
            face.iter().for_each(|&v| areas[v as usize] += doubled[f].length() / 6.0);
            for k in 0..3 {
                let twin = connectivity.twin((3 * f + k) as u32);
                if twin == NONE || twin < (3 * f + k) as u32 {
                    continue;
                }
                let [n, m] = [f, twin as usize / 3].map(|g| doubled[g].normalize_or_zero());
                let [v, w] = [face[k], face[(k + 1) % 3]];
                // What edges of the surface lie along costs no faces.
                if creases.holds(v, w) {
                    continue;
                }
                let bend = n.distance(m) * corner(v).distance(corner(w)) * 0.5;
                bends[v as usize] += bend;
                bends[w as usize] += bend;
            }
        }
        let total: f64 = areas.iter().sum();
        // Smooth over the size of the faces to come.
        let rounds =
            (FEWEST_ROUNDS * mesh.faces.len() as f64 / faces).clamp(FEWEST_ROUNDS, MOST_ROUNDS) as usize;
        let corners = corners_of_vertices(mesh);
        for _ in 0..rounds {
            if !go_on() {
                return Err(Cancelled);
            }
            // The areas are spread with the bends, so that their ratio stays a mean.
            (bends, areas) =
                rayon::join(|| spread(mesh, &corners, &bends), || spread(mesh, &corners, &areas));
        }
        let mean = bends.iter().sum::<f64>() / total;
        // The smoothed areas give the mean; the true ones the measure.
        let mut at: Vec<f64> = bends
            .iter()
            .zip(&areas)
            .map(|(bend, area)| {
                let bend = if *area > 0.0 { bend / area } else { mean };
                let bend = if mean > 0.0 { bend / mean } else { 1.0 };
                libm::cbrt(bend.clamp(LEAST_BEND, MOST_BEND)).powi(2)
            })
            .collect();
        let sum: f64 = at.iter().zip(&areas).map(|(d, a)| d * a).sum();
        if sum > 0.0 {
            at.iter_mut().for_each(|d| *d *= total / sum);
        }
        Ok(Self { own: at.clone(), at, areas })
    }
}

/// At how many corners of faces each vertex is.
fn corners_of_vertices(mesh: &TriangleMesh) -> Vec<u32> {
    let mut corners = vec![0u32; mesh.positions.len()];
    mesh.faces.iter().flatten().for_each(|&v| corners[v as usize] += 1);
    corners
}

/// Half of each vertex's amount stays, the rest goes to its neighbours in equal parts; the sum is kept.
fn spread(mesh: &TriangleMesh, corners: &[u32], amounts: &[f64]) -> Vec<f64> {
    let mut next: Vec<f64> = amounts.iter().map(|a| a * 0.5).collect();
    for face in &mesh.faces {
        let parts = face.map(|v| amounts[v as usize] * 0.25 / f64::from(corners[v as usize].max(1)));
        for k in 0..3 {
            next[face[k] as usize] += parts[(k + 1) % 3] + parts[(k + 2) % 3];
        }
    }
    next
}

/// Rounds over which what is hidden is spread out at its foot.
const FOOT: usize = 3;

impl Density {
    /// Asks for more faces at the foot of what a surface misses: thin spikes lie over so little of the domain that no
    /// vertex may have come onto them. `surface` is the one so far, `points` its vertices on the input, and what is
    /// further from it than `far` counts as missed. One query for each vertex.
    pub(super) fn reveal(
        &mut self,
        mesh: &TriangleMesh,
        surface: &TriangleMesh,
        points: &[OnFace],
        far: f64,
    ) {
        let Some(tree) = BoundingVolumes::build(surface) else { return };
        let missed: Vec<Option<FaceIndex>> = mesh
            .positions
            .par_chunks(1024)
            .flat_map_iter(|chunk| {
                let mut cursor = tree.cursor();
                let missed = |&p: &[f64; 3]| {
                    let found = cursor.closest(p);
                    (DVec3::from(found.point).distance(p.into()) > far).then_some(found.face)
                };
                chunk.iter().map(missed).collect::<Vec<_>>()
            })
            .collect();
        let mut masses = vec![0.0; self.at.len()];
        for (v, face) in missed.iter().enumerate() {
            let Some(face) = face else { continue };
            let mass = self.own[v] * self.areas[v];
            for corner in surface.faces[face.0 as usize] {
                let point = points[corner as usize];
                for (&w, weight) in mesh.faces[point.face as usize].iter().zip(point.weights) {
                    masses[w as usize] += mass * weight / 3.0;
                }
            }
        }
        let corners = corners_of_vertices(mesh);
        for _ in 0..FOOT {
            masses = spread(mesh, &corners, &masses);
        }
        for (((at, own), area), mass) in self.at.iter_mut().zip(&self.own).zip(&self.areas).zip(masses) {
            *at = own + if *area > 0.0 { mass / area } else { 0.0 };
        }
    }

    /// That of the first vertices alone.
    pub(super) fn of_first(mut self, count: usize) -> Self {
        [&mut self.at, &mut self.own, &mut self.areas].into_iter().for_each(|values| values.truncate(count));
        self
    }

    /// The area of the input.
    pub(super) fn area(&self) -> f64 {
        self.areas.iter().sum()
    }
}
