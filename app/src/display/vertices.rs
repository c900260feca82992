//! The vertices of the shown level, for the renderer.

use super::Frame;
use bozzetto_core::hierarchy::{Layout, Level, Slot};
use bozzetto_core::surface::{Moved, Surface};
use glam::DVec3;
use rayon::prelude::*;
use std::ops::Range;

/// Positions and normals of one level by slot. Follows edits at the cost of what they moved.
#[derive(Debug, Clone)]
pub struct ShownVertices {
    level: Level,
    frame: Frame,
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    /// Added to the level's positions; empty: nothing.
    offsets: Vec<[f32; 3]>,
}

/// Runs of changed slots closer than this are uploaded as one.
const GAP: u32 = 64;

impl ShownVertices {
    /// All vertices of a level. Linear in their number.
    pub fn new(surface: &Surface, level: Level) -> Self {
        let frame = Frame::of(&surface.form().placement);
        let positions: Vec<[f32; 3]> =
            surface.scaling(level).par_iter().map(|&p| frame.place_f32(p)).collect();
        let layout = surface.hierarchy().layout(level);
        let normals =
            (0..layout.len()).into_par_iter().map(|s| normal(layout, Slot(s), &positions)).collect();
        Self { level, frame, positions, normals, offsets: Vec::new() }
    }

    /// The vertices of a coarser level where a finer surface has them now, and from now on moved as the coarse level
    /// moves: samples of the fine surface while only the coarse one follows an edit. Finer detail rides along with
    /// scaling and wavelet coefficients, so the samples are exact. Linear in the coarse level's vertices.
    pub fn sampled(surface: &Surface, level: Level, finer: &ShownVertices) -> Self {
        let mut shown = Self::new(surface, level);
        let hierarchy = surface.hierarchy();
        let layout = hierarchy.layout(level);
        shown.offsets = (0..layout.len())
            .into_par_iter()
            .map(|slot| {
                let fine = finer.positions[hierarchy.refine_slot(level, finer.level, Slot(slot)).index()];
                difference(fine, shown.positions[slot as usize])
            })
            .collect();
        let all = (0..layout.len()).map(Slot).collect();
        shown.follow(surface, &Moved::Some(all));
        shown
    }

    /// Where a slot is drawn now.
    fn placed(&self, surface: &Surface, slot: Slot) -> [f32; 3] {
        let at = self.frame.place_f32(surface.scaling(self.level)[slot.index()]);
        match self.offsets.get(slot.index()) {
            Some(offset) => std::array::from_fn(|c| at[c] + offset[c]),
            None => at,
        }
    }

    /// The level.
    pub fn level(&self) -> Level {
        self.level
    }

    /// The space the positions are in.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Positions by slot.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    /// Unit normals by slot.
    pub fn normals(&self) -> &[[f32; 3]] {
        &self.normals
    }

    /// Takes over what an edit moved; the runs of slots to upload. Cost: the moved vertices and their neighbours.
    pub fn follow(&mut self, surface: &Surface, moved: &Moved) -> Vec<Range<u32>> {
        match moved {
            Moved::Nothing => Vec::new(),
            Moved::Everything => {
                *self = Self::new(surface, self.level);
                std::iter::once(0..self.positions.len() as u32).collect()
            }
            Moved::Some(slots) => {
                let layout = surface.hierarchy().layout(self.level);
                for &slot in slots {
                    self.positions[slot.index()] = self.placed(surface, slot);
                }
                let mut turned: Vec<u32> =
                    slots.par_iter().flat_map_iter(|&slot| around(layout, slot)).collect();
                turned.par_sort_unstable();
                turned.dedup();
                let normals: Vec<[f32; 3]> =
                    turned.par_iter().map(|&slot| normal(layout, Slot(slot), &self.positions)).collect();
                for (&slot, normal) in turned.iter().zip(normals) {
                    self.normals[slot as usize] = normal;
                }
                runs(&turned)
            }
        }
    }
}

fn difference(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|c| a[c] - b[c])
}

/// A vertex and its neighbours.
fn around(layout: &Layout, slot: Slot) -> impl Iterator<Item = u32> {
    let ring: Vec<u32> = layout.ring_slots(layout.site(slot)).map(|s| s.0).collect();
    std::iter::once(slot.0).chain(ring)
}

/// Joins sorted slots to runs, over small gaps.
fn runs(slots: &[u32]) -> Vec<Range<u32>> {
    let mut runs: Vec<Range<u32>> = Vec::new();
    for &slot in slots {
        match runs.last_mut() {
            Some(run) if slot <= run.end + GAP => run.end = slot + 1,
            _ => runs.push(slot..slot + 1),
        }
    }
    runs
}

/// The normal of a vertex: its faces' normals, weighted by area.
fn normal(layout: &Layout, slot: Slot, positions: &[[f32; 3]]) -> [f32; 3] {
    let ring = layout.ring(layout.site(slot));
    let at = |s: usize| DVec3::from_array(positions[layout.slot(ring.around[s]).index()].map(f64::from));
    let centre = DVec3::from_array(positions[slot.index()].map(f64::from));
    let sum: DVec3 = (0..ring.faces())
        .map(|k| (at(k) - centre).cross(at((k + 1) % ring.around.len()) - centre))
        .fold(DVec3::ZERO, |sum, n| sum + n);
    sum.normalize_or(DVec3::Y).as_vec3().to_array()
}
