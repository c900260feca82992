//! The lattice over a whole from that over its half: every base face and its mirror image, joined along the seam.

use super::domain::{Domain, sorted};
use super::fitted::Fitted;
use super::lattice::Lattice;
use crate::hierarchy::{BaseMesh, Hierarchy, NotABaseMesh, Slot};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// A lattice, and where its vertices are: what a fit begins with.
pub(super) struct Laid {
    pub(super) hierarchy: Hierarchy,
    pub(super) fitted: Fitted,
    /// By slot of the finest level.
    pub(super) places: Vec<DVec3>,
    /// The normals of the input there.
    pub(super) sheets: Vec<DVec3>,
    /// For each base vertex whether it keeps its place.
    pub(super) pinned: Vec<bool>,
}

/// The lattice over a half and its mirror image in the plane x = 0. `pinned` are those of the half's base vertices that keep
/// their places in the whole. `Ok(None)` if it has too many vertices. Base vertices off the seam are numbered on in the half's
/// order; base faces and marks are their own mirror image, and so are the places, to the last bit.
///
/// # Errors
/// An edge of the half bridges the seam, which simplification prevents.
pub(super) fn mirrored(
    half: &Lattice,
    domain: &Domain,
    laid: &[(DVec3, DVec3)],
    pinned: &[bool],
) -> Result<Option<Laid>, NotABaseMesh> {
    let base = half.hierarchy.base();
    let count = base.vertex_count();
    let off_seam = (0..count).filter(|&v| !domain.seam[v as usize]);
    let mut of_half: Vec<u32> = (0..count).collect();
    of_half.extend(off_seam);
    let mut image: Vec<u32> = (0..count).collect();
    (count..of_half.len() as u32).for_each(|v| image[of_half[v as usize] as usize] = v);
    let faces = base.faces().iter().flat_map(|&[a, b, c]| [[a, b, c], [a, c, b].map(|v| image[v as usize])]);
    let sharp: Vec<[u32; 2]> =
        base.sharp_edges().iter().flat_map(|&ends| [ends, ends.map(|v| image[v as usize])]).collect();
    let whole = BaseMesh::new(of_half.len() as u32, faces.collect(), &sharp)?;
    let Some(hierarchy) = Hierarchy::new(Arc::new(whole), half.hierarchy.finest()) else { return Ok(None) };
    let (whole, layout) = (hierarchy.base(), hierarchy.layout(hierarchy.finest()));
    let by_corners: FxHashMap<[u32; 3], u32> =
        base.faces().iter().zip(0..).map(|(&face, f)| (sorted(face), f)).collect();
    let of_slot = |slot: u32| {
        let (face, b) = layout.chart(layout.site(Slot(slot)));
        let corners = whole.faces()[face as usize];
        let own = corners.map(|v| of_half[v as usize]);
        let f = by_corners[&sorted(own)];
        let there =
            base.faces()[f as usize].map(|v| b[own.iter().position(|&w| w == v).expect("the same corners")]);
        let (at, normal) = laid[half.layout().slot(half.layout().site_at(f, there)).index()];
        if corners.iter().any(|&v| v >= count) { (mirror(at), mirror(normal)) } else { (at, normal) }
    };
    let (places, sheets): (Vec<DVec3>, Vec<DVec3>) = (0..layout.len()).map(of_slot).unzip();
    let fitted = Fitted::new(places.len(), &hierarchy.triangles(hierarchy.finest()));
    let pinned = of_half.iter().map(|&v| pinned[v as usize]).collect();
    Ok(Some(Laid { hierarchy, fitted, places, sheets, pinned }))
}

fn mirror(p: DVec3) -> DVec3 {
    DVec3::new(0.0 - p.x, p.y, p.z)
}
