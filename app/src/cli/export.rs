//! `bozzetto export`: a level of a surface as a mesh.

use super::input::{LogArgs, load_model};
use super::output;
use super::size::SizeArgs;
use crate::opening::is_wavelet_file;
use anyhow::{Context, Result, bail};
use bozzetto_core::file::{Model, encode};
use bozzetto_core::hierarchy::Level;
use bozzetto_core::io::{MeshFormat, write_mesh};
use bozzetto_core::surface::Surface;
use std::path::PathBuf;

/// Write a level of a surface as a mesh, vertices in public order; or as a smaller wavelet file.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: bozzetto export assets/head.boz -o head.obj --level 3\n\
    Example: bozzetto export assets/head.boz -o small.boz --bytes 4000")]
pub(super) struct Args {
    /// The wavelet file.
    file: PathBuf,
    /// The mesh to write: .obj, .ply, .stl, .glb or .off; or a .boz with as much as --bytes, --psnr or --keep leave.
    #[arg(short, long)]
    output: PathBuf,
    /// The level to write; the finest if left out.
    #[arg(long)]
    level: Option<u8>,
    /// Keep this fraction of the wavelet coefficients, the largest after L2 normalisation.
    #[arg(long, value_name = "FRACTION", value_parser = fraction)]
    keep: Option<f64>,
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
    let mut model = load_model(&args.file, args.log.options())?;
    let name = || args.file.display().to_string();
    if !model.complete && is_wavelet_file(&args.output) {
        bail!("{}: this file is incomplete; get the rest of it first", name());
    }
    if let Some(fraction) = args.keep {
        let kept = largest_kept(&model.surface, fraction)?;
        model = Model { unknown: model.unknown, ..Model::new(kept, None, model.metadata) };
    }
    let mut file = None;
    if args.size.is_given() {
        let whole = model.surface.to_mesh(model.surface.finest());
        let (bytes, smaller) = args.size.shrink(&model, &whole).with_context(name)?;
        (file, model) = (Some(bytes), smaller);
    }
    let Some(format) = format else {
        return output::replace(&args.output, &file.unwrap_or_else(|| encode(&model)));
    };
    let level = existing_level(&model.surface, args.level).with_context(name)?;
    let mut bytes = Vec::new();
    write_mesh(&model.surface.to_mesh(level), format, &mut bytes)
        .with_context(|| args.output.display().to_string())?;
    output::replace(&args.output, &bytes)
}

fn fraction(text: &str) -> Result<f64, String> {
    let parsed = text.parse().ok().filter(|fraction| (0.0..=1.0).contains(fraction));
    parsed.ok_or_else(|| "give a fraction from 0 to 1".to_owned())
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

/// The surface with all but the largest wavelet coefficients set to zero; magnitudes of level j count `2^−j`.
fn largest_kept(surface: &Surface, fraction: f64) -> Result<Surface> {
    let finest = surface.finest().0;
    // Squared magnitudes on the scale of the finest level are exact integers.
    let size = |level: u8, d: [i32; 3]| {
        let squared: i128 = d.iter().map(|&x| i128::from(x) * i128::from(x)).sum();
        squared << (2 * (finest - level))
    };
    let mut sizes: Vec<i128> =
        (0..finest).flat_map(|j| surface.wavelets(Level(j)).iter().map(move |&d| size(j, d))).collect();
    let kept = (sizes.len() as f64 * fraction).round() as usize;
    sizes.sort_unstable_by(|a, b| b.cmp(a));
    let threshold = if kept == 0 { i128::MAX } else { sizes[kept - 1] };
    let wavelets = (0..finest)
        .map(|j| {
            let keep = |&d: &[i32; 3]| if size(j, d) >= threshold { d } else { [0; 3] };
            surface.wavelets(Level(j)).iter().map(keep).collect()
        })
        .collect();
    let hierarchy = surface.hierarchy().as_ref().clone();
    let coarsest = surface.scaling(Level::BASE).to_vec();
    Ok(Surface::from_coefficients(hierarchy, surface.form().clone(), coarsest, wavelets)?)
}
