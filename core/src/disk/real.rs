//! The real file system.

use super::{Appender, Lock, Vfs};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// The machine's own disk.
#[derive(Debug, Clone, Copy, Default)]
pub struct Disk;

struct AppendedFile(File);

impl Write for AppendedFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl Appender for AppendedFile {
    fn sync(&mut self) -> io::Result<()> {
        self.0.sync_data()
    }
}

/// A held lock. Its file goes when it does, where the system lets go of open files.
struct LockedFile {
    file: File,
    path: PathBuf,
}

impl Lock for LockedFile {}

impl Drop for LockedFile {
    fn drop(&mut self) {
        // Still locked here, so nobody else can hold the file that goes; see `is_at`.
        if cfg!(unix) && is_at(&self.file, &self.path) {
            // A lock file left behind is untidy, not wrong.
            let _ = std::fs::remove_file(&self.path);
        }
    }
}

/// Whether an open file is the one that a path names: not if the last holder of the lock took it away between opening
/// and locking.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let id = |data: &std::fs::Metadata| (data.dev(), data.ino());
    matches!((file.metadata(), std::fs::metadata(path)), (Ok(open), Ok(named)) if id(&open) == id(&named))
}

#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}

impl Vfs for Disk {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        std::fs::read(path)
    }

    fn replace(&self, path: &Path, content: &[u8]) -> io::Result<()> {
        // What a link leads to is replaced, not the link.
        let path = &path.canonicalize().unwrap_or_else(|_| path.to_owned());
        let folder = folder_of(path);
        let mut new = tempfile::Builder::new();
        new.prefix(".bozzetto-");
        #[cfg(unix)]
        {
            // Temporary files are private; a new document is as readable as other new files are.
            use std::os::unix::fs::PermissionsExt;
            new.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let mut new = new.tempfile_in(folder).map_err(nameless)?;
        new.as_file_mut().write_all(content)?;
        if let Ok(old) = std::fs::metadata(path) {
            new.as_file().set_permissions(old.permissions())?;
        }
        new.as_file().sync_all()?;
        new.persist(path).map_err(|e| e.error)?;
        sync_folder(folder)
    }

    fn remove(&self, path: &Path) -> io::Result<()> {
        std::fs::remove_file(path)?;
        sync_folder(folder_of(path))
    }

    fn append(&self, path: &Path, keep: u64) -> io::Result<Box<dyn Appender>> {
        let new = !path.exists();
        let mut file = OpenOptions::new().create(true).truncate(false).write(true).open(path)?;
        file.set_len(keep)?;
        file.seek(SeekFrom::End(0))?;
        if new {
            sync_folder(folder_of(path))?;
        }
        Ok(Box::new(AppendedFile(file)))
    }

    fn lock(&self, path: &Path) -> io::Result<Option<Box<dyn Lock>>> {
        loop {
            let file = OpenOptions::new().create(true).truncate(false).write(true).open(path)?;
            match file.try_lock() {
                Ok(()) if is_at(&file, path) => {
                    return Ok(Some(Box::new(LockedFile { file, path: path.to_owned() })));
                }
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => return Ok(None),
                Err(TryLockError::Error(e)) => return Err(e),
            }
        }
    }

    fn exists(&self, path: &Path) -> bool {
        path.exists()
    }
}

/// An error without the name of a temporary file, which says nothing to anybody.
fn nameless(error: io::Error) -> io::Error {
    if error.raw_os_error().is_some() { error } else { error.kind().into() }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Makes a renamed or new entry itself durable, where the system has a way to.
fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_keeps_others_out_and_leaves_nothing_behind() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("name.edits.lock");
        for _ in 0..2 {
            let held = Disk.lock(&path).expect("writable").expect("free");
            assert!(Disk.lock(&path).expect("writable").is_none(), "held");
            drop(held);
            assert!(!cfg!(unix) || !path.exists());
        }
    }
}
