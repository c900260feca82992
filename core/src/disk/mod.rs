//! The file system as the rest of the crate sees it: whole reads, replacement in one step, synced appending, locks.
//!
//! Everything goes through [`Vfs`], so that tests can put a failing disk in its place.

mod real;
mod scratch;

pub use real::Disk;
pub use scratch::{Scratch, Stored};

use std::io::{self, Write};
use std::path::Path;

/// A file open for appending.
pub trait Appender: Write + Send {
    /// Returns when everything written so far has reached the disk.
    ///
    /// # Errors
    /// Whatever the file system says.
    fn sync(&mut self) -> io::Result<()>;
}

/// An exclusive lock, given back when dropped.
pub trait Lock: Send + Sync {}

/// The operations on files that Bozzetto needs.
pub trait Vfs: Send + Sync {
    /// The whole content of a file.
    ///
    /// # Errors
    /// Whatever the file system says.
    fn read(&self, path: &Path) -> io::Result<Vec<u8>>;

    /// Replaces a file in one step: after a crash there is the old content or the new, whole. Synced.
    ///
    /// # Errors
    /// Whatever the file system says; then there is still the old content or the new, whole.
    fn replace(&self, path: &Path, content: &[u8]) -> io::Result<()>;

    /// Takes a file away.
    ///
    /// # Errors
    /// Whatever the file system says.
    fn remove(&self, path: &Path) -> io::Result<()>;

    /// Opens a file for appending after its first `keep` bytes; creates it if it is missing. What lay beyond is cut.
    ///
    /// # Errors
    /// Whatever the file system says.
    fn append(&self, path: &Path, keep: u64) -> io::Result<Box<dyn Appender>>;

    /// Takes the exclusive lock that a file stands for; `None` if another holds it.
    ///
    /// # Errors
    /// Whatever the file system says.
    fn lock(&self, path: &Path) -> io::Result<Option<Box<dyn Lock>>>;

    /// Whether the file exists.
    fn exists(&self, path: &Path) -> bool;
}
