//! The `.edits` log beside a wavelet file: reading with all its possible damage, and appending.
//!
//! A committed line is written and synced by a thread of its own within milliseconds; the caller waits only where it
//! asks to. After a failed write nothing more is appended, so a tear stays at the end. A sidecar lock keeps a second
//! program out.

use super::FileError;
use crate::disk::{Lock, Vfs};
use crate::edit::{Entry, LONGEST_LINE, Line};
use crate::surface::SurfaceHash;
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread::JoinHandle;

/// The log's path beside a wavelet file: `name.boz` → `name.edits`.
pub fn log_path(wavelet_file: &Path) -> PathBuf {
    wavelet_file.with_extension("edits")
}

/// A line of a log with its number, counted from 1.
#[derive(Debug, Clone, PartialEq)]
pub struct NumberedLine {
    /// Its number in the file.
    pub number: usize,
    /// What it says.
    pub line: Line,
}

/// A log or script as read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Log {
    /// The wavelet file it is bound to, if it says so.
    pub of: Option<String>,
    /// The entries after the binding.
    pub lines: Vec<NumberedLine>,
    /// Bytes of the file that hold good lines; what follows is torn or damaged.
    pub good_bytes: u64,
    /// A torn last line was dropped.
    pub torn: bool,
    /// A bad line with more after it: its number and what is wrong.
    pub damage: Option<(usize, String)>,
}

/// Reads a log. With `journal`, it must begin with its binding and every line must carry its checksum; a bad last line
/// is torn. A bad line with more after it is damage, and reading stops there.
pub fn read_log(bytes: &[u8], journal: bool) -> Log {
    let mut log = Log::default();
    // Some editors begin a text with a byte order mark; a log never has one.
    let mut at = if !journal && bytes.starts_with("\u{feff}".as_bytes()) { 3 } else { 0 };
    let mut number = 0;
    while at < bytes.len() {
        number += 1;
        let end = bytes[at..].iter().position(|&b| b == b'\n').map(|n| at + n + 1);
        let (text, ended) = (&bytes[at..end.unwrap_or(bytes.len())], end.is_some());
        let next = end.unwrap_or(bytes.len());
        let parsed = parse(text).and_then(|line| match line {
            Some(line) if journal && !line.checked => Err("it has no checksum".to_owned()),
            other => Ok(other),
        });
        match parsed {
            // A journal's last line counts only with its line end: without it more may have been meant.
            Ok(_) if journal && !ended => {
                log.torn = true;
                return log;
            }
            Ok(None) => {}
            Ok(Some(Line { entry: Entry::Binding { of }, .. }))
                if log.of.is_none() && log.lines.is_empty() =>
            {
                log.of = Some(of);
            }
            Ok(Some(Line { entry: Entry::Binding { .. }, .. })) => {
                log.damage = Some((number, "a log begins only once".into()));
                return log;
            }
            Ok(Some(_)) if journal && log.of.is_none() => {
                log.damage = Some((number, "the log does not begin with the file it belongs to".into()));
                return log;
            }
            Ok(Some(line)) => log.lines.push(NumberedLine { number, line }),
            Err(_) if journal && bytes[next..].iter().all(u8::is_ascii_whitespace) => {
                log.torn = true;
                return log;
            }
            Err(what) => {
                log.damage = Some((number, what));
                return log;
            }
        }
        at = next;
        log.good_bytes = at as u64;
    }
    log
}

/// A line, or `None` for a blank one or a `#` comment.
fn parse(text: &[u8]) -> Result<Option<Line>, String> {
    if text.len() > LONGEST_LINE {
        return Err("it is too long".into());
    }
    let text = std::str::from_utf8(text).map_err(|_| "it is not text".to_owned())?.trim();
    if text.is_empty() || text.starts_with('#') {
        return Ok(None);
    }
    Line::parse(text).map(Some).map_err(|e| e.to_string())
}

/// The journal of an open document. Dropping it waits until everything is on disk.
pub struct Journal {
    lines: Option<Sender<Message>>,
    writer: Option<JoinHandle<()>>,
    failure: Arc<Mutex<Option<String>>>,
    _lock: Box<dyn Lock>,
}

/// What the writing thread is told.
struct Message {
    text: String,
    /// Dropped once the text is on disk, or never will be.
    _waiting: Option<Sender<()>>,
}

impl std::fmt::Debug for Journal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Journal").field("failure", &self.failure).finish_non_exhaustive()
    }
}

/// Takes the sidecar lock of a wavelet file.
///
/// # Errors
/// Another program holds it, or the folder cannot be written.
pub fn lock(vfs: &dyn Vfs, wavelet_file: &Path) -> Result<Box<dyn Lock>, FileError> {
    let path = wavelet_file.with_extension("edits.lock");
    vfs.lock(&path)
        .map_err(FileError::io(&path))?
        .ok_or_else(|| FileError::Locked { path: wavelet_file.to_owned() })
}

/// Replaces the log of a wavelet file in one step by one with these lines after its binding; returns its length in
/// bytes.
///
/// # Errors
/// The log cannot be written; then the old one or the new is there, whole.
pub fn write_log(
    vfs: &dyn Vfs,
    wavelet_file: &Path,
    of: SurfaceHash,
    lines: &[u8],
) -> Result<u64, FileError> {
    let path = log_path(wavelet_file);
    let mut text = Line::to_text(&Entry::Binding { of: of.to_string() }, None).into_bytes();
    text.push(b'\n');
    text.extend_from_slice(lines);
    vfs.replace(&path, &text).map_err(FileError::io(&path))?;
    Ok(text.len() as u64)
}

impl Journal {
    /// Goes on after the first `keep` bytes of a log that is there.
    ///
    /// # Errors
    /// The log cannot be written.
    pub fn open(
        vfs: &dyn Vfs,
        wavelet_file: &Path,
        keep: u64,
        lock: Box<dyn Lock>,
    ) -> Result<Self, FileError> {
        let path = log_path(wavelet_file);
        let mut file = vfs.append(&path, keep).map_err(FileError::io(&path))?;
        let (lines, received) = channel::<Message>();
        let failure = Arc::new(Mutex::new(None));
        let shared = failure.clone();
        let writer = std::thread::Builder::new()
            .name("journal".into())
            .spawn(move || {
                while let Ok(first) = received.recv() {
                    // Whatever else is waiting goes in the same sync.
                    let batch: Vec<Message> = std::iter::once(first).chain(received.try_iter()).collect();
                    let text: String = batch.iter().map(|message| message.text.as_str()).collect();
                    if text.is_empty() {
                        continue;
                    }
                    if let Err(e) = file.write_all(text.as_bytes()).and_then(|()| file.sync()) {
                        let mut failure = shared.lock().expect("the lock is held for assignments only");
                        *failure = Some(format!("{}: {e}", path.display()));
                        return;
                    }
                }
            })
            .map_err(FileError::io(&log_path(wavelet_file)))?;
        Ok(Self { lines: Some(lines), writer: Some(writer), failure, _lock: lock })
    }

    /// Hands a line to the writer. Returns at once.
    pub fn commit(&self, entry: &Entry, hash: Option<SurfaceHash>) {
        let mut text = Line::to_text(entry, hash);
        text.push('\n');
        self.send(Message { text, _waiting: None });
    }

    /// Waits until every line committed so far is on disk, or why it is not.
    pub fn flush(&self) -> Option<String> {
        let (waiting, done) = channel();
        self.send(Message { text: String::new(), _waiting: Some(waiting) });
        // Nothing is ever sent: the other end is dropped when all is written or the writer has given up.
        let _ = done.recv();
        self.failure()
    }

    fn send(&self, message: Message) {
        if let Some(lines) = &self.lines {
            // A writer that has failed has said why; see `failure`.
            let _ = lines.send(message);
        }
    }

    /// Why lines no longer reach the disk, if they do not.
    pub fn failure(&self) -> Option<String> {
        self.failure.lock().expect("the lock is held for assignments only").clone()
    }

    /// Waits until every line is on disk.
    pub fn finish(mut self) -> Option<String> {
        self.drain();
        self.failure()
    }

    fn drain(&mut self) {
        drop(self.lines.take());
        if let Some(writer) = self.writer.take() {
            let _ = writer.join();
        }
    }
}

impl Drop for Journal {
    fn drop(&mut self) {
        self.drain();
    }
}
