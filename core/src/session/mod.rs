//! The one door through which a surface changes: edits, strokes, undo, the journal, saving.
//!
//! Command line and editor use the same session; what one can do, the other can. Guarantees: a committed edit is
//! handed to the journal before the call returns and is on disk within milliseconds; a refused edit changes
//! nothing; a replay of the log gives the same bits. Not guaranteed: that a failing disk is noticed before
//! [`Session::journal_failure`] is asked.

mod attic;
mod brush;
mod equalise;
mod glimpse;
mod open;
mod replay;
mod stroke;

pub use attic::HISTORY_BUDGET;
pub use open::{LogUse, OpenOptions, Opened, open_model};
pub use replay::{ReplayError, ReplayReason, effective};

use crate::disk::Vfs;
use crate::edit::{BrushStroke, Edit, EditError, Entry, Equaliser, Glimpse, Line, Step};
use crate::file::{
    FileError, Journal, Metadata, Model, NumberedLine, SourceIndices, decode, encode, is_wavelet_file, lock,
    log_path, write_log,
};
use crate::surface::{Changes, Surface, SurfaceHash};
use attic::{Attic, LogText};
use replay::Record;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stroke::Stroke;
use thiserror::Error;

/// Every how many edits a log line carries the surface hash.
pub const HASH_EVERY: u64 = 32;

/// Why a session cannot do something.
#[derive(Debug, Error)]
pub enum SessionError {
    /// The edit is refused.
    #[error("{0}")]
    Edit(#[from] EditError),
    /// A file cannot be read or written.
    #[error("{0}")]
    File(#[from] FileError),
    /// A log or script cannot be replayed.
    #[error("{}, {error}; correct or remove that line", path.display())]
    Replay {
        /// The log or script.
        path: PathBuf,
        /// Where and why.
        error: ReplayError,
    },
    /// A partial file cannot be edited.
    #[error("{} is incomplete, and only a complete wavelet file can be edited; get the rest of the file", path.display())]
    Partial {
        /// The wavelet file.
        path: PathBuf,
    },
    /// The edits of a log cannot be applied to a partial file.
    #[error(
        "{} is incomplete, and the log beside it needs all of it; get the rest of the file, or take it without the log (--base)",
        path.display()
    )]
    PartialWithLog {
        /// The wavelet file.
        path: PathBuf,
    },
    /// The log does not reach the disk any more.
    #[error("{0}; make room or check the disk, and save the surface under another name")]
    Journal(String),
    /// There is no file to save to yet.
    #[error("this surface has no file yet; choose where to save it")]
    NoFile,
}

/// An open surface with its history.
#[derive(Debug)]
pub struct Session {
    vfs: Shared,
    model: Model,
    /// The wavelet file's bytes for a surface that has no file yet.
    unsaved: Option<Arc<Vec<u8>>>,
    path: Option<PathBuf>,
    original: SurfaceHash,
    record: Record,
    attic: Attic,
    log: LogText,
    saved_at: usize,
    edits: u64,
    journal: Option<Journal>,
    stroke: Option<Stroke>,
    brush: Option<BrushStroke>,
    equaliser: Option<Equaliser>,
    /// A step shown on coarse levels before it is made.
    glimpse: Option<Glimpse>,
    /// The model's source indices, which hold as long as the levels are those of the file.
    source: Option<Arc<SourceIndices>>,
    history_failure: Option<String>,
}

/// A file system, shared; only there so that sessions can be debugged.
#[derive(Clone)]
struct Shared(Arc<dyn Vfs>);

impl std::fmt::Debug for Shared {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Vfs")
    }
}

impl Session {
    /// A session on a model that has no file yet.
    pub fn new(vfs: Arc<dyn Vfs>, model: Model) -> Self {
        let original = model.surface.hash();
        let unsaved = Some(Arc::new(encode(&model)));
        let source = model.source.clone();
        Self {
            vfs: Shared(vfs),
            model,
            unsaved,
            path: None,
            original,
            record: Record::new(),
            attic: Attic::default(),
            log: LogText::default(),
            saved_at: 0,
            edits: 0,
            journal: None,
            stroke: None,
            brush: None,
            equaliser: None,
            glimpse: None,
            source,
            history_failure: None,
        }
    }

    /// The surface. Only the session changes it.
    pub fn surface(&self) -> &Surface {
        &self.model.surface
    }

    /// The surface with what the file says beside it.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Where the surface came from.
    pub fn metadata(&self) -> &Metadata {
        &self.model.metadata
    }

    /// The wavelet file, if there is one.
    pub fn path(&self) -> Option<&Path> {
        self.path.as_deref()
    }

    /// The surface hash.
    pub fn hash(&self) -> SurfaceHash {
        self.model.surface.hash()
    }

    /// The hash of the wavelet file without its log, to which logs are bound.
    pub fn original_hash(&self) -> SurfaceHash {
        self.original
    }

    /// Makes an edit: one line, one undo step. Ends a stroke under way first.
    ///
    /// # Errors
    /// The edit is refused; nothing has changed.
    pub fn edit(&mut self, edit: Edit) -> Result<Changes, SessionError> {
        self.end_stroke();
        let changes = replay::perform(&mut self.model.surface, &mut self.record, edit.clone())?;
        self.settle_history();
        self.committed_edit(edit);
        Ok(changes)
    }

    /// Undoes the last step, if there is one. Ends a stroke under way first.
    pub fn undo(&mut self) -> Option<Changes> {
        self.end_stroke();
        self.call_back(self.record.head().checked_sub(1)?)?;
        let changes = self.record.undo(&mut self.model.surface)?;
        self.source_fits();
        self.commit(Entry::Undo(1), None);
        Some(changes)
    }

    /// Redoes the last undone step, if there is one. Ends a stroke under way first.
    pub fn redo(&mut self) -> Option<Changes> {
        self.end_stroke();
        self.call_back(self.record.head())?;
        let changes = self.record.redo(&mut self.model.surface)?;
        self.source_fits();
        self.commit(Entry::Redo(1), None);
        Some(changes)
    }

    /// About how many vertices of the finest level the next undo moves; none if there is nothing to undo. For choosing whether
    /// a window can wait for it.
    pub fn undo_moves(&self) -> Option<u64> {
        self.moves_of(self.record.head().checked_sub(1)?)
    }

    /// [`Session::undo_moves`] of the next redo.
    pub fn redo_moves(&self) -> Option<u64> {
        self.moves_of(self.record.head())
    }

    fn moves_of(&self, at: usize) -> Option<u64> {
        self.record.entries().nth(at).map(|entry| entry.as_ref().moves(&self.model.surface))
    }

    /// Undoes or redoes until so many steps are in effect.
    pub fn go_to(&mut self, steps: usize) -> Option<Changes> {
        let mut joined: Option<Changes> = None;
        while self.record.head() != steps {
            let changes = if self.record.head() > steps { self.undo() } else { self.redo() };
            let Some(changes) = changes else { break };
            match &mut joined {
                Some(all) => all.join(changes),
                None => joined = Some(changes),
            }
        }
        joined
    }

    /// Plays the lines of a script as if they were made here: each is logged and can be undone.
    ///
    /// # Errors
    /// The first line that cannot be replayed; everything before it stands.
    pub fn play(
        &mut self,
        lines: &[NumberedLine],
        progress: &dyn Fn(f32) -> bool,
    ) -> Result<u64, ReplayError> {
        self.end_stroke();
        let mut edits = 0;
        for (at, NumberedLine { number, line }) in lines.iter().enumerate() {
            let stop = |reason| ReplayError { line: *number, reason };
            if !progress(at as f32 / lines.len() as f32) {
                return Err(stop(ReplayReason::Cancelled));
            }
            let history = (&mut self.record, &mut self.attic);
            replay::replay_entry(&mut self.model.surface, history, &line.entry).map_err(stop)?;
            self.source_fits();
            match &line.entry {
                Entry::Edit(edit) => {
                    edits += 1;
                    self.committed_edit(edit.clone());
                }
                Entry::Undo(_) | Entry::Redo(_) => self.commit(line.entry.clone(), None),
                Entry::Save | Entry::Discard | Entry::Binding { .. } => {}
            }
            if let Some(stated) = line.hash
                && stated != self.hash()
            {
                return Err(stop(ReplayReason::Hash { stated, found: self.hash() }));
            }
        }
        Ok(edits)
    }

    /// The steps made so far in a few words each, oldest first, undone ones included.
    pub fn titles(&self) -> impl Iterator<Item = &str> {
        self.record.entries().map(|entry| entry.as_ref().title())
    }

    /// The edits of these steps. Cost: reading them all.
    pub fn history(&self) -> impl Iterator<Item = Edit> {
        self.record.entries().filter_map(|entry| entry.as_ref().edit().ok())
    }

    /// Chooses how many bytes of undo history stay in memory; older steps go to a scratch file.
    pub fn set_history_budget(&mut self, bytes: usize) {
        self.attic.set_budget(bytes);
    }

    /// How many bytes of undo history and log are in memory.
    pub fn history_in_memory(&self) -> usize {
        self.attic.in_memory() + self.log.in_memory()
    }

    /// Why steps cannot be undone or redone, if they cannot be read any more.
    pub fn history_failure(&self) -> Option<&str> {
        self.history_failure.as_deref()
    }

    /// Brings a step back into memory before it is undone or redone; none if that fails.
    fn call_back(&mut self, at: usize) -> Option<()> {
        let packed = self.record.entries().nth(at)?.as_ref().packed();
        if let Err(error) = self.attic.call_back(packed) {
            self.history_failure = Some(format!("The history cannot be read any more: {error}"));
            return None;
        }
        Some(())
    }

    /// Makes a step that is in the surface part of history and log.
    fn record_step(&mut self, step: Step) {
        let edit = step.edit().expect("it is in memory");
        self.record.edit(&mut self.model.surface, step);
        self.settle_history();
        self.committed_edit(edit);
    }

    /// After a new step: it counts, and older ones make room.
    fn settle_history(&mut self) {
        if let Some(entry) = self.record.head().checked_sub(1).and_then(|at| self.record.entries().nth(at)) {
            self.attic.keep(entry.as_ref().packed());
        }
        self.source_fits();
    }

    /// Source indices name vertices by id and hold only while the levels are the file's.
    fn source_fits(&mut self) {
        let steps = self.record.entries().take(self.record.head());
        let reshaped = self.source.is_some() && steps.into_iter().any(|entry| entry.as_ref().reshapes());
        self.model.source = if reshaped { None } else { self.source.clone() };
    }

    /// How many steps of the history are in effect.
    pub fn steps(&self) -> usize {
        self.record.head()
    }

    /// How many steps there are, undone ones included.
    pub fn history_len(&self) -> usize {
        self.record.len()
    }

    /// Whether something happened since the last save mark.
    pub fn is_unsaved(&self) -> bool {
        self.path.is_none() || self.log.len() > self.saved_at || self.in_stroke()
    }

    /// Why edits no longer reach the disk, if they do not.
    pub fn journal_failure(&self) -> Option<String> {
        self.journal.as_ref().and_then(Journal::failure)
    }

    /// Adds a save mark to the log and waits until it is on disk with everything before it.
    ///
    /// # Errors
    /// The surface has no file yet, or the log cannot be written.
    pub fn save(&mut self) -> Result<(), SessionError> {
        if self.path.is_none() {
            return Err(SessionError::NoFile);
        }
        self.end_stroke();
        let hash = self.hash();
        if let Some(failure) = self.journal_failure() {
            return Err(SessionError::Journal(failure));
        }
        self.commit(Entry::Save, Some(hash));
        if let Some(failure) = self.journal.as_ref().and_then(Journal::flush) {
            return Err(SessionError::Journal(failure));
        }
        self.saved_at = self.log.len();
        Ok(())
    }

    /// Saves wavelet file and log under another name and goes on there.
    ///
    /// # Errors
    /// The files cannot be written or are open elsewhere; the session then stays where it was.
    pub fn save_as(&mut self, path: &Path) -> Result<(), SessionError> {
        self.end_stroke();
        let path = with_extension(path);
        if self.path.as_deref() == Some(path.as_path()) {
            return self.save();
        }
        let bytes = match (&self.unsaved, &self.path) {
            (Some(bytes), _) => bytes.clone(),
            (None, Some(old)) => Arc::new(self.vfs.0.read(old).map_err(|cause| io_error(old, cause))?),
            (None, None) => return Err(SessionError::NoFile),
        };
        let mut log = self.log.text().map_err(|cause| io_error(&log_path(&path), cause))?;
        let hash = Some(self.hash());
        log.extend_from_slice(Line::to_text(&Entry::Save, hash).as_bytes());
        log.push(b'\n');
        let journal = self.write_pair(&path, &bytes, &log)?;
        self.log.push(&Entry::Save, hash);
        self.saved_at = self.log.len();
        self.journal = Some(journal);
        self.path = Some(path);
        self.unsaved = None;
        Ok(())
    }

    /// Writes a wavelet file and its log so that what is there meanwhile, or after a failure, never takes one
    /// document's log for another's: a new file appears after its log, and a file that is replaced comes back with its
    /// log if not all can be written. Returns the journal that goes on there.
    fn write_pair(&self, path: &Path, bytes: &[u8], log: &[u8]) -> Result<Journal, FileError> {
        let vfs = &*self.vfs.0;
        let lock = lock(vfs, path)?;
        let write = |bytes: &[u8]| vfs.replace(path, bytes).map_err(|cause| io_error(path, cause));
        if !vfs.exists(path) {
            let length = write_log(vfs, path, self.original, log)?;
            write(bytes).inspect_err(|_| {
                // A log without its file would be taken for that of the next file of this name.
                if !vfs.exists(path) {
                    let _ = vfs.remove(&log_path(path));
                }
            })?;
            return Journal::open(vfs, path, length, lock);
        }
        let old = vfs.read(path).map_err(|cause| io_error(path, cause))?;
        let logs = log_path(path);
        let old_log = match vfs.exists(&logs) {
            true => vfs.read(&logs).map_err(|cause| io_error(&logs, cause))?,
            false => Vec::new(),
        };
        let written = write(bytes).and_then(|()| write_log(vfs, path, self.original, log));
        written.and_then(|length| Journal::open(vfs, path, length, lock)).inspect_err(|_| {
            // Should this fail too, opening refuses the pair, with both files whole.
            let _ = write(&old);
            let _ = vfs.replace(&logs, &old_log);
        })
    }

    /// Writes one baked file: the surface as it is now, without history.
    ///
    /// # Errors
    /// The file cannot be written, or one with a log of its own is there.
    pub fn save_copy(&self, path: &Path) -> Result<(), SessionError> {
        let log = log_path(path);
        if self.vfs.0.exists(&log) {
            return Err(FileError::HasLog { log }.into());
        }
        self.vfs.0.replace(path, &encode(&self.model)).map_err(|cause| io_error(path, cause))?;
        Ok(())
    }

    /// Ends the session with a copy, as [`Session::save_copy`] writes it, and lets go first of what that does not need.
    ///
    /// # Errors
    /// The copy cannot be written, or a file with a log of its own is there, or the session's own log is not on disk.
    pub fn into_copy(mut self, path: &Path) -> Result<(), SessionError> {
        self.end_stroke();
        self.unsaved = None;
        self.save_copy(path)?;
        self.close().map_err(SessionError::Journal)
    }

    /// Takes back everything since the last save mark, for good, and closes. The log keeps it all.
    ///
    /// # Errors
    /// Why the log is not on disk; opening then finds the edits still there.
    pub fn discard(mut self) -> Result<(), String> {
        self.cancel_stroke();
        if self.log.len() > self.saved_at {
            self.commit(Entry::Discard, None);
        }
        self.close()
    }

    /// Waits until the log is on disk and closes.
    ///
    /// # Errors
    /// Why the log is not on disk.
    pub fn close(mut self) -> Result<(), String> {
        self.end_stroke();
        match self.journal.take().and_then(Journal::finish) {
            Some(failure) => Err(failure),
            None => Ok(()),
        }
    }

    fn committed_edit(&mut self, edit: Edit) {
        self.edits += 1;
        let hash = self.edits.is_multiple_of(HASH_EVERY).then(|| self.hash());
        self.commit(Entry::Edit(edit), hash);
    }

    fn commit(&mut self, entry: Entry, hash: Option<SurfaceHash>) {
        if let Some(journal) = &self.journal {
            journal.commit(&entry, hash);
        }
        self.log.push(&entry, hash);
    }
}

fn io_error(path: &Path, cause: std::io::Error) -> FileError {
    FileError::Io { path: path.to_owned(), cause }
}

/// The path with the extension `.boz`, added where it is missing.
fn with_extension(path: &Path) -> PathBuf {
    if is_wavelet_file(path) {
        path.to_owned()
    } else {
        let mut name = path.as_os_str().to_owned();
        name.push(".boz");
        PathBuf::from(name)
    }
}
