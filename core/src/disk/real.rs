//! The real file system.

use super::{Appender, Lock, Vfs};
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

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

struct LockedFile {
    _held: File,
}

impl Lock for LockedFile {}

impl Vfs for Disk {
    fn read(&self, path: &Path) -> io::Result<Vec<u8>> {
        std::fs::read(path)
    }

    fn replace(&self, path: &Path, content: &[u8]) -> io::Result<()> {
        let folder = folder_of(path);
        let mut new = tempfile::Builder::new().prefix(".bozzetto-").tempfile_in(folder)?;
        new.write_all(content)?;
        #[cfg(unix)]
        {
            // Temporary files are private; a document is as readable as the one it replaces, or as usual.
            use std::os::unix::fs::PermissionsExt;
            let mode = std::fs::metadata(path).map_or(0o644, |old| old.permissions().mode());
            new.as_file().set_permissions(std::fs::Permissions::from_mode(mode))?;
        }
        new.as_file().sync_all()?;
        new.persist(path).map_err(|e| e.error)?;
        sync_folder(folder)
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
        let file = OpenOptions::new().create(true).truncate(false).write(true).open(path)?;
        match file.try_lock() {
            Ok(()) => Ok(Some(Box::new(LockedFile { _held: file }))),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(e)) => Err(e),
        }
    }

    fn exists(&self, path: &Path) -> bool {
        path.exists()
    }
}

fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Makes a renamed or new entry itself durable, where the system has a way to.
fn sync_folder(folder: &Path) -> io::Result<()> {
    if cfg!(unix) { File::open(folder)?.sync_all() } else { Ok(()) }
}
