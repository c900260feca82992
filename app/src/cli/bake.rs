//! `bozzetto bake`: fold the log into a new wavelet file.

use super::input::{LogArgs, is_wavelet_file, load_model};
use anyhow::{Context, Result, bail};
use bozzetto_core::disk::{Disk, Vfs};
use bozzetto_core::file::{encode, log_path};
use std::path::PathBuf;

/// Fold a wavelet file and its log into one new wavelet file.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: bozzetto bake work.boz -o final.boz")]
pub(super) struct Args {
    /// The wavelet file.
    file: PathBuf,
    /// The wavelet file to write.
    #[arg(short, long)]
    output: PathBuf,
    #[command(flatten)]
    log: LogArgs,
}

/// Runs the command.
///
/// # Errors
/// The file cannot be read, is incomplete, or the result cannot be written.
pub(super) fn run(args: &Args) -> Result<()> {
    if !is_wavelet_file(&args.output) {
        bail!("{}: a wavelet file's name ends in .boz; rename the output", args.output.display());
    }
    if log_path(&args.output).exists() {
        let log = log_path(&args.output);
        bail!("{}: this log belongs to the file that would be replaced; choose another name", log.display());
    }
    let model = load_model(&args.file, args.log.options())?;
    if !model.complete {
        bail!("{} is incomplete and cannot be baked; get the rest of the file", args.file.display());
    }
    Disk.replace(&args.output, &encode(&model)).with_context(|| args.output.display().to_string())?;
    println!("hash {}", model.surface.hash());
    Ok(())
}
