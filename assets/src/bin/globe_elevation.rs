//! Makes `earth-elevation.png`, the grid behind the sample globe, from NOAA's ETOPO5 in netCDF form.
//!
//! ```text
//! cargo run --release -p bozzetto-assets --bin globe_elevation -- etopo5.cdf assets/earth-elevation.png [WIDTH]
//! ```
//!
//! The image is equirectangular, twice as wide as high, 16-bit grey, metres + 11000; row 0 is the northernmost and
//! column 0 begins at longitude −180°. See `assets/README.md` for where the data comes from.

use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, Result, bail};
use bozzetto_assets::elevation::ElevationGrid;
use bozzetto_assets::netcdf::read_variable;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};

/// Pixels per row unless the command line says otherwise: half a megapixel keeps the file near 0.7 MB.
const DEFAULT_WIDTH: u32 = 1024;

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("globe_elevation: {error:#}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let (input, output, width) = match arguments.as_slice() {
        [input, output] => (input, output, DEFAULT_WIDTH),
        [input, output, width] => {
            (input, output, width.parse().with_context(|| format!("the width `{width}`"))?)
        }
        _ => bail!("usage: globe_elevation ETOPO5.cdf OUT.png [WIDTH]"),
    };
    if !(2..=4096).contains(&width) || width % 2 != 0 {
        bail!("the width {width} is not an even number from 2 to 4096");
    }
    let grid = read_grid(Path::new(input)).with_context(|| input.clone())?;
    let reduced = grid.reduce(width, width / 2);

    // PNG stores 16-bit samples big-endian; the encoder takes them in native order.
    let native: Vec<u8> = reduced.grey_levels().iter().flat_map(|level| level.to_ne_bytes()).collect();
    let mut png = Vec::new();
    PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::Adaptive).write_image(
        &native,
        reduced.width,
        reduced.height,
        ExtendedColorType::L16,
    )?;
    std::fs::write(output, &png).with_context(|| output.clone())?;

    let low = reduced.metres.iter().copied().fold(f64::INFINITY, f64::min);
    let high = reduced.metres.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    println!("{output}: {width} x {}, {} bytes, {low:.0} m to {high:.0} m", width / 2, png.len());
    Ok(())
}

fn read_grid(path: &Path) -> Result<ElevationGrid> {
    let bytes = std::fs::read(path)?;
    let longitudes = read_variable(&bytes, "ETOPO05_X")?.values;
    let latitudes = read_variable(&bytes, "ETOPO05_Y")?.values;
    let heights = read_variable(&bytes, "ROSE")?;
    ElevationGrid::new(longitudes, latitudes, heights.values)
}
