//! `bozzetto compare`: the distance between two surfaces, both ways.

use super::input::{LogArgs, load_mesh};
use super::output;
use super::progress::Progress;
use anyhow::{Context, Result};
use bozzetto_core::mesh::{CompareOptions, compare};
use std::fmt::Write;
use std::path::PathBuf;

/// Measure the distance between two surfaces, exactly and both ways, over A's bounding-box diagonal.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: bozzetto compare scan.obj scan.boz")]
pub(super) struct Args {
    /// The reference: a .boz file or a mesh.
    a: PathBuf,
    /// The other: a .boz file or a mesh.
    b: PathBuf,
    /// Samples a side; the maximum also looks at every vertex.
    #[arg(long, default_value_t = CompareOptions::default().samples as u64, value_parser = clap::value_parser!(u64).range(1..=100_000_000))]
    samples: u64,
    /// Seed of the samples.
    #[arg(long, default_value_t = CompareOptions::default().seed)]
    seed: u64,
    #[command(flatten)]
    log: LogArgs,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// A file cannot be read or holds no surface.
pub(super) fn run(args: &Args) -> Result<()> {
    let a = load_mesh(&args.a, args.log.options())?;
    let b = load_mesh(&args.b, args.log.options())?;
    let progress = Progress::new("Comparing");
    let options = CompareOptions { samples: args.samples as usize, seed: args.seed };
    let result = compare(&a, &b, &options, &|share| progress.report(share))
        .with_context(|| format!("{} and {}", args.a.display(), args.b.display()))?;
    drop(progress);
    if args.json {
        return output::print_json(&result);
    }
    let mut text = format!("{:8}{:>12}{:>12}{:>12}   of the diagonal, ", "", "mean", "rms", "max");
    writeln!(text, "{:.6}", result.diagonal)?;
    for (name, way) in [("A → B", result.a_to_b), ("B → A", result.b_to_a)] {
        writeln!(text, "{name:<8}{:>12.3e}{:>12.3e}{:>12.3e}", way.mean, way.rms, way.max)?;
    }
    match result.psnr {
        Some(psnr) => {
            writeln!(text, "{:<20}{:>12.3e}{:>12.3e}   {psnr:.2} dB", "both", result.rms, result.max)?;
        }
        None => writeln!(text, "{:<8}the surfaces coincide", "both")?,
    }
    output::print(&text)
}
