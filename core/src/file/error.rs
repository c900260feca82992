//! Errors of wavelet files and logs: one sentence that names the file, the place and the mend.

use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a file cannot be read or written.
#[derive(Debug, Error)]
pub enum FileError {
    /// The file system refused.
    #[error("{}: {cause}; {}", path.display(), mend_of(cause))]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        cause: std::io::Error,
    },
    /// The content is not what it should be.
    #[error("{}, {place}: {what}; {mend}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// Where: a byte or a line.
        place: String,
        /// What is wrong there.
        what: String,
        /// What would help.
        mend: &'static str,
    },
    /// Another program has the document open.
    #[error("{} is open in another Bozzetto; close it there first", path.display())]
    Locked {
        /// The wavelet file.
        path: PathBuf,
    },
    /// A log belongs to another wavelet file.
    #[error("{} belongs to another wavelet file ({of}, not {expected}); use its own file, or --rebind to apply it anyway", path.display())]
    ForeignLog {
        /// The log.
        path: PathBuf,
        /// The hash of the file it belongs to.
        of: String,
        /// The hash of the file at hand.
        expected: String,
    },
    /// A file with a log cannot be replaced by one that stands alone.
    #[error("{}: this log belongs to the file that would be replaced; choose another name", log.display())]
    HasLog {
        /// The log.
        log: PathBuf,
    },
}

/// What would help where the file system refused.
pub fn mend_of(cause: &std::io::Error) -> &'static str {
    use std::io::ErrorKind;
    match cause.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => {
            "make room on that disk, or choose another"
        }
        _ => "check the path and its permissions",
    }
}

impl FileError {
    /// For `map_err` on file operations.
    pub(crate) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |cause| FileError::Io { path: path.to_owned(), cause }
    }
}
