//! The editor's window.

use anyhow::Result;
use std::path::PathBuf;

/// Opens the window on a file, or on the sample.
///
/// # Errors
/// There is no way to show a window.
pub fn run(_file: Option<PathBuf>) -> Result<()> {
    anyhow::bail!("no window yet")
}
