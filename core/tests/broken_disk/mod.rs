//! A disk that fails, or cheats, at any one operation.

use super::memory_disk::MemoryDisk;
use bozzetto_core::disk::{Appender, Lock, Vfs};
use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// What goes wrong at the chosen operation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Fault {
    /// It fails without effect; later ones succeed.
    Once,
    /// It and all later ones fail without effect.
    Dead,
    /// A write gets half way; it and all later operations fail.
    Torn,
    /// It has its effect, but reports failure.
    Late,
    /// Cheating: from here on synced lines are not on disk.
    LostSync,
    /// Cheating: from here on replaced files are not on disk.
    LostReplace,
    /// Cheating: a replacement gets half way and leaves a broken file; it and all later operations fail.
    BrokenReplace,
}

/// What is to fail and what has happened.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) fault: Fault,
    at: usize,
    pub(crate) operations: usize,
    /// Where it first failed.
    pub(crate) failed: Option<PathBuf>,
    /// By log: how many lines the program was told are on disk.
    acknowledged: BTreeMap<PathBuf, usize>,
}

/// How an operation is to go.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Course {
    Well,
    Fails,
    FailsHalfWay,
    FailsAfterwards,
    Cheats,
}

/// A disk that fails at one operation, counted from 0, and remembers what it told the program.
#[derive(Clone)]
pub(crate) struct FailingDisk {
    pub(crate) disk: MemoryDisk,
    pub(crate) plan: Arc<Mutex<Plan>>,
}

/// How many lines end in these bytes.
pub(crate) fn lines(bytes: &[u8]) -> usize {
    bytes.iter().filter(|b| **b == b'\n').count()
}

fn broken() -> io::Error {
    io::Error::other("the disk is broken")
}

impl FailingDisk {
    /// On top of a sound disk; `at` is the operation that fails.
    pub(crate) fn new(disk: &MemoryDisk, fault: Fault, at: usize) -> Self {
        let plan = Plan { fault, at, operations: 0, failed: None, acknowledged: BTreeMap::new() };
        Self { disk: disk.clone(), plan: Arc::new(Mutex::new(plan)) }
    }

    fn course(&self, path: &Path) -> Course {
        let mut plan = self.plan.lock().expect("no panic here");
        let this = plan.operations;
        plan.operations += 1;
        let course = match plan.fault {
            _ if this < plan.at => Course::Well,
            Fault::LostSync | Fault::LostReplace => Course::Cheats,
            Fault::Once | Fault::Late if this > plan.at => Course::Well,
            Fault::Late => Course::FailsAfterwards,
            Fault::Torn | Fault::BrokenReplace if this == plan.at => Course::FailsHalfWay,
            _ => Course::Fails,
        };
        if !matches!(course, Course::Well | Course::Cheats) {
            plan.failed.get_or_insert_with(|| path.to_owned());
        }
        course
    }

    fn fault(&self) -> Fault {
        self.plan.lock().expect("no panic here").fault
    }

    fn acknowledge(&self, path: &Path) {
        let known = lines(&self.disk.read(path).expect("just written"));
        self.plan.lock().expect("no panic here").acknowledged.insert(path.to_owned(), known);
    }

    /// How many lines of a log the program was told are on disk.
    pub(crate) fn acknowledged(&self, log: &str) -> usize {
        self.plan.lock().expect("no panic here").acknowledged.get(Path::new(log)).copied().unwrap_or(0)
    }

    /// Runs an operation that has no half way.
    fn whole<T>(&self, path: &Path, operation: impl FnOnce() -> io::Result<T>) -> io::Result<T> {
        match self.course(path) {
            Course::Well | Course::Cheats => operation(),
            Course::FailsAfterwards => operation().and(Err(broken())),
            Course::Fails | Course::FailsHalfWay => Err(broken()),
        }
    }
}

impl Vfs for FailingDisk {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        self.whole(path, || self.disk.read(path))
    }

    fn replace(&self, path: &Path, content: &[u8]) -> io::Result<()> {
        match (self.course(path), self.fault()) {
            (Course::Well, _) | (Course::Cheats, Fault::LostSync) => self.disk.replace(path, content)?,
            (Course::Cheats, _) => {
                let mut lost = self.disk.append(path, 0)?;
                lost.write_all(content)?;
            }
            (Course::FailsHalfWay, Fault::BrokenReplace) => {
                self.disk.replace(path, &content[..content.len() / 2])?;
                return Err(broken());
            }
            (Course::FailsAfterwards, _) => {
                self.disk.replace(path, content)?;
                return Err(broken());
            }
            (Course::Fails | Course::FailsHalfWay, _) => return Err(broken()),
        }
        self.acknowledge(path);
        Ok(())
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        self.whole(path, || self.disk.remove(path))
    }

    fn append(&self, path: &Path, keep: u64) -> io::Result<Box<dyn Appender>> {
        let file = self.whole(path, || self.disk.append(path, keep))?;
        Ok(Box::new(FailingAppender { on: self.clone(), path: path.to_owned(), file }))
    }

    fn lock(&self, path: &Path) -> io::Result<Option<Box<dyn Lock>>> {
        self.whole(path, || self.disk.lock(path))
    }

    fn exists(&self, path: &Path) -> bool {
        self.disk.exists(path)
    }
}

struct FailingAppender {
    on: FailingDisk,
    path: PathBuf,
    file: Box<dyn Appender>,
}

impl Write for FailingAppender {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.on.course(&self.path) {
            Course::Well | Course::Cheats => self.file.write(bytes),
            Course::Fails => Err(broken()),
            Course::FailsHalfWay => self.file.write(&bytes[..bytes.len() / 2]).and(Err(broken())),
            Course::FailsAfterwards => self.file.write(bytes).and(Err(broken())),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Appender for FailingAppender {
    fn sync(&mut self) -> io::Result<()> {
        match (self.on.course(&self.path), self.on.fault()) {
            (Course::Well, _) | (Course::Cheats, Fault::LostReplace) => self.file.sync()?,
            (Course::Cheats, _) => {}
            (Course::FailsAfterwards, _) => return self.file.sync().and(Err(broken())),
            _ => return Err(broken()),
        }
        self.on.acknowledge(&self.path);
        Ok(())
    }
}
