//! `bozzetto import`: a mesh to a wavelet file.

use super::form::FormArgs;
use super::info::Info;
use super::output;
use super::progress::Progress;
use crate::opening::{ImportOptions, Imported, import_file};
use anyhow::{Result, bail};
use bozzetto_core::conversion::{ConversionOptions, Remesh};
use bozzetto_core::file::encode;
use clap::ValueEnum;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Turn a mesh into a wavelet file.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: bozzetto import scan.obj -o scan.boz --wavelet 2")]
pub(super) struct Args {
    /// The mesh: .obj, .ply, .stl, .glb or .off.
    mesh: PathBuf,
    /// The wavelet file to write.
    #[arg(short, long)]
    output: PathBuf,
    /// At most so many levels, or so many when the mesh is converted.
    #[arg(long, value_name = "J", value_parser = clap::value_parser!(u8).range(0..=15))]
    levels: Option<u8>,
    /// Whether to convert: auto looks for subdivision connectivity first and repairs and converts any other mesh; always
    /// repairs and converts in any case; never takes the mesh as it is.
    #[arg(long, default_value = "auto")]
    remesh: RemeshArg,
    #[command(flatten)]
    form: FormArgs,
    /// Bound on the measured distance, over the bounding-box diagonal; the result says whether it is met.
    #[arg(long, value_name = "T")]
    tolerance: Option<f64>,
    /// Upper limit of base faces; chosen from the mesh if left out.
    #[arg(long, value_name = "N")]
    base_faces: Option<usize>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum RemeshArg {
    Auto,
    Always,
    Never,
}

impl Args {
    fn options(&self) -> Result<ImportOptions> {
        let remesh = match self.remesh {
            RemeshArg::Auto => Remesh::Auto,
            RemeshArg::Always => Remesh::Always,
            RemeshArg::Never => Remesh::Never,
        };
        Ok(ImportOptions {
            conversion: ConversionOptions {
                levels: self.levels,
                remesh,
                base_faces: self.base_faces,
                tolerance: self.tolerance,
            },
            form: self.form.options()?,
        })
    }
}

#[derive(Debug, Serialize)]
struct Report {
    #[serde(flatten)]
    info: Info,
    seconds: f64,
    cleaned: Vec<String>,
    rms: f64,
    max: f64,
    tolerance_met: Option<bool>,
}

impl Report {
    /// The figures for people.
    fn text(&self, written: &Path) -> String {
        let mut lines =
            vec![format!("distance     rms {:.2e}, max {:.2e} of the diagonal", self.rms, self.max)];
        lines.extend(self.cleaned.iter().map(|sentence| format!("cleaned      {sentence}")));
        lines.extend(
            self.tolerance_met.map(|met| format!("tolerance    {}", if met { "met" } else { "not met" })),
        );
        lines.push(format!("written      {} in {:.1} s", written.display(), self.seconds));
        self.info.text() + &lines.join("\n") + "\n"
    }
}

/// Runs the command.
///
/// # Errors
/// The mesh cannot be read or imported, or the file not written.
pub(super) fn run(args: &Args) -> Result<()> {
    output::check_lone_wavelet_file(&args.output)?;
    let progress = Progress::new("Importing");
    let report = |share| progress.report(share);
    let Imported { model, cleaned, distance: [rms, max] } =
        import_file(&args.mesh, &args.options()?, &report)?;
    let base_faces = model.surface.hierarchy().base().faces().len();
    if let Some(limit) = args.base_faces.filter(|&limit| base_faces > limit) {
        bail!(
            "{}: its base mesh has {base_faces} faces, more than --base-faces {limit} allows",
            args.mesh.display()
        );
    }
    let bytes = encode(&model);
    output::replace(&args.output, &bytes)?;
    let report = Report {
        info: Info::of(&model, bytes.len() as u64),
        seconds: progress.seconds(),
        cleaned,
        rms,
        max,
        tolerance_met: args.tolerance.map(|tolerance| max <= tolerance),
    };
    drop(progress);
    if args.json { output::print_json(&report) } else { output::print(&report.text(&args.output)) }
}
