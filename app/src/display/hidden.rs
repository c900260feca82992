//! Which faces of the shown level are hidden.

use bozzetto_core::hierarchy::{Level, Slot};
use bozzetto_core::surface::Surface;

/// The faces of a level whose corners are all hidden.
#[derive(Debug, Clone, Copy)]
pub struct HiddenFaces<'a> {
    /// None where nothing is hidden.
    of: Option<(&'a Surface, Level)>,
}

impl<'a> HiddenFaces<'a> {
    /// Those of a level of a surface.
    pub fn of(surface: &'a Surface, level: Level) -> Self {
        Self { of: (!surface.mask().hidden().is_empty()).then_some((surface, level)) }
    }

    /// Whether a face, edge or vertex with these corners, slots of the level, is hidden.
    pub fn hides<const CORNERS: usize>(&self, corners: [u32; CORNERS]) -> bool {
        self.of.is_some_and(|(surface, level)| {
            let fine = |slot| surface.hierarchy().refine_slot(level, surface.finest(), Slot(slot));
            corners.into_iter().all(|slot| surface.mask().is_hidden(fine(slot)))
        })
    }
}
