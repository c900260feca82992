//! The mask: how far each vertex is kept from the brushes, and which are hidden.
//!
//! It guides the hand and is no part of the surface: neither the surface hash nor the wavelet file holds it, but the
//! log does, as edits. One byte a finest vertex, once something is masked; coarser vertices have the value of the same
//! vertex on the finest level.

use super::Surface;
use crate::hierarchy::{Level, Slot};

/// Values by slot of the finest level: 0 free, 255 kept as it is.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Mask {
    pub(super) values: Vec<u8>,
    pub(super) hidden: Vec<bool>,
}

impl Mask {
    /// The value at a slot of the finest level.
    pub fn value(&self, slot: Slot) -> u8 {
        self.values.get(slot.index()).copied().unwrap_or(0)
    }

    /// Whether a vertex of the finest level is hidden.
    pub fn is_hidden(&self, slot: Slot) -> bool {
        self.hidden.get(slot.index()).copied().unwrap_or(false)
    }

    /// Values by slot; empty where nothing was ever masked.
    pub fn values(&self) -> &[u8] {
        &self.values
    }

    /// Hidden vertices by slot; empty where nothing was ever hidden.
    pub fn hidden(&self) -> &[bool] {
        &self.hidden
    }

    /// Whether nothing is masked or hidden, as far as is known without looking.
    pub fn is_unused(&self) -> bool {
        self.values.is_empty() && self.hidden.is_empty()
    }

    /// Writes a value; the one before. `len` is the number of finest vertices.
    pub(crate) fn put(&mut self, slot: Slot, value: u8, len: usize) -> u8 {
        self.values.resize(len, 0);
        std::mem::replace(&mut self.values[slot.index()], value)
    }

    /// Hides a vertex, or shows it again. `len` is the number of finest vertices.
    pub(crate) fn flip_hidden(&mut self, slot: Slot, len: usize) {
        self.hidden.resize(len, false);
        self.hidden[slot.index()] ^= true;
    }

    /// Whether something is hidden. Linear in the finest vertices once something was.
    pub fn hides_something(&self) -> bool {
        self.hidden.contains(&true)
    }
}

impl Surface {
    /// How much a brush may do at a vertex of a level: 1 free, 0 masked or hidden.
    pub fn freedom(&self, level: Level, slot: Slot) -> f64 {
        if self.mask.is_unused() {
            return 1.0;
        }
        let fine = self.hierarchy().refine_slot(level, self.finest(), slot);
        if self.mask.is_hidden(fine) { 0.0 } else { f64::from(255 - self.mask.value(fine)) / 255.0 }
    }
}
