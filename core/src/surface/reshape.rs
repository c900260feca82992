//! The same surface over other levels: one more, fewer, or a finer base mesh.
//!
//! Positions stay where they are, but for levels that are taken away; coefficients follow by analysis, which is exact, so
//! each change is undone by its counterpart, to the bit.

use super::{Mask, Surface};
use crate::hierarchy::{BaseMesh, Hierarchy, Layout, Level, MOST_VERTICES, Site, Slot, Subtriangle};
use crate::memory::Buffer;
use crate::wavelet::{Filters, ValenceTooHigh};
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use std::sync::Arc;
use thiserror::Error;

/// Why a surface cannot have other levels.
#[derive(Debug, Error, Clone, PartialEq, Eq)]
pub enum NotReshaped {
    /// Too many vertices.
    #[error("another level would have more than {MOST_VERTICES} vertices, the most a surface may have")]
    TooLarge,
    /// A neighbourhood is too large for the wavelet.
    #[error("{0}")]
    Valence(#[from] ValenceTooHigh),
}

impl Surface {
    /// The number of vertices another level would have; none if that is too many.
    pub fn vertices_of_next_level(&self) -> Option<u32> {
        let layout = Layout::checked(self.hierarchy().base(), self.finest().finer())?;
        (layout.len() <= MOST_VERTICES).then(|| layout.len())
    }

    /// With one more level, which has no detail. `O(n_{J+1})`.
    pub(crate) fn with_level_added(&self) -> Result<Self, NotReshaped> {
        self.vertices_of_next_level().ok_or(NotReshaped::TooLarge)?;
        let next = self.finest().finer();
        let hierarchy = Hierarchy::new(self.hierarchy.base().clone(), next).ok_or(NotReshaped::TooLarge)?;
        let filters = Filters::new(&hierarchy, self.form.wavelet)?;
        Ok(self.lengthened(hierarchy, filters))
    }

    /// With the finer levels of a hierarchy over the same base mesh, which have no detail. `O(n_J)`.
    pub(crate) fn extended(&self, hierarchy: &Hierarchy) -> Self {
        let filters = Filters::new(hierarchy, self.form.wavelet).expect("it had these levels before");
        self.lengthened(hierarchy.clone(), filters)
    }

    fn lengthened(&self, hierarchy: Hierarchy, filters: Filters) -> Self {
        let mut wavelets = self.wavelets.clone();
        for j in self.finest().0..hierarchy.finest().0 {
            wavelets.push(Buffer::zeroed(hierarchy.layout(Level(j)).odd_len() as usize));
        }
        let mut mask = self.mask.clone();
        for j in self.finest().0..hierarchy.finest().0 {
            mask = mask.refined(hierarchy.layout(Level(j)), hierarchy.layout(Level(j).finer()));
        }
        let form = self.form.clone();
        let mut surface = Self::with_filters(hierarchy, filters, form, self.scaling[0].clone(), wavelets);
        surface.mask = mask;
        surface
    }

    /// With `level` as the finest. `O(n_level)`.
    pub(crate) fn without_finer(&self, level: Level) -> Self {
        let hierarchy = Hierarchy::new(self.hierarchy.base().clone(), level).expect("a level there is");
        let filters = Filters::new(&hierarchy, self.form.wavelet).expect("fewer levels ask for less");
        let scaling = self.scaling[..=level.index()].to_vec();
        let wavelets = self.wavelets[..level.index()].to_vec();
        let mut surface = Self::assemble(hierarchy, filters, self.form.clone(), scaling, wavelets);
        let kept: Vec<u32> = (0..surface.hierarchy.layout(level).len())
            .map(|slot| self.hierarchy.refine_slot(level, self.finest(), Slot(slot)).0)
            .collect();
        surface.mask = self.mask.taken(&kept);
        surface
    }

    /// With `M^level` as the base mesh. Base vertices are numbered as `M^level` was. `O(n_J)`.
    pub(crate) fn without_coarser(&self, level: Level) -> Result<Self, NotReshaped> {
        let base = base_of(&self.hierarchy, level);
        let rest = Level(self.finest().0 - level.0);
        let hierarchy = Hierarchy::new(Arc::new(base), rest).ok_or(NotReshaped::TooLarge)?;
        let places = places(&self.hierarchy, level, &hierarchy);
        let finest = self.scaling(self.finest());
        let positions = Buffer::of(places.len(), |slot| finest[places[slot] as usize]);
        let mut surface = Self::from_finest(hierarchy, self.form.clone(), positions)?;
        surface.mask = self.mask.taken(&places);
        Ok(surface)
    }

    /// Over the hierarchy from before [`Surface::without_coarser`]. `O(n_J)`.
    pub(crate) fn over_base(&self, hierarchy: &Hierarchy, level: Level) -> Self {
        let places = places(hierarchy, level, &self.hierarchy);
        let mut back = vec![0; places.len()];
        places.iter().zip(0..).for_each(|(&place, slot)| back[place as usize] = slot);
        let finest = self.scaling(self.finest());
        let positions = Buffer::of(back.len(), |slot| finest[back[slot] as usize]);
        let mut surface = Self::from_finest(hierarchy.clone(), self.form.clone(), positions)
            .expect("it had this base mesh before");
        surface.mask = self.mask.taken(&back);
        surface
    }
}

/// `M^level` as a base mesh, its vertices by public id, with the sharp edges that lie on sharp ones.
fn base_of(hierarchy: &Hierarchy, level: Level) -> BaseMesh {
    let layout = hierarchy.layout(level);
    let id = |site: Site| layout.public_id(site).0;
    let faces: Vec<[u32; 3]> =
        hierarchy.triangles(level).into_iter().map(|f| f.map(|slot| id(layout.site(Slot(slot))))).collect();
    let base = hierarchy.base();
    let sharp: Vec<[u32; 2]> = (0..base.edges().len() as u32)
        .filter(|&edge| base.is_sharp(edge))
        .flat_map(|edge| (0..layout.segments()).map(move |t| (edge, t)))
        .map(|(edge, t)| [t, t + 1].map(|t| id(layout.along_edge(edge, t))))
        .map(|[a, b]| [a.min(b), a.max(b)])
        .collect();
    BaseMesh::new(layout.len(), faces, &sharp).expect("a level of a manifold is a manifold")
}

/// For every finest slot over the base mesh `M^level`, the slot of the same vertex over the old one.
fn places(old: &Hierarchy, level: Level, new: &Hierarchy) -> Vec<u32> {
    let layout = old.layout(level);
    let n = layout.segments();
    let id = |face: u32, [i, r]: [u32; 2]| layout.public_id(layout.site_at(face, [n - i - r, i, r])).0;
    let mut triangles: FxHashMap<[u32; 3], (u32, [[u32; 2]; 3])> = FxHashMap::default();
    for face in 0..old.base().faces().len() as u32 {
        for triangle in Subtriangle::all_in_face(face, n) {
            let mut corners = triangle.corners();
            let ids = corners.map(|corner| id(face, corner));
            let lowest = (0..3).min_by_key(|&k| ids[k]).expect("three corners");
            corners.rotate_left(lowest);
            triangles.insert(corners.map(|corner| id(face, corner)), (face, corners));
        }
    }
    let of_face: Vec<(u32, [[u32; 2]; 3])> = new.base().faces().iter().map(|f| triangles[f]).collect();
    let (fine, finest) = (old.layout(old.finest()), new.layout(new.finest()));
    let place = |slot: u32| {
        let (face, b) = finest.chart(finest.site(Slot(slot)));
        let (face, corners) = of_face[face as usize];
        let at = |axis: usize| (0..3).map(|k| b[k] * corners[k][axis]).sum::<u32>();
        let (i, r) = (at(0), at(1));
        fine.slot(fine.site_at(face, [fine.segments() - i - r, i, r])).0
    };
    (0..finest.len()).into_par_iter().map(place).collect()
}

impl Mask {
    /// Of other slots: the i-th has what `from[i]` had.
    fn taken(&self, from: &[u32]) -> Self {
        let values = if self.values.is_empty() {
            Vec::new()
        } else {
            from.iter().map(|&at| self.values[at as usize]).collect()
        };
        let hidden = if self.hidden.is_empty() {
            Vec::new()
        } else {
            from.iter().map(|&at| self.hidden[at as usize]).collect()
        };
        Self { values, hidden }
    }

    /// One level finer: between two vertices their mean, hidden if both are.
    fn refined(&self, coarse: &Layout, fine: &Layout) -> Self {
        let pair = |slot: u32| match Layout::coarsen(fine.site(Slot(slot))) {
            Some(site) => [coarse.slot(site); 2],
            None => coarse.parents(fine.site(Slot(slot))).map(|site| coarse.slot(site)),
        };
        let mean = |slot: u32| {
            let [a, b] = pair(slot).map(|s| u16::from(self.values[s.index()]));
            ((a + b) / 2) as u8
        };
        let both = |slot: u32| pair(slot).into_iter().all(|s| self.hidden[s.index()]);
        let all = 0..fine.len();
        Self {
            values: if self.values.is_empty() { Vec::new() } else { all.clone().map(mean).collect() },
            hidden: if self.hidden.is_empty() { Vec::new() } else { all.map(both).collect() },
        }
    }
}
