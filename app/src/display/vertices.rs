//! The vertices of the shown level, for the renderer.

use super::{Frame, normals};
use bozzetto_core::hierarchy::{Level, Slot};
use bozzetto_core::memory::Buffer;
use bozzetto_core::surface::{Moved, Surface};
use std::ops::Range;

/// Positions and normals of one level by slot. Follows edits at the cost of what they moved.
#[derive(Debug, Clone)]
pub struct ShownVertices {
    level: Level,
    frame: Frame,
    positions: Buffer<[f32; 3]>,
    normals: Buffer<[f32; 3]>,
    /// Added to the level's positions; empty: nothing.
    offsets: Buffer<[f32; 3]>,
}

/// Runs of changed slots closer than this are uploaded as one.
const GAP: u32 = 64;

impl ShownVertices {
    /// All vertices of a level. Linear in their number.
    pub fn new(surface: &Surface, level: Level) -> Self {
        let frame = Frame::of(&surface.form().placement);
        let steps = surface.scaling(level);
        let positions = Buffer::of(steps.len(), |slot| frame.place_f32(steps[slot]));
        let normals = normals::all(surface.hierarchy().layout(level), &positions);
        Self { level, frame, positions, normals, offsets: Buffer::default() }
    }

    /// The vertices of a coarser level where a finer surface has them now, and from now on moved as the coarse level
    /// moves: samples of the fine surface while only the coarse one follows an edit. Finer detail rides along with
    /// scaling and wavelet coefficients, so the samples are exact. Linear in the coarse level's vertices.
    pub fn sampled(surface: &Surface, level: Level, finer: &ShownVertices) -> Self {
        let mut shown = Self::new(surface, level);
        let hierarchy = surface.hierarchy();
        let layout = hierarchy.layout(level);
        shown.offsets = Buffer::of(shown.positions.len(), |slot| {
            let fine = hierarchy.refine_slot(level, finer.level, Slot(slot as u32));
            difference(finer.positions[fine.index()], shown.positions[slot])
        });
        shown.place(surface, 0..layout.len() as usize);
        shown.normals = normals::all(layout, &shown.positions);
        shown
    }

    /// Places vertices where they are drawn now.
    fn place(&mut self, surface: &Surface, slots: Range<usize>) {
        let steps = &surface.scaling(self.level)[slots.clone()];
        let positions = &mut self.positions[slots.clone()];
        self.frame.place_all(steps, positions);
        if !self.offsets.is_empty() {
            for (position, offset) in positions.iter_mut().zip(&self.offsets[slots]) {
                *position = std::array::from_fn(|c| position[c] + offset[c]);
            }
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
                self.place(surface, 0..self.positions.len());
                let layout = surface.hierarchy().layout(self.level);
                normals::refresh_all(layout, &self.positions, &mut self.normals);
                std::iter::once(0..self.positions.len() as u32).collect()
            }
            Moved::Some(runs) => {
                let layout = surface.hierarchy().layout(self.level);
                for run in runs.iter() {
                    self.place(surface, run.start as usize..run.end as usize);
                }
                let turned = normals::widened(layout, &normals::rows_of(layout, runs.iter()));
                normals::refresh(layout, &self.positions, &turned, &mut self.normals);
                joined(turned.iter().map(|row| row.slots(layout)))
            }
        }
    }
}

fn difference(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|c| a[c] - b[c])
}

/// Joins sorted runs over small gaps.
fn joined(runs: impl Iterator<Item = Range<u32>>) -> Vec<Range<u32>> {
    let mut joined: Vec<Range<u32>> = Vec::new();
    for run in runs {
        match joined.last_mut() {
            Some(last) if run.start <= last.end + GAP => last.end = run.end,
            _ => joined.push(run),
        }
    }
    joined
}
