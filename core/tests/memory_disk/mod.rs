//! A disk in memory that knows what a power cut would leave: what was synced stays, the rest may be lost.

#![allow(dead_code, reason = "every test program uses its own part of this")]

use bozzetto_core::disk::{Appender, Lock, Vfs};
use bozzetto_core::file::{Metadata, Model};
use bozzetto_core::session::Session;
use bozzetto_core::surface::Surface;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};

#[derive(Debug, Clone, Default, PartialEq)]
struct Content {
    /// What programs see.
    cached: Vec<u8>,
    /// What a power cut leaves.
    durable: Vec<u8>,
}

#[derive(Debug, Default)]
struct State {
    files: BTreeMap<PathBuf, Content>,
    locked: BTreeSet<PathBuf>,
}

/// The disk. Clones are the same disk.
#[derive(Debug, Clone, Default)]
pub(crate) struct MemoryDisk(Arc<Mutex<State>>);

impl MemoryDisk {
    fn state(&self) -> MutexGuard<'_, State> {
        self.0.lock().expect("no test panics while it holds the disk")
    }

    /// Puts a file there, synced.
    pub(crate) fn put(&self, path: &str, bytes: &[u8]) {
        let content = Content { cached: bytes.to_vec(), durable: bytes.to_vec() };
        self.state().files.insert(path.into(), content);
    }

    /// The content of a file that must be there.
    pub(crate) fn bytes(&self, path: &str) -> Vec<u8> {
        self.read(Path::new(path)).unwrap_or_else(|_| panic!("{path} is not there"))
    }

    /// The names of all files.
    pub(crate) fn names(&self) -> Vec<String> {
        self.state().files.keys().map(|path| path.display().to_string()).collect()
    }

    /// The disk after a power cut: of what was appended and not synced the first `share` remains. No lock survives.
    pub(crate) fn after_power_cut(&self, share: f64) -> MemoryDisk {
        let mut files = self.state().files.clone();
        for content in files.values_mut() {
            let mut left = content.durable.clone();
            if let Some(tail) = content.cached.strip_prefix(content.durable.as_slice()) {
                left.extend(&tail[..(tail.len() as f64 * share) as usize]);
            }
            *content = Content { cached: left.clone(), durable: left };
        }
        MemoryDisk(Arc::new(Mutex::new(State { files, locked: BTreeSet::new() })))
    }

    fn change<T>(&self, path: &Path, change: impl FnOnce(&mut Content) -> T) -> T {
        change(self.state().files.entry(path.to_owned()).or_default())
    }
}

struct Appending {
    disk: MemoryDisk,
    path: PathBuf,
}

impl Write for Appending {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.disk.change(&self.path, |content| content.cached.extend(bytes));
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Appender for Appending {
    fn sync(&mut self) -> io::Result<()> {
        self.disk.change(&self.path, |content| content.durable = content.cached.clone());
        Ok(())
    }
}

struct Held {
    disk: MemoryDisk,
    path: PathBuf,
}

impl Lock for Held {}

impl Drop for Held {
    fn drop(&mut self) {
        self.disk.state().locked.remove(&self.path);
    }
}

impl Vfs for MemoryDisk {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        let state = self.state();
        let content = state.files.get(path).ok_or_else(|| io::Error::from(io::ErrorKind::NotFound))?;
        Ok(content.cached.clone())
    }

    fn replace(&self, path: &Path, content: &[u8]) -> io::Result<()> {
        let bytes = content.to_vec();
        self.change(path, |content| *content = Content { cached: bytes.clone(), durable: bytes });
        Ok(())
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        let gone = self.state().files.remove(path);
        gone.map(|_| ()).ok_or_else(|| io::ErrorKind::NotFound.into())
    }

    fn append(&self, path: &Path, keep: u64) -> io::Result<Box<dyn Appender>> {
        // As with a real file, the cut itself is durable only with the next sync.
        self.change(path, |content| content.cached.resize(keep as usize, 0));
        Ok(Box::new(Appending { disk: self.clone(), path: path.to_owned() }))
    }

    fn lock(&self, path: &Path) -> io::Result<Option<Box<dyn Lock>>> {
        if !self.state().locked.insert(path.to_owned()) {
            return Ok(None);
        }
        self.change(path, |_| ());
        Ok(Some(Box::new(Held { disk: self.clone(), path: path.to_owned() })))
    }

    fn exists(&self, path: &Path) -> bool {
        self.state().files.contains_key(path)
    }
}

/// A session over a surface, on a disk of its own.
pub(crate) fn session_of(surface: Surface) -> Session {
    Session::new(Arc::new(MemoryDisk::default()), Model::new(surface, None, Metadata::default()))
}
