//! `bozzetto bake`: fold the log into a new wavelet file.

use super::input::{LogArgs, load_complete, tell};
use super::output;
use super::progress::Busy;
use anyhow::Result;
use bozzetto_core::file::encode;
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
    output::check_lone_wavelet_file(&args.output)?;
    let (model, notes) = load_complete(&args.file, args.log.options())?;
    tell(notes);
    let busy = Busy::new("Writing");
    output::replace(&args.output, &encode(&model))?;
    drop(busy);
    output::print(&format!("hash {}\n", model.surface.hash()))
}
