//! `bozzetto verify`: check every block of a file and synthesise it anew.

use super::input::{LogArgs, load_complete, load_mesh, tell};
use super::output;
use super::progress::Progress;
use anyhow::{Context, Result, bail};
use bozzetto_core::file::is_wavelet_file;
use bozzetto_core::mesh::{CompareOptions, compare};
use bozzetto_core::surface::Surface;
use std::fmt::Write;
use std::path::PathBuf;

/// Check a wavelet file: every checksum, the hash, its log, and that analysis inverts synthesis.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: bozzetto verify assets/head.boz")]
pub(super) struct Args {
    /// The wavelet file.
    file: PathBuf,
    /// Also measure the distance to this mesh.
    #[arg(long, value_name = "MESH")]
    against: Option<PathBuf>,
    #[command(flatten)]
    log: LogArgs,
}

/// Runs the command.
///
/// # Errors
/// Something does not hold.
pub(super) fn run(args: &Args) -> Result<()> {
    let path = args.file.display();
    if !is_wavelet_file(&args.file) {
        bail!("{path}: only wavelet files can be verified; give a .boz file");
    }
    let progress = Progress::new("Verifying");
    let (model, notes) = load_complete(&args.file, args.log.options())?;
    if model.tail_cut {
        bail!("{path}: the surface is whole, but the file was cut short after it; restore it from a copy");
    }
    tell(notes);
    progress.report(0.4);
    let surface = &model.surface;
    let finest = surface.scaling(surface.finest()).to_vec();
    let hierarchy = surface.hierarchy().as_ref().clone();
    let analysed = Surface::from_finest(hierarchy, surface.form().clone(), finest)?;
    if analysed.hash() != surface.hash() {
        bail!(
            "{path}: analysis of the synthesised surface gives other coefficients; report this as a defect"
        );
    }
    let mut text = format!(
        "blocks       every checksum agrees\n\
         hash         {}\n\
         round trip   analysis of the synthesis gives the same coefficients, bit for bit\n",
        surface.hash()
    );
    if let Some(mesh_path) = &args.against {
        let mesh = load_mesh(mesh_path, args.log.options())?;
        let ours = surface.to_mesh(surface.finest());
        let result =
            compare(&mesh, &ours, &CompareOptions::default(), &|share| progress.report(0.6 + 0.4 * share))
                .with_context(|| mesh_path.display().to_string())?;
        writeln!(text, "distance     rms {:.3e}, max {:.3e} of the diagonal", result.rms, result.max)?;
    }
    drop(progress);
    output::print(&text)
}
