//! `M^J` laid over the domain: an address for every vertex, and what follows from it in space.
//!
//! The base mesh of the lattice need not be the domain's: its edges may be flipped. Between its vertices the lattice
//! is linear over the domain.

use super::curves::Curves;
use super::domain::{Address, Domain, sorted};
use super::fitted::Fitted;
use super::parameterise::OnFace;
use super::simplify::{Cancelled, ask};
use super::walk::Ground;
use super::warp::{cell, row_index};
use crate::hierarchy::{BaseMesh, Hierarchy, Layout, Level, MOST_VERTICES, Site, Slot};
use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// Places that are looked up between two questions whether to go on.
const BATCH: usize = 1 << 14;

/// Vertices of the finest level over the domain.
pub(super) struct Lattice {
    pub(super) hierarchy: Hierarchy,
    /// The curves of its base mesh.
    pub(super) curves: Curves,
    pub(super) fitted: Fitted,
    /// By slot of the finest level.
    pub(super) addresses: Vec<Address>,
    /// For each base face the slots of its vertices, row by row.
    slots: Vec<u32>,
}

/// Where the vertices of a lattice are on the input.
#[derive(Debug, Clone)]
pub(super) struct Places {
    pub(super) points: Vec<OnFace>,
    pub(super) at: Vec<DVec3>,
    /// Densities there.
    pub(super) density: Vec<f64>,
}

impl Lattice {
    /// The lattice whose base mesh is the domain, every vertex at its own place; `None` if it has too many.
    pub(super) fn over(domain: &Domain, levels: Level) -> Option<Self> {
        let hierarchy = Hierarchy::new(domain.base.clone(), levels)?;
        let layout = hierarchy.layout(levels);
        let scale = 1.0 / f64::from(layout.segments());
        let addresses = (0..layout.len())
            .map(|slot| {
                let (face, b) = layout.chart(layout.site(Slot(slot)));
                Address { face, b: b.map(|x| f64::from(x) * scale) }
            })
            .collect();
        Some(Self::new(domain, hierarchy, addresses))
    }

    /// `None` if a lattice of so many levels would have more vertices than a surface may.
    pub(super) fn fits(domain: &Domain, levels: Level) -> Option<()> {
        Layout::checked(&domain.base, levels).filter(|layout| layout.len() <= MOST_VERTICES).map(|_| ())
    }

    fn new(domain: &Domain, hierarchy: Hierarchy, addresses: Vec<Address>) -> Self {
        let finest = hierarchy.finest();
        let fitted = Fitted::new(addresses.len(), &hierarchy.triangles(finest));
        let slots = face_slots(hierarchy.layout(finest));
        let curves = Curves::new(hierarchy.base(), &domain.pinned);
        Self { hierarchy, curves, fitted, addresses, slots }
    }

    /// The layout of the finest level.
    pub(super) fn layout(&self) -> &Layout {
        self.hierarchy.layout(self.hierarchy.finest())
    }

    /// The slots of a base face, row by row.
    pub(super) fn face_slots(&self, face: usize) -> &[u32] {
        let per_face = self.slots.len() / self.hierarchy.base().faces().len();
        &self.slots[face * per_face..(face + 1) * per_face]
    }

    /// The exact places on the input. Parallel; see [`Domain::on_input`]. `go_on` is asked some times a second.
    ///
    /// # Errors
    /// The answer was no.
    pub(super) fn points(&self, domain: &Domain, go_on: &dyn Fn() -> bool) -> Result<Vec<OnFace>, Cancelled> {
        let mut points = Vec::with_capacity(self.addresses.len());
        for batch in self.addresses.chunks(BATCH) {
            ask(go_on)?;
            points.par_extend(batch.par_iter().map(|&address| domain.on_input(address)));
        }
        Ok(points)
    }

    /// The vertices and weights at a point of a face, in steps of the finest level, the greatest weight first.
    pub(super) fn corners(&self, face: u32, at: [f64; 3]) -> [(f64, usize); 3] {
        let layout = self.layout();
        let mut corners = [(0.0, 0); 3];
        for (corner, (b, weight)) in corners.iter_mut().zip(cell(at)) {
            if weight > 0.0 {
                *corner = (weight, layout.slot(layout.site_at(face, b.map(|x| x as u32))).index());
            }
        }
        corners.sort_by(|a, b| b.0.total_cmp(&a.0));
        corners
    }

    /// The address at a point of the lattice, given by [`Lattice::corners`].
    pub(super) fn address(&self, domain: &Domain, corners: &[(f64, usize); 3]) -> Option<Address> {
        let parts = corners.map(|(weight, slot)| (weight, self.addresses[slot]));
        let count = parts.iter().filter(|part| part.0 > 0.0).count();
        domain.blend(&parts[..count])
    }

    /// The same map with one level more.
    pub(super) fn refined(&self, domain: &Domain) -> Option<Self> {
        let finer = Level(self.hierarchy.finest().0 + 1);
        let hierarchy = Hierarchy::new(self.hierarchy.base().clone(), finer)?;
        let (coarse, fine) = (self.layout(), hierarchy.layout(finer));
        let addresses = (0..fine.len())
            .into_par_iter()
            .map(|slot| {
                let site = fine.site(Slot(slot));
                if let Some(even) = Layout::coarsen(site) {
                    return self.addresses[coarse.slot(even).index()];
                }
                let [a, b] = coarse.parents(site).map(|p| self.addresses[coarse.slot(p).index()]);
                let parts = [(0.5, a), (0.5, b)];
                let on_curve = matches!(site, Site::Edge { edge, .. } if self.curves.holds(edge));
                let middle = if on_curve { domain.blend_on_curve(&parts) } else { domain.blend(&parts) };
                middle.unwrap_or(a)
            })
            .collect();
        Some(Self::new(domain, hierarchy, addresses))
    }

    /// The same map over a base mesh with other faces: `old` tells for a new face (its corners) and a point of it
    /// where that is on an old one.
    pub(super) fn rebased(
        &self,
        domain: &Domain,
        base: BaseMesh,
        old: &FxHashMap<[u32; 3], Flipped>,
    ) -> Option<Self> {
        let finest = self.hierarchy.finest();
        let hierarchy = Hierarchy::new(Arc::new(base), finest)?;
        let (base, was) = (hierarchy.base(), self.hierarchy.base());
        let kept: FxHashMap<[u32; 3], u32> =
            was.faces().iter().zip(0..).map(|(&f, id)| (sorted(f), id)).collect();
        let layout = hierarchy.layout(finest);
        let n = f64::from(layout.segments());
        let addresses = (0..layout.len())
            .into_par_iter()
            .map(|slot| {
                let (face, b) = layout.chart(layout.site(Slot(slot)));
                let corners = base.faces()[face as usize];
                let b = b.map(f64::from);
                let (face, b) = match kept.get(&sorted(corners)) {
                    Some(&face) => (face, permuted(corners, b, was.faces()[face as usize])),
                    None => old[&sorted(corners)].before(was, corners, b.map(|x| x / n), n),
                };
                let corners = self.corners(face, b);
                self.address(domain, &corners).unwrap_or(self.addresses[corners[0].1])
            })
            .collect();
        Some(Self::new(domain, hierarchy, addresses))
    }
}

/// An edge `ab` between the faces `abc` and `bad` that is replaced by `cd`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Flipped {
    pub(super) ends: [u32; 2],
    pub(super) apexes: [u32; 2],
    /// The faces before, that of the first apex first.
    pub(super) faces: [u32; 2],
}

impl Flipped {
    /// Where a point of one of the faces after was before, in steps.
    fn before(&self, was: &BaseMesh, corners: [u32; 3], b: [f64; 3], n: f64) -> (u32, [f64; 3]) {
        let ([a, e], [c, d]) = (self.ends, self.apexes);
        let part = |v: u32| corners.iter().position(|&w| w == v).map_or(0.0, |k| b[k]);
        // In the rhombus both diagonals cross in the middle: c + d = a + e.
        let (pc, pd) = (part(c), part(d));
        let (face, apex, up, down) =
            if pc >= pd { (self.faces[0], c, pc, pd) } else { (self.faces[1], d, pd, pc) };
        let weights = [(a, part(a) + down), (e, part(e) + down), (apex, up - down)];
        let there = was.faces()[face as usize];
        (face, there.map(|v| weights.iter().find(|w| w.0 == v).map_or(0.0, |w| w.1 * n)))
    }
}

/// Barycentric coordinates in the order of other corners.
fn permuted(corners: [u32; 3], b: [f64; 3], others: [u32; 3]) -> [f64; 3] {
    others.map(|v| corners.iter().position(|&w| w == v).map_or(0.0, |k| b[k]))
}

/// For each base face the slots of its vertices, row by row.
pub(super) fn face_slots(layout: &Layout) -> Vec<u32> {
    let n = layout.segments();
    let faces = layout.base().faces().len() as u32;
    let mut slots = Vec::with_capacity(faces as usize * (row_index(n as i32, [0, 0, n as i32]) + 1));
    for face in 0..faces {
        for r in 0..=n {
            slots.extend((0..=n - r).map(|i| layout.slot(layout.site_at(face, [n - i - r, i, r])).0));
        }
    }
    slots
}

impl Places {
    /// Places from points.
    pub(super) fn of(ground: &Ground, density: &[f64], points: Vec<OnFace>) -> Self {
        let (at, density) = points
            .par_iter()
            .map(|point| {
                let corners = ground.mesh.faces[point.face as usize];
                let there: f64 = (0..3).map(|k| density[corners[k] as usize] * point.weights[k]).sum();
                (ground.place(point), there)
            })
            .unzip();
        Self { points, at, density }
    }
}

#[cfg(test)]
mod tests;
