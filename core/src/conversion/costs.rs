//! What collapses cost: the quadrics of the vertices, and what each vertex stands for.

use super::density::Density;
use super::quadric::Quadric;
use super::working_mesh::WorkingMesh;
use glam::DVec3;

/// Weight of the planes that hold the boundary and sharp edges, against those of the faces.
const BOUNDARY_WEIGHT: f64 = 10.0;
/// Weight of the squared distance from the vertices gone by, against that of the planes: in flat regions it orders
/// the collapses and keeps the faces even.
const POINT_WEIGHT: f64 = 5e-4;
/// Weight of the growth of squared error at the finest level, by the density, against the squared distance now. Within
/// a factor of ten the result is the same on four scans.
const DENSITY_WEIGHT: f64 = 1e-6;

/// Per vertex, and kept up to date from collapse to collapse.
#[derive(Debug)]
pub(super) struct Costs {
    /// The sum of squared distances to what the vertex stands for.
    pub(super) quadrics: Vec<Quadric>,
    /// The part of the surface it stands for, by the density; a vertex of the result stands for 1.
    masses: Vec<f64>,
}

impl Costs {
    /// For a mesh that is to have `target` faces. Linear in the mesh.
    pub(super) fn new(mesh: &WorkingMesh, density: &Density, target: usize) -> Self {
        let share = 2.0 / target as f64 * density.area();
        let masses = density.at.iter().zip(&density.areas).map(|(d, a)| d * a / share).collect();
        Self { quadrics: quadrics(mesh), masses }
    }

    /// Where the vertex of a collapsed edge is put, and the squared distance it makes there.
    pub(super) fn place(&self, mesh: &WorkingMesh, ends: [u32; 2]) -> (DVec3, f64) {
        let [a, b] = ends.map(|v| v as usize);
        let quadric = self.quadrics[a].plus(&self.quadrics[b]);
        let place = quadric.minimum_near(mesh.positions[a], mesh.positions[b]);
        (place, quadric.at(place))
    }

    /// What a vertex for all that the two stand for costs by the density, as a squared distance.
    pub(super) fn crowding(&self, ends: [u32; 2]) -> f64 {
        let [m, n] = ends.map(|v| self.masses[v as usize]);
        // By so much the cubes grow (see `density`).
        DENSITY_WEIGHT * 3.0 * m * n * (m + n)
    }

    /// Lets `kept` stand for what `gone` stood for; on the seam of half a mesh also for the image of that.
    pub(super) fn join(&mut self, mesh: &WorkingMesh, kept: u32, gone: u32) {
        let both = mesh.is_seam(kept) && !mesh.is_seam(gone);
        let [kept, gone] = [kept, gone].map(|v| v as usize);
        if both {
            self.quadrics[kept] = self.quadrics[kept].plus(&self.quadrics[gone].mirrored());
            self.masses[kept] += self.masses[gone];
        }
        self.quadrics[kept] = self.quadrics[kept].plus(&self.quadrics[gone]);
        self.masses[kept] += self.masses[gone];
    }
}

fn quadrics(mesh: &WorkingMesh) -> Vec<Quadric> {
    let mut quadrics = vec![Quadric::default(); mesh.positions.len()];
    for f in mesh.live_faces() {
        let (face, [a, b, c]) = (mesh.face(f), mesh.corners(f));
        let doubled = (b - a).cross(c - a);
        let normal = doubled.normalize_or_zero();
        let area = doubled.length() * 0.5;
        let mut add = |v: u32, q: Quadric| quadrics[v as usize] = quadrics[v as usize].plus(&q);
        for v in face {
            add(v, Quadric::plane(normal, a, area / 3.0));
            add(v, Quadric::point(mesh.positions[v as usize], POINT_WEIGHT * area / 3.0));
        }
        for k in 0..3 {
            let (v, w) = (face[k], face[(k + 1) % 3]);
            let on_boundary = mesh.is_boundary(v)
                && mesh.is_boundary(w)
                && !(mesh.is_seam(v) && mesh.is_seam(w))
                && mesh.sides(v, w)[1].is_none();
            if on_boundary || mesh.is_crease(v, w) {
                let (p, q) = (mesh.positions[v as usize], mesh.positions[w as usize]);
                let side = (q - p).cross(normal).normalize_or_zero();
                let weight = BOUNDARY_WEIGHT * p.distance_squared(q);
                let quadric = Quadric::plane(side, p, weight)
                    .plus(&Quadric::plane(normal, p, weight))
                    .plus(&Quadric::point((p + q) * 0.5, POINT_WEIGHT * weight));
                add(v, quadric);
                add(w, quadric);
            }
        }
    }
    for (quadric, _) in quadrics.iter_mut().zip(0..).filter(|&(_, v)| mesh.is_seam(v)) {
        *quadric = quadric.plus(&quadric.mirrored());
    }
    quadrics
}
