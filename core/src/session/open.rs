//! Opening: wavelet file + log.

use super::attic::{Attic, LogText};
use super::replay::{Record, effective, replay};
use super::{FileError, Journal, Model, Session, SessionError, Shared, decode, io_error, lock, log_path};
use crate::disk::Vfs;
use crate::edit::Entry;
use crate::file::{Log, NumberedLine, read_log, write_log};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How much of the log counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum LogUse {
    /// All of it.
    #[default]
    Whole,
    /// Up to the last save mark.
    Saved,
    /// None.
    Ignored,
}

/// How to open.
#[derive(Debug, Clone, Copy, Default)]
pub struct OpenOptions {
    /// How much of the log counts.
    pub log: LogUse,
    /// Take a log that names another file.
    pub rebind: bool,
}

/// A session with what its user should know about the files.
#[derive(Debug)]
pub struct Opened {
    /// The session.
    pub session: Session,
    /// One sentence each.
    pub notes: Vec<String>,
}

/// What opening reads, before anything is replayed.
struct Parts {
    model: Model,
    lines: Vec<NumberedLine>,
    log: Log,
    /// The log names another file and was taken all the same.
    rebound: bool,
    notes: Vec<String>,
}

fn read_parts(vfs: &dyn Vfs, path: &Path, options: OpenOptions) -> Result<Parts, SessionError> {
    let bytes = vfs.read(path).map_err(|cause| io_error(path, cause))?;
    let model = decode(&bytes, path)?;
    let mut notes = Vec::new();
    let logs = log_path(path);
    let log = if options.log != LogUse::Ignored && vfs.exists(&logs) {
        read_log(&vfs.read(&logs).map_err(|cause| io_error(&logs, cause))?, true)
    } else {
        Log::default()
    };
    if model.tail_cut {
        notes.push(format!(
            "{}: the surface is whole, but the file was cut short after it; what stood beside it may be missing",
            path.display()
        ));
    }
    let expected = model.stated_hash.to_string();
    let foreign = log.of.as_ref().filter(|of| **of != expected);
    let rebound = match foreign {
        Some(of) if !options.rebind => {
            return Err(FileError::ForeignLog { path: logs, of: of.clone(), expected }.into());
        }
        Some(of) => {
            notes
                .push(format!("{}: this log of another wavelet file ({of}) is applied here", logs.display()));
            true
        }
        None => false,
    };
    if log.torn {
        notes.push(format!("{}: the last line was cut short and is left out", logs.display()));
    }
    let mut lines = effective(&log.lines, options.log == LogUse::Saved);
    if rebound {
        // The recorded hashes are those of the other surface.
        lines.iter_mut().for_each(|numbered| numbered.line.hash = None);
    }
    Ok(Parts { model, lines, log, rebound, notes })
}

/// Reads a wavelet file and replays its log, without a lock and without writing anything. A partial file is taken
/// with a note, unless it has a log.
///
/// # Errors
/// Files that cannot be read or do not fit together, or a log that is damaged or cannot be replayed.
pub fn open_model(
    vfs: &dyn Vfs,
    path: &Path,
    options: OpenOptions,
) -> Result<(Model, Vec<String>), SessionError> {
    let Parts { mut model, lines, log, mut notes, .. } = read_parts(vfs, path, options)?;
    if !model.complete {
        if !lines.is_empty() {
            return Err(SessionError::PartialWithLog { path: path.to_owned() });
        }
        notes.push(format!("{} is incomplete: missing detail is left out", path.display()));
    }
    if let Some((line, what)) = log.damage {
        return Err(damaged(&log_path(path), line, what).into());
    }
    let mut record = Record::new();
    replay(&mut model.surface, (&mut record, &mut Attic::default()), &lines, &|_| true)
        .map_err(|error| SessionError::Replay { path: log_path(path), error })?;
    if record.entries().take(record.head()).any(|entry| entry.as_ref().reshapes()) {
        model.source = None;
    }
    Ok((model, notes))
}

fn damaged(path: &Path, line: usize, what: String) -> FileError {
    let mend = "restore the log from a copy, or open without it (--base)";
    FileError::Content { path: path.to_owned(), place: format!("line {line}"), what, mend }
}

impl Session {
    /// Opens a wavelet file with its log for editing, and takes its lock. A damaged log is kept as a copy beside it;
    /// the session goes on from the good part. `progress` gets the share done and returns whether to go on.
    ///
    /// # Errors
    /// Files that cannot be read, do not fit together, or are open elsewhere.
    pub fn open(
        vfs: Arc<dyn Vfs>,
        path: &Path,
        options: OpenOptions,
        progress: &dyn Fn(f32) -> bool,
    ) -> Result<Opened, SessionError> {
        let lock = lock(&*vfs, path)?;
        let Parts { model, lines, log, rebound, mut notes } = read_parts(&*vfs, path, options)?;
        let mut session = Self::replayed(vfs.clone(), path, model, lines, progress)?;
        let logs = log_path(path);
        let mut keep = log.good_bytes;
        if let Some((line, what)) = &log.damage {
            let copy = keep_copy(&*vfs, &logs)?;
            let (logs, copy) = (logs.display(), copy.display());
            notes.push(format!(
                "{logs}, line {line}: {what}; the edits before it are kept, all of it is in {copy}"
            ));
        }
        if (options.log != LogUse::Whole || rebound) && vfs.exists(&logs) {
            // What is left out stays in a copy; the log itself goes on from what was taken.
            let copy = keep_copy(&*vfs, &logs)?;
            notes.push(format!("the whole log is kept in {}", copy.display()));
            keep = 0;
        }
        // A log of blank lines has no binding yet either.
        if keep == 0 || log.of.is_none() {
            keep = write_log(
                &*vfs,
                path,
                session.original,
                &session.log.text().map_err(|cause| io_error(&logs, cause))?,
            )?;
        }
        let journal = Journal::open(&*vfs, path, keep, lock)?;
        session.path = Some(path.to_owned());
        session.journal = Some(journal);
        Ok(Opened { session, notes })
    }

    /// Opens a wavelet file with its log as a surface that has no file yet: nothing is locked or written until it is
    /// saved under a name of its own.
    ///
    /// # Errors
    /// Files that cannot be read or do not fit together, or a damaged log.
    pub fn open_detached(
        vfs: Arc<dyn Vfs>,
        path: &Path,
        options: OpenOptions,
        progress: &dyn Fn(f32) -> bool,
    ) -> Result<Opened, SessionError> {
        let Parts { model, lines, log, notes, .. } = read_parts(&*vfs, path, options)?;
        if let Some((line, what)) = log.damage {
            return Err(damaged(&log_path(path), line, what).into());
        }
        let mut session = Self::replayed(vfs.clone(), path, model, lines, progress)?;
        session.unsaved = Some(Arc::new(vfs.read(path).map_err(|cause| io_error(path, cause))?));
        Ok(Opened { session, notes })
    }

    /// A session without file or journal, its log replayed.
    fn replayed(
        vfs: Arc<dyn Vfs>,
        path: &Path,
        mut model: Model,
        lines: Vec<NumberedLine>,
        progress: &dyn Fn(f32) -> bool,
    ) -> Result<Self, SessionError> {
        if !model.complete {
            return Err(SessionError::Partial { path: path.to_owned() });
        }
        let original = model.stated_hash;
        let mut record = Record::new();
        let mut attic = Attic::default();
        let edits = replay(&mut model.surface, (&mut record, &mut attic), &lines, progress)
            .map_err(|error| SessionError::Replay { path: log_path(path), error })?;
        let saved_at = lines.iter().rposition(|l| l.line.entry == Entry::Save).map_or(0, |at| at + 1);
        let mut log = LogText::default();
        lines.iter().for_each(|l| log.push(&l.line.entry, l.line.hash));
        let source = model.source.clone();
        let mut session = Self {
            vfs: Shared(vfs),
            model,
            unsaved: None,
            path: None,
            original,
            record,
            log,
            saved_at,
            edits,
            journal: None,
            stroke: None,
            brush: None,
            equaliser: None,
            glimpse: None,
            source,
            history_failure: None,
            attic,
        };
        session.source_fits();
        Ok(session)
    }
}

/// Copies a log beside itself, under a name that is not taken.
fn keep_copy(vfs: &dyn Vfs, logs: &Path) -> Result<PathBuf, FileError> {
    let copy = free_name(vfs, logs);
    let bytes = vfs.read(logs).map_err(|cause| io_error(logs, cause))?;
    vfs.replace(&copy, &bytes).map_err(|cause| io_error(&copy, cause))?;
    Ok(copy)
}

/// A name beside a log that is not taken: `name.edits.kept`, `name.edits.kept-2`, ….
fn free_name(vfs: &dyn Vfs, logs: &Path) -> PathBuf {
    (1..)
        .map(|n| {
            logs.with_extension(if n == 1 { "edits.kept".to_owned() } else { format!("edits.kept-{n}") })
        })
        .find(|path| !vfs.exists(path))
        .expect("some number is free")
}
