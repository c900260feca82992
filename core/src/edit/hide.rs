//! Hiding: parts of the surface that are not drawn, not hit and not changed by brushes.
//!
//! Like the mask it guides the hand and is no part of the surface; the log holds it as edits.

use super::plan::EditError;
use super::vocabulary::{first, is_first};
use crate::hierarchy::{Layout, Slot};
use crate::surface::Surface;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Masked from here on counts as masked.
const HALF: u8 = 128;

/// What is hidden.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// What is masked, by half at least, beside what is hidden already.
    Mask,
    /// What is not masked: the masked part is alone then.
    Free,
    /// The listed base faces, beside what is hidden already.
    Faces,
    /// All but the listed base faces.
    Others,
    /// Nothing: everything is shown again.
    Nothing,
    /// What was shown, and what was hidden is shown.
    Shown,
}

/// Hides a part of the surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hide {
    /// Which.
    pub part: Part,
    /// Base faces, for `faces` and `others`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub faces: Vec<u32>,
    /// Version of the operation.
    #[serde(default = "first", skip_serializing_if = "is_first")]
    pub v: u32,
}

impl fmt::Display for Hide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self.part {
            Part::Mask => "Hide what is masked",
            Part::Free => "Isolate what is masked",
            Part::Faces => "Hide base faces",
            Part::Others => "Isolate base faces",
            Part::Nothing => "Show everything",
            Part::Shown => "Turn hiding round",
        })
    }
}

/// The vertices of the finest level that are hidden or shown again, in order. `O(n_J)`.
pub(super) fn plan_hide(surface: &Surface, edit: &Hide) -> Result<Vec<Slot>, EditError> {
    let layout = surface.hierarchy().layout(surface.finest());
    let count = layout.base().faces().len() as u32;
    if let Some(&face) = edit.faces.iter().find(|face| **face >= count) {
        return Err(EditError::UnknownFace { face, last: count - 1 });
    }
    let mask = surface.mask();
    let listed = vertices_of(layout, &edit.faces);
    let wanted = |slot: Slot| {
        let hidden = mask.is_hidden(slot);
        match edit.part {
            Part::Mask => hidden || mask.value(slot) >= HALF,
            Part::Free => mask.value(slot) < HALF,
            Part::Faces => hidden || listed[slot.index()],
            Part::Others => !listed[slot.index()],
            Part::Nothing => false,
            Part::Shown => !hidden,
        }
    };
    Ok((0..layout.len()).map(Slot).filter(|&slot| wanted(slot) != mask.is_hidden(slot)).collect())
}

/// The vertices in the closed listed faces, by slot.
fn vertices_of(layout: &Layout, faces: &[u32]) -> Vec<bool> {
    let n = layout.segments();
    let mut listed = vec![false; layout.len() as usize];
    for &face in faces {
        for r in 0..=n {
            for i in 0..=n - r {
                listed[layout.slot(layout.site_at(face, [n - i - r, i, r])).index()] = true;
            }
        }
    }
    listed
}
