//! `bozzetto export`: a level of a surface as a mesh.

use super::input::{LogArgs, load_model};
use super::output;
use super::progress::Progress;
use super::size::SizeArgs;
use crate::figures::grouped;
use anyhow::{Context, Result, bail};
use bozzetto_core::file::{encode, is_wavelet_file};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::io::{MeshFormat, write_mesh};
use bozzetto_core::lod::{adaptive_triangulation, domain_distance};
use bozzetto_core::mesh::{CompareOptions, Comparison, compare};
use bozzetto_core::surface::Surface;
use serde::Serialize;
use serde_json::json;
use std::fmt;
use std::path::PathBuf;

/// Write a level of a surface as a mesh, vertices in public order; or as a smaller wavelet file.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: bozzetto export assets/head.boz -o head.obj --level 3\n\
    Example: bozzetto export assets/head.boz -o small.boz --bytes 4000\n\
    Example: bozzetto export assets/head.boz -o light.obj --keep 0.12 --adaptive")]
pub(super) struct Args {
    /// The wavelet file.
    file: PathBuf,
    /// The mesh to write: .obj, .ply, .stl, .glb or .off; or a .boz with as much as --bytes, --psnr or --keep leave.
    #[arg(short, long)]
    output: PathBuf,
    /// The level to write; the finest if left out.
    #[arg(long)]
    level: Option<u8>,
    /// Write large triangles where the surface is flat, without cracks.
    #[arg(long, conflicts_with = "level")]
    adaptive: bool,
    /// How far, over the diagonal, the triangles of --adaptive may be from the surface; as far as what --keep, --bytes or --psnr
    /// left out if not given, else 0: only what is flat is joined.
    #[arg(long, value_name = "T", requires = "adaptive", value_parser = distance)]
    tolerance: Option<f64>,
    /// Print one JSON object: what was written, what was left out, and the error measured.
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    size: SizeArgs,
    #[command(flatten)]
    log: LogArgs,
}

/// Runs the command.
///
/// # Errors
/// The file cannot be read, the level does not exist, or the mesh cannot be written.
pub(super) fn run(args: &Args) -> Result<()> {
    let format = MeshFormat::from_path(&args.output);
    if is_wavelet_file(&args.output) {
        output::check_apart(&args.output, &args.file)?;
        output::check_lone_wavelet_file(&args.output)?;
        if args.level.is_some() {
            bail!("{}: a wavelet file holds every level; leave --level out", args.output.display());
        }
    } else if format.is_some() {
        output::check(&args.output)?;
    } else {
        bail!("{}: the format is not known; use .obj, .ply, .stl, .glb, .off or .boz", args.output.display());
    }
    if args.adaptive && format.is_none() {
        bail!("{}: a wavelet file has no triangles; leave --adaptive out", args.output.display());
    }
    let mut model = load_model(&args.file, args.log.options())?;
    let name = || args.file.display().to_string();
    if !model.complete && is_wavelet_file(&args.output) {
        bail!("{}: this file is incomplete; get the rest of it first", name());
    }
    let lossy = args.size.keeps_some() || args.size.is_given() || args.adaptive;
    let whole = lossy.then(|| model.surface.clone());
    let kept = args.size.keep(&mut model).map(|kept| (kept.kept, kept.predicted));
    let mut file = None;
    if args.size.is_given() {
        let mesh = model.surface.to_mesh(model.surface.finest());
        if let Some((bytes, smaller)) = args.size.shrink(&model, &mesh).with_context(name)? {
            (file, model) = (Some(bytes), smaller);
        }
    }
    let level = existing_level(&model.surface, args.level).with_context(name)?;
    if format.is_none() && !lossy {
        output::replace(&args.output, &encode(&model))?;
        return whole_written(args, &model.surface, level);
    }
    let in_domain = whole.as_ref().map_or(0.0, |whole| domain_distance(whole, &model.surface));
    let mut mesh = model.surface.to_mesh(level);
    // Without a tolerance of its own the triangulation may be as far off as what was dropped.
    let mut tolerance = None;
    if args.adaptive {
        let diagonal = mesh.bounds().map_or(0.0, |bounds| bounds.diagonal());
        let chosen = args.tolerance.map_or(in_domain, |tolerance| tolerance * diagonal);
        mesh = adaptive_triangulation(&model.surface, chosen);
        tolerance = Some(chosen);
    }
    match format {
        None => output::replace(&args.output, &file.unwrap_or_else(|| encode(&model)))?,
        Some(format) => {
            let mut bytes = Vec::new();
            write_mesh(&mesh, format, &mut bytes).with_context(|| args.output.display().to_string())?;
            output::replace(&args.output, &bytes)?;
        }
    }
    let Some(whole) = whole else { return whole_written(args, &model.surface, level) };
    let progress = Progress::new("Measuring");
    let original = whole.to_mesh(level);
    let error = compare(&original, &mesh, &CompareOptions::default(), &|share| progress.report(share))
        .with_context(name)?;
    drop(progress);
    let outcome = Outcome {
        kept: kept.map(|(count, _)| count),
        coefficients: (0..whole.finest().0).map(|j| whole.wavelets(Level(j)).len()).sum(),
        predicted: kept.map(|(_, predicted)| predicted / error.diagonal),
        in_domain: in_domain / error.diagonal,
        vertices: mesh.positions.len(),
        faces: mesh.faces.len(),
        faces_of_finest: whole.hierarchy().face_count(whole.finest()),
        tolerance: tolerance.map(|tolerance| tolerance / error.diagonal),
        error,
    };
    if args.json { output::print_json(&outcome) } else { output::print(&outcome.to_string()) }
}

fn distance(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|distance: &f64| (0.0..=1.0).contains(distance));
    parsed.ok_or_else(|| "give a distance over the diagonal, from 0 to 1".to_owned())
}

/// Says what an export wrote that left nothing out.
fn whole_written(args: &Args, surface: &Surface, level: Level) -> Result<()> {
    if !args.json {
        return Ok(());
    }
    let hierarchy = surface.hierarchy();
    let (vertices, faces) = (hierarchy.layout(level).len(), hierarchy.face_count(level));
    output::print_json(&json!({ "level": level.0, "vertices": vertices, "faces": faces }))
}

/// The level asked for, or the finest.
///
/// # Errors
/// There is no such level.
pub(super) fn existing_level(surface: &Surface, level: Option<u8>) -> Result<Level> {
    let finest = surface.finest();
    match level {
        None => Ok(finest),
        Some(level) if level <= finest.0 => Ok(Level(level)),
        Some(level) => {
            bail!("level {level} does not exist: this surface has levels 0 to {finest}; choose one of those")
        }
    }
}

/// What is said of an export that left something out.
#[derive(Debug, Serialize)]
struct Outcome {
    /// Wavelet coefficients kept that are not zero, of `--keep`.
    kept: Option<usize>,
    /// Wavelet coefficients there were.
    coefficients: usize,
    /// Root mean square distance between points with the same place on the base mesh, as the dropped coefficients
    /// foretell it, over the diagonal.
    predicted: Option<f64>,
    /// The same, measured.
    in_domain: f64,
    vertices: usize,
    faces: usize,
    /// Faces of the finest level.
    faces_of_finest: u64,
    /// The tolerance of `--adaptive`, over the diagonal.
    tolerance: Option<f64>,
    #[serde(flatten)]
    error: Comparison,
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(kept) = self.kept {
            let share = 100.0 * kept as f64 / self.coefficients.max(1) as f64;
            let (kept, all) = (grouped(kept as u64), grouped(self.coefficients as u64));
            writeln!(f, "kept       {kept} of {all} wavelet coefficients ({share:.2} %)")?;
        }
        let (faces, all) = (grouped(self.faces as u64), grouped(self.faces_of_finest));
        writeln!(f, "faces      {faces} of {all}, {} vertices", grouped(self.vertices as u64))?;
        let Comparison { rms, max, psnr, .. } = self.error;
        let psnr = psnr.map_or(String::new(), |psnr| format!(", {psnr:.2} dB"));
        writeln!(f, "error      rms {rms:.3e}, max {max:.3e} of the diagonal, both ways{psnr}")?;
        if let Some(predicted) = self.predicted {
            let at = self.in_domain;
            writeln!(f, "in the wavelets' norm {at:.3e}, by the dropped coefficients {predicted:.3e}")?;
        }
        Ok(())
    }
}
