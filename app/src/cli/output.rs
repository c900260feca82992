//! Outputs of commands: files, refused before any work if they cannot be, and what is printed.

use anyhow::{Context, Result, anyhow, bail};
use bozzetto_core::disk::{Disk, Vfs};
use bozzetto_core::file::{is_wavelet_file, log_path, mend_of};
use std::io::{ErrorKind, Write};
use std::path::Path;

/// Refuses an output that is not a regular file or whose folder does not exist.
///
/// # Errors
/// Why nothing can be written there.
pub(super) fn check(path: &Path) -> Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        bail!("{}: there is no folder {} to write it to; make it first", path.display(), folder.display());
    }
    if path.exists() && !path.is_file() {
        bail!("{}: this is not a regular file and cannot be replaced; choose another name", path.display());
    }
    Ok(())
}

/// Refuses an output as [`check`] does, and one whose name does not end in `.boz`.
///
/// # Errors
/// Why no wavelet file can be written there.
pub(super) fn check_wavelet_file(path: &Path) -> Result<()> {
    if !is_wavelet_file(path) {
        bail!("{}: a wavelet file's name ends in .boz; rename the output", path.display());
    }
    check(path)
}

/// Refuses an output as [`check_wavelet_file`] does, and one beside which lies a log: it would be taken for the new
/// file's.
///
/// # Errors
/// Why no wavelet file without a log can be written there.
pub(super) fn check_lone_wavelet_file(path: &Path) -> Result<()> {
    check_wavelet_file(path)?;
    let log = log_path(path);
    if log.exists() {
        bail!("{}: this log belongs to the file that would be replaced; choose another name", log.display());
    }
    Ok(())
}

/// Refuses an output that is the input, of which less would be left.
///
/// # Errors
/// They are the same file.
pub(super) fn check_apart(output: &Path, input: &Path) -> Result<()> {
    match (output.canonicalize(), input.canonicalize()) {
        (Ok(a), Ok(b)) if a == b => {
            bail!("{}: this is the file to be exported; choose another name", output.display())
        }
        _ => Ok(()),
    }
}

/// Replaces a file in one step.
///
/// # Errors
/// What the file system says.
pub(super) fn replace(path: &Path, bytes: &[u8]) -> Result<()> {
    Disk.replace(path, bytes).map_err(|cause| anyhow!("{}: {cause}; {}", path.display(), mend_of(&cause)))
}

/// Prints a result on stdout. A reader that has seen enough and hung up is no failure.
///
/// # Errors
/// Stdout cannot be written to.
pub(super) fn print(text: &str) -> Result<()> {
    let mut stdout = std::io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            Err(error).context("stdout cannot be written to; check where it leads")
        }
        _ => Ok(()),
    }
}

/// Prints one JSON object and a line end on stdout.
///
/// # Errors
/// Stdout cannot be written to.
pub(super) fn print_json(value: &impl serde::Serialize) -> Result<()> {
    print(&(serde_json::to_string(value)? + "\n"))
}
