//! Where the history goes when it outgrows its share of memory.
//!
//! Steps are kept packed. When all of them together take more than the budget, the oldest move to a scratch file, and come
//! back when they are undone. The lines of the log are kept the same way, as text.

use crate::disk::Scratch;
use crate::edit::{Entry, Kept, Line, Packed};
use crate::surface::SurfaceHash;
use std::collections::VecDeque;
use std::io;
use std::sync::{Mutex, Weak};

/// Bytes of history that stay in memory, unless told otherwise.
pub const HISTORY_BUDGET: usize = 256 << 20;
/// Lines of the log are put away in pieces of this length.
const PIECE: usize = 1 << 16;

/// The steps' bytes, oldest first, and what of them is in memory.
#[derive(Debug)]
pub(super) struct Attic {
    budget: usize,
    scratch: Scratch,
    /// Handles of steps that were in memory when last looked at.
    handles: VecDeque<Weak<Mutex<Box<dyn Kept>>>>,
    /// An upper bound of what they take: dropped steps count until the next time it matters.
    in_memory: usize,
}

impl Default for Attic {
    fn default() -> Self {
        Self { budget: HISTORY_BUDGET, scratch: Scratch::default(), handles: VecDeque::new(), in_memory: 0 }
    }
}

impl Attic {
    /// Chooses how many bytes may stay in memory.
    pub(super) fn set_budget(&mut self, bytes: usize) {
        self.budget = bytes;
        self.make_room();
    }

    /// Takes note of a step, new or called back, and makes room.
    pub(super) fn keep(&mut self, packed: &Packed) {
        let handle = packed.handle();
        self.in_memory += handle.lock().map_or(0, |kept| kept.in_memory());
        self.handles.push_back(std::sync::Arc::downgrade(handle));
        self.make_room();
    }

    /// Brings a step back into memory, before it is undone or redone.
    ///
    /// # Errors
    /// It cannot be read any more.
    pub(super) fn call_back(&mut self, packed: &Packed) -> io::Result<()> {
        if packed.call_back()? {
            self.keep(packed);
        }
        Ok(())
    }

    /// How much of the history is in memory.
    pub(super) fn in_memory(&self) -> usize {
        let alive = self.handles.iter().filter_map(Weak::upgrade);
        alive.map(|handle| handle.lock().map_or(0, |kept| kept.in_memory())).sum()
    }

    fn make_room(&mut self) {
        if self.in_memory <= self.budget {
            return;
        }
        self.handles.retain(|handle| handle.strong_count() > 0);
        self.in_memory = self.in_memory();
        // Half of it, so that this is not done for every step.
        while self.in_memory > self.budget / 2 {
            let Some(handle) = self.handles.pop_front() else { break };
            let Some(handle) = handle.upgrade() else { continue };
            let Ok(mut kept) = handle.lock() else { continue };
            let stored = kept.read().and_then(|bytes| self.scratch.store(&bytes));
            match stored {
                Ok(stored) => {
                    self.in_memory = self.in_memory.saturating_sub(kept.in_memory());
                    *kept = Box::new(stored);
                }
                // Without a scratch file everything stays where it is.
                Err(_) => {
                    drop(kept);
                    self.handles.push_front(std::sync::Arc::downgrade(&handle));
                    break;
                }
            }
        }
    }
}

/// The lines of a log, counted and as text.
#[derive(Debug, Default)]
pub(super) struct LogText {
    lines: usize,
    put_away: Vec<Box<dyn Kept>>,
    recent: Vec<u8>,
    scratch: Scratch,
}

impl LogText {
    /// The lines so far.
    pub(super) fn len(&self) -> usize {
        self.lines
    }

    /// Adds a line.
    pub(super) fn push(&mut self, entry: &Entry, hash: Option<SurfaceHash>) {
        self.recent.extend_from_slice(Line::to_text(entry, hash).as_bytes());
        self.recent.push(b'\n');
        self.lines += 1;
        if self.recent.len() > PIECE {
            let piece = std::mem::take(&mut self.recent);
            self.put_away.push(match self.scratch.store(&piece) {
                Ok(stored) => Box::new(stored),
                Err(_) => Box::new(piece),
            });
        }
    }

    /// All of it.
    ///
    /// # Errors
    /// What was put away cannot be read.
    pub(super) fn text(&self) -> io::Result<Vec<u8>> {
        let mut text = Vec::new();
        for piece in &self.put_away {
            text.extend(piece.read()?);
        }
        text.extend_from_slice(&self.recent);
        Ok(text)
    }

    /// Bytes in memory.
    pub(super) fn in_memory(&self) -> usize {
        self.recent.len() + self.put_away.iter().map(|piece| piece.in_memory()).sum::<usize>()
    }
}
