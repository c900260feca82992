//! Edits as the editor makes them: planned, applied with local synthesis and analysis, and followed by the shown
//! vertices and their normals up to the runs of slots that would be uploaded.

use super::timings::Timings;
use crate::display::ShownVertices;
use anyhow::Result;
use bozzetto_core::disk::Disk;
use bozzetto_core::edit::{Edit, Kind, Move, Region, Step, plan};
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::session::Session;
use bozzetto_core::surface::{Changes, Surface};
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

/// How far things are moved, in model units: the models are two across.
const DELTA: [f64; 3] = [0.004, 0.002, -0.003];

/// A surface with its shown vertices.
pub(super) struct Sculpture {
    surface: Surface,
    shown: ShownVertices,
}

impl Sculpture {
    /// Shows the finest level.
    pub(super) fn new(surface: Surface) -> Self {
        let shown = ShownVertices::new(&surface, surface.finest());
        Self { surface, shown }
    }

    /// Moves one scaling coefficient of a level and undoes that, at so many places one after the other. Both medians.
    ///
    /// # Errors
    /// The edit is refused.
    pub(super) fn move_and_undo(&mut self, level: Level, places: u32) -> Result<EditCost> {
        let (mut made, mut ratios) = (Timings::default(), Timings::default());
        for vertex in spread(self.surface.hierarchy().layout(level).len(), places) {
            let edit = Edit::Move(scaling(level, vertex, None));
            let mut step = made.time(|| -> Result<Step> {
                let plan = plan(&self.surface, &edit)?;
                let (step, changes) = Step::apply(&mut self.surface, edit, plan)?;
                follow(&mut self.shown, &self.surface, &changes);
                Ok(step)
            })?;
            // The first call of a record only hands over the changes made.
            undo::Edit::edit(&mut step, &mut self.surface);
            let begun = Instant::now();
            let changes = undo::Edit::undo(&mut step, &mut self.surface);
            follow(&mut self.shown, &self.surface, &changes);
            ratios.push(begun.elapsed().as_secs_f64() / made.last());
        }
        Ok(EditCost { seconds: made.median(), undo_ratio: ratios.median() })
    }

    /// The surface alone.
    pub(super) fn into_surface(self) -> Surface {
        self.surface
    }
}

/// What an edit takes, and how many times that its undo.
#[derive(Debug, Clone, Copy)]
pub(super) struct EditCost {
    pub(super) seconds: f64,
    pub(super) undo_ratio: f64,
}

/// A brush dab: each call of the hand moves all vertices of the finest level within a radius, by weight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dab {
    /// The vertices it touches.
    pub(super) vertices: usize,
    /// Its median, without the analysis that ends a stroke.
    pub(super) seconds: f64,
    /// The same with the normals and what is to be uploaded.
    pub(super) shown: f64,
}

/// Strokes of a few dabs each that touch `vertices` at least, or as many as there are.
///
/// # Errors
/// The edit is refused.
pub(super) fn dab(surface: Surface, vertices: usize, strokes: u32) -> Result<Dab> {
    let finest = surface.finest();
    let mut shown = ShownVertices::new(&surface, finest);
    let mut session = Session::new(Arc::new(Disk), Model::new(surface, None, Metadata::default()));
    let (mut moving, mut showing) = (Timings::default(), Timings::default());
    let mut touched = Vec::new();
    for vertex in spread(session.surface().hierarchy().layout(finest).len(), strokes) {
        let (radius, count) = radius_around(session.surface(), vertex, vertices)?;
        touched.push(count);
        session.begin_stroke(scaling(finest, vertex, Some(radius)))?;
        for dab in 1..=8 {
            let delta = DELTA.map(|x| x * f64::from(dab));
            let begun = Instant::now();
            let changes = moving.time(|| session.drag_to(delta))?;
            follow(&mut shown, session.surface(), &changes);
            showing.push(begun.elapsed().as_secs_f64());
        }
        let changes = session.cancel_stroke();
        follow(&mut shown, session.surface(), &changes);
    }
    touched.sort_unstable();
    Ok(Dab { vertices: touched[touched.len() / 2], seconds: moving.median(), shown: showing.median() })
}

/// The radius, found by halving, within which at least so many vertices of the finest level lie; and how many do.
fn radius_around(surface: &Surface, vertex: u32, vertices: usize) -> Result<(f64, usize)> {
    let count = |radius: f64| -> Result<usize> {
        match Region::of(surface, &scaling(surface.finest(), vertex, Some(radius)))?.0 {
            Region::Scaling(_, region) => Ok(region.len()),
            Region::Wavelets(_, region) => Ok(region.len()),
            Region::Pulled(_) => unreachable!("a move of scaling coefficients is no pull"),
        }
    };
    let (mut low, mut high) = (0.0, 3.0);
    for _ in 0..16 {
        let middle = (low + high) / 2.0;
        if count(middle)? >= vertices { high = middle } else { low = middle }
    }
    Ok((high, count(high)?))
}

fn scaling(level: Level, vertex: u32, radius: Option<f64>) -> Move {
    Move {
        kind: Kind::Scaling,
        level: level.0,
        vertex,
        delta: DELTA,
        radius,
        falloff: None,
        mirror: None,
        v: 1,
    }
}

fn follow(shown: &mut ShownVertices, surface: &Surface, changes: &Changes) {
    black_box(shown.follow(surface, changes.at(shown.level())));
}

/// So many of `0..count`, far from each other and in no order of storage.
fn spread(count: u32, places: u32) -> impl Iterator<Item = u32> {
    const GOLDEN: f64 = 0.618_033_988_749_895;
    (1..=places).map(move |k| ((f64::from(k) * GOLDEN).fract() * f64::from(count)) as u32)
}

#[cfg(test)]
mod tests {
    use super::super::shape::Base;
    use super::*;

    /// What is timed is the real thing: it moves vertices, and undo puts them back.
    #[test]
    fn edits_are_made_and_undone() {
        let surface = Base::EightFaces.surface(4).expect("small");
        let mut sculpture = Sculpture::new(surface.clone());
        for level in [0, 1, 4] {
            let cost = sculpture.move_and_undo(Level(level), 5).expect("in range");
            assert!(cost.seconds > 0.0 && cost.undo_ratio > 0.0);
        }
        let surface_after = sculpture.into_surface();
        assert_eq!(surface_after.hash(), surface.hash());
        assert_eq!(surface_after.scaling(Level(4)), surface.scaling(Level(4)));
    }

    #[test]
    fn a_dab_touches_what_it_is_asked_to() {
        let surface = Base::EightFaces.surface(5).expect("small");
        let dab = dab(surface, 150, 3).expect("in range");
        assert!((150..200).contains(&dab.vertices), "{dab:?}");
        assert!(0.0 < dab.seconds && dab.seconds < dab.shown);
    }
}
