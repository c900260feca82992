//! Replaying a log or script onto a surface.

use super::attic::Attic;
use crate::edit::{Edit, EditError, Entry, Packed, Step, plan};
use crate::file::NumberedLine;
use crate::surface::{Changes, Surface, SurfaceHash};
use thiserror::Error;

/// Why a replay stopped, and at which line.
#[derive(Debug, Error, Clone, PartialEq)]
#[error("line {line}: {reason}")]
pub struct ReplayError {
    /// The line's number in its file, from 1.
    pub line: usize,
    /// What is wrong with it.
    pub reason: ReplayReason,
}

/// Why a line cannot be replayed.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum ReplayReason {
    /// The edit is refused.
    #[error("{0}")]
    Refused(#[from] EditError),
    /// Fewer steps were made than are to be undone.
    #[error("it undoes {}, but there are only {there}", steps(*.wanted))]
    NothingToUndo {
        /// As many as the line says.
        wanted: u32,
        /// As many as there are.
        there: usize,
    },
    /// Fewer steps were undone than are to be redone.
    #[error("it redoes {}, but there are only {there}", steps(*.wanted))]
    NothingToRedo {
        /// As many as the line says.
        wanted: u32,
        /// As many as there are.
        there: usize,
    },
    /// The surface is not the one the log saw.
    #[error(
        "the surface here has hash {found}, not {stated} as recorded; the log belongs to another surface"
    )]
    Hash {
        /// What the line says.
        stated: SurfaceHash,
        /// What the surface has.
        found: SurfaceHash,
    },
    /// A step of the history that was put away cannot be read.
    #[error(
        "the step before cannot be read any more: {0}; make room on the disk for scratch files and open again"
    )]
    Lost(String),
    /// The user stopped it.
    #[error("stopped")]
    Cancelled,
}

/// The undo record of a session.
pub(super) type Record = undo::Record<Step>;

/// Lines that count: what a `discard` takes back is gone. With `saved`, up to the last save mark only.
pub fn effective(lines: &[NumberedLine], saved: bool) -> Vec<NumberedLine> {
    let mut kept: Vec<NumberedLine> = Vec::new();
    let mut mark = 0;
    for line in lines {
        match line.line.entry {
            Entry::Discard => kept.truncate(mark),
            Entry::Save => {
                kept.push(line.clone());
                mark = kept.len();
            }
            _ => kept.push(line.clone()),
        }
    }
    if saved {
        kept.truncate(mark);
    }
    kept
}

/// Plans, applies and records one edit.
pub(super) fn perform(surface: &mut Surface, record: &mut Record, edit: Edit) -> Result<Changes, EditError> {
    let planned = plan(surface, &edit)?;
    let (step, _) = Step::apply(surface, edit, planned)?;
    Ok(record.edit(surface, step))
}

fn steps(count: u32) -> String {
    if count == 1 { "a step".to_owned() } else { format!("{count} steps") }
}

/// Replays one entry; old steps go to the attic when they outgrow its budget.
pub(super) fn replay_entry(
    surface: &mut Surface,
    (record, attic): (&mut Record, &mut Attic),
    entry: &Entry,
) -> Result<Option<Changes>, ReplayReason> {
    let mut joined: Option<Changes> = None;
    let mut join = |changes: Changes| match &mut joined {
        Some(all) => all.join(changes),
        None => joined = Some(changes),
    };
    match entry {
        Entry::Edit(edit) => {
            join(perform(surface, record, edit.clone())?);
            if let Some(packed) = packed(record, record.head() - 1) {
                attic.keep(packed);
            }
        }
        Entry::Undo(wanted) => {
            if record.head() < *wanted as usize {
                return Err(ReplayReason::NothingToUndo { wanted: *wanted, there: record.head() });
            }
            for _ in 0..*wanted {
                call_back(attic, record, record.head() - 1)?;
                record.undo(surface).map(&mut join);
            }
        }
        Entry::Redo(wanted) => {
            let there = record.len() - record.head();
            if there < *wanted as usize {
                return Err(ReplayReason::NothingToRedo { wanted: *wanted, there });
            }
            for _ in 0..*wanted {
                call_back(attic, record, record.head())?;
                record.redo(surface).map(&mut join);
            }
        }
        Entry::Save | Entry::Discard | Entry::Binding { .. } => {}
    }
    Ok(joined)
}

fn packed(record: &Record, at: usize) -> Option<&Packed> {
    Some(record.entries().nth(at)?.as_ref().packed())
}

fn call_back(attic: &mut Attic, record: &Record, at: usize) -> Result<(), ReplayReason> {
    packed(record, at)
        .map_or(Ok(()), |packed| attic.call_back(packed))
        .map_err(|error| ReplayReason::Lost(error.to_string()))
}

/// Replays lines in order, the history kept within the attic's budget; returns how many were edits. `progress` gets the share done and returns whether to go on.
///
/// # Errors
/// The first line that cannot be replayed; the surface then holds everything before it.
pub(super) fn replay(
    surface: &mut Surface,
    (record, attic): (&mut Record, &mut Attic),
    lines: &[NumberedLine],
    progress: &dyn Fn(f32) -> bool,
) -> Result<u64, ReplayError> {
    let mut edits = 0;
    for (at, NumberedLine { number, line }) in lines.iter().enumerate() {
        let stop = |reason| ReplayError { line: *number, reason };
        if !progress(at as f32 / lines.len() as f32) {
            return Err(stop(ReplayReason::Cancelled));
        }
        replay_entry(surface, (record, attic), &line.entry).map_err(stop)?;
        edits += u64::from(matches!(line.entry, Entry::Edit(_)));
        if let Some(stated) = line.hash {
            let found = surface.hash();
            if stated != found {
                return Err(stop(ReplayReason::Hash { stated, found }));
            }
        }
    }
    Ok(edits)
}

#[cfg(test)]
mod tests;
