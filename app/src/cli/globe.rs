//! `bozzetto globe`: a picture of elevations onto a subdivided octahedron.

use super::form::FormArgs;
use super::info::Info;
use super::output;
use super::progress::Busy;
use crate::opening::metadata_of;
use anyhow::{Context, Result};
use bozzetto_core::conversion::{EquirectangularGrid, GridMeaning, globe};
use bozzetto_core::file::{Model, encode};
use bozzetto_core::surface::Surface;
use std::path::{Path, PathBuf};

/// Levels when nothing else is asked for: 131 thousand faces.
const DEFAULT_LEVELS: u8 = 7;

/// Make a globe from an equirectangular picture: row 0 in the north, column 0 at longitude -180.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: bozzetto globe assets/earth-elevation.png -o earth.boz --zero 0.16785")]
pub(super) struct Args {
    /// The picture: a grey PNG or TIFF, 8 to 32 bits.
    image: PathBuf,
    /// The wavelet file to write.
    #[arg(short, long)]
    output: PathBuf,
    /// The picture's values are radii instead of elevations.
    #[arg(long, conflicts_with_all = ["relief", "zero"])]
    radius_grid: bool,
    /// How much radius black to white is worth, for elevations.
    #[arg(long, default_value_t = 0.12, allow_negative_numbers = true)]
    relief: f64,
    /// The grey value, from 0 to 1, at sea level (radius 1), for elevations.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true)]
    zero: f64,
    /// Levels over the octahedron.
    #[arg(long, value_name = "J", default_value_t = DEFAULT_LEVELS)]
    levels: u8,
    #[command(flatten)]
    form: FormArgs,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// The picture cannot be read, makes no globe, or the file cannot be written.
pub(super) fn run(args: &Args) -> Result<()> {
    output::check_lone_wavelet_file(&args.output)?;
    let busy = Busy::new("Making the globe");
    let grid = read_grid(&args.image)?;
    let meaning = if args.radius_grid {
        GridMeaning::Radius
    } else {
        GridMeaning::Elevation { relief: args.relief, zero: args.zero }
    };
    let named = |sentence: String| anyhow::anyhow!("{}: {sentence}", args.image.display());
    let made = globe(&grid, meaning, args.levels).map_err(|e| named(e.to_string()))?;
    let surface = Surface::from_positions(made.hierarchy, &made.positions, &args.form.options())
        .map_err(|e| named(e.to_string()))?;
    let model = Model::new(surface, None, metadata_of(&args.image));
    let bytes = encode(&model);
    output::replace(&args.output, &bytes)?;
    drop(busy);
    let info = Info::of(&model, bytes.len() as u64);
    if args.json { output::print_json(&info) } else { output::print(&info.text()) }
}

fn read_grid(path: &Path) -> Result<EquirectangularGrid> {
    let reader = image::ImageReader::open(path)
        .map_err(|e| anyhow::anyhow!("{}: {e}; check the path and its permissions", path.display()))?;
    let mut reader = reader.with_guessed_format().with_context(|| path.display().to_string())?;
    let mut limits = image::Limits::default();
    limits.max_alloc = Some(2 << 30);
    reader.limits(limits);
    let picture = reader.decode().with_context(|| {
        format!("{}: this is not a PNG or TIFF picture; convert it to one", path.display())
    })?;
    let grey = picture.to_luma32f();
    let (width, height) = grey.dimensions();
    EquirectangularGrid::new(width as usize, height as usize, grey.into_raw())
        .map_err(|e| anyhow::anyhow!("{}: {e}", path.display()))
}
