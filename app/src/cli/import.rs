//! `bozzetto import`: a mesh to a wavelet file.

use super::form::FormArgs;
use super::info::Info;
use super::output;
use super::progress::Progress;
use super::size::SizeArgs;
use crate::figures::tolerance;
use crate::opening::{ImportOptions, Imported, MeshSource, Stage, compact, import_file, import_file_alone};
use crate::report::report;
use anyhow::{Result, bail};
use bozzetto_core::conversion::{Axis, ConversionOptions, Remesh};
use bozzetto_core::file::encode;
use bozzetto_core::mesh::{CompareOptions, compare};
use bozzetto_core::wavelet::Wavelet;
use clap::ValueEnum;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// The smallest distance that can be asked for, far below a step of 25 bits.
const SMALLEST_TOLERANCE: f64 = 1e-12;

/// Turn a mesh into a wavelet file.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "A mesh with subdivision connectivity keeps its vertices; any other is converted, and the distance \
    between the two is measured and said.\n\n\
    Example: bozzetto import scan.obj -o scan.boz --wavelet 2\n\
    Example: bozzetto import part.stl -o part.boz --up z --unit mm --tolerance 1e-3 --report part.html\n\
    Example: bozzetto import scan.ply -o scan.boz --levels 5 --base-faces 500 --json\n\
    Example: bozzetto import bust.ply -o bust.boz --symmetric x\n\
    Example: bozzetto import scan.ply -o small.boz --purpose compact --psnr 65"
)]
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
    #[arg(long, value_name = "T", value_parser = tolerance_share)]
    tolerance: Option<f64>,
    /// Edges sharper than this angle, 0 to 180 degrees, stay sharp at every level; 180 keeps none. Left out, they do on
    /// meshes that look made, such as mechanical parts, and on no others. Edges marked in the file stay sharp in any case:
    /// in OBJ those of `l` lines and between smoothing groups, in PLY the elements `edge`.
    #[arg(long, value_name = "DEGREES", value_parser = degrees)]
    sharp_angle: Option<f64>,
    /// Make the base mesh its own mirror image along this axis of the file, so that both sides have the same handles. The mesh
    /// must be nearly symmetric; the surface keeps what is uneven about it.
    #[arg(long, value_name = "AXIS", ignore_case = true)]
    symmetric: Option<AxisArg>,
    /// Upper limit of base faces; chosen from the mesh if left out.
    #[arg(long, value_name = "N")]
    base_faces: Option<usize>,
    /// What the file is for: edit chooses base mesh and levels for handles and distance and keeps every detail; compact tries
    /// base meshes, levels and wavelets for the smallest file at --psnr, or the nearest in --bytes; if neither is given, every bit
    /// is kept of the surface that is smallest at 80 decibels.
    #[arg(long, default_value = "edit")]
    purpose: PurposeArg,
    #[command(flatten)]
    size: SizeArgs,
    /// Write a report beside it: one HTML file with pictures, distances, repairs, settings and times.
    #[arg(long, value_name = "OUT.html")]
    report: Option<PathBuf>,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// An angle between two faces.
fn degrees(text: &str) -> Result<f64, String> {
    let angle: f64 = text.parse().map_err(|_| "give a number of degrees from 0 to 180".to_owned())?;
    if (0.0..=180.0).contains(&angle) {
        Ok(angle)
    } else {
        Err("give an angle from 0 to 180 degrees".to_owned())
    }
}

/// A distance over the diagonal that can be asked for.
fn tolerance_share(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|share| (SMALLEST_TOLERANCE..=1.0).contains(share));
    parsed.ok_or_else(|| format!("give a distance over the diagonal, from {SMALLEST_TOLERANCE:e} to 1"))
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum RemeshArg {
    Auto,
    Always,
    Never,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum PurposeArg {
    Edit,
    Compact,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum AxisArg {
    X,
    Y,
    Z,
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
                sharp_angle: self.sharp_angle,
                symmetric: self.symmetric.map(|axis| match axis {
                    AxisArg::X => Axis::X,
                    AxisArg::Y => Axis::Y,
                    AxisArg::Z => Axis::Z,
                }),
            },
            form: self.form.options(),
        })
    }

    /// Imports the mesh for the purpose.
    fn make(&self, progress: &Progress) -> Result<Made> {
        let options = self.options()?;
        if self.purpose == PurposeArg::Compact {
            return self.make_compact(&options, progress);
        }
        let report = |stage: Stage, done| progress.report(stage.share(done));
        // The mesh is needed again for little else than these.
        if !self.size.is_given() && !self.size.keeps_some() && self.report.is_none() {
            let imported = import_file_alone(&self.mesh, &options, &report)?;
            let bytes = encode(&imported.model);
            return Ok(Made { source: None, imported, options, bytes, tried: 1 });
        }
        let (source, mut imported) = import_file(&self.mesh, &options, &report)?;
        let kept = self.size.keep(&mut imported.model).is_some();
        let shrunk = self.size.shrink(&imported.model, &source.mesh)?;
        let lossy = kept || shrunk.is_some();
        let bytes = match shrunk {
            Some((bytes, smaller)) => {
                imported.model = smaller;
                bytes
            }
            None => encode(&imported.model),
        };
        if lossy {
            let surface = &imported.model.surface;
            let mesh = surface.to_mesh(surface.finest());
            let measured = compare(&source.mesh, &mesh, &CompareOptions::default(), &|_| true)?;
            imported.distance = [measured.rms, measured.max];
            imported.measured = Some(measured);
        }
        Ok(Made { source: Some(source), imported, options, bytes, tried: 1 })
    }

    fn make_compact(&self, options: &ImportOptions, progress: &Progress) -> Result<Made> {
        let source = MeshSource::read(&self.mesh, &|stage, done| progress.report(stage.share(done)))?;
        let wavelets: &[Wavelet] = match self.form.names_wavelet() {
            true => &[],
            false => &[Wavelet::Disc(0), Wavelet::Disc(1), Wavelet::Disc(2)],
        };
        let size = self.size.to(&source.mesh);
        let found =
            compact::import_compact(&source, options, wavelets, size, &|share| progress.report(share))?;
        let compact::Compact { imported, options, bytes, tried } = found;
        Ok(Made { source: Some(source), imported, options, bytes, tried })
    }
}

/// An import and the file that it becomes.
struct Made {
    /// If it is needed again.
    source: Option<MeshSource>,
    imported: Imported,
    /// As asked for, or as chosen.
    options: ImportOptions,
    bytes: Vec<u8>,
    /// How many surfaces were tried.
    tried: usize,
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
    /// How many surfaces were tried.
    tried: usize,
}

impl Report {
    /// The figures for people; with the tolerance demanded, if one was.
    fn text(&self, written: &Path, demanded: Option<f64>) -> String {
        let mut lines =
            vec![format!("distance     rms {:.2e}, max {:.2e} of the diagonal", self.rms, self.max)];
        lines.extend(self.cleaned.iter().map(|sentence| format!("cleaned      {sentence}")));
        lines.extend(demanded.map(|demanded| format!("tolerance    {}", tolerance(self.max, demanded))));
        if self.tried > 1 {
            lines.push(format!("chosen       of {} surfaces tried", self.tried));
        }
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
    if let Some(path) = &args.report {
        check_report(path)?;
    }
    if args.purpose == PurposeArg::Compact && args.tolerance.is_some() {
        bail!(
            "--tolerance is not kept by --purpose compact, which leaves detail out; say --psnr instead, or --purpose edit"
        );
    }
    if args.purpose == PurposeArg::Compact && args.size.keeps_some() {
        bail!(
            "--keep is not for --purpose compact, which chooses what to leave out; say --bytes or --psnr instead"
        );
    }
    let progress = Progress::new("Importing");
    let Made { source, imported, options, bytes, tried } = args.make(&progress)?;
    let base_faces = imported.model.surface.hierarchy().base().faces().len();
    if let Some(limit) = args.base_faces.filter(|&limit| base_faces > limit) {
        bail!(
            "{}: its base mesh has {base_faces} faces, more than --base-faces {limit} allows",
            args.mesh.display()
        );
    }
    let model = &imported.model;
    let [rms, max] = imported.distance;
    let name = args.output.file_name().unwrap_or_default().to_string_lossy();
    let reported = source.as_ref().filter(|_| args.report.is_some());
    let page = reported.map(|source| report(source, &imported, &options, &name)).transpose()?;
    output::replace(&args.output, &bytes)?;
    if let (Some(path), Some(page)) = (&args.report, page) {
        output::replace(path, page.as_bytes())?;
    }
    let report = Report {
        info: Info::of(model, bytes.len() as u64),
        seconds: progress.seconds(),
        cleaned: imported.cleaned.clone(),
        rms,
        max,
        tolerance_met: args.tolerance.map(|tolerance| max <= tolerance),
        tried,
    };
    drop(progress);
    if args.json {
        output::print_json(&report)
    } else {
        output::print(&report.text(&args.output, args.tolerance))
    }
}

/// Refuses a report that is no HTML file or cannot be written.
fn check_report(path: &Path) -> Result<()> {
    if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("html") && !e.eq_ignore_ascii_case("htm")) {
        bail!("{}: the report is a page; let its name end in .html", path.display());
    }
    output::check(path)
}
