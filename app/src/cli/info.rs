//! `bozzetto info`: what a file holds.

use super::input::{LogArgs, load_surface};
use super::output;
use anyhow::{Context, Result};
use bozzetto_core::file::{CurvePoint, Model};
use bozzetto_core::surface::{CHANNELS, Surface};
use bozzetto_core::wavelet::Wavelet;
use serde::Serialize;
use std::path::PathBuf;

/// Say what a wavelet file or a mesh holds.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example: bozzetto info assets/head.boz")]
pub(super) struct Args {
    /// A .boz file or a mesh.
    file: PathBuf,
    #[command(flatten)]
    log: LogArgs,
    /// Print one JSON object.
    #[arg(long)]
    json: bool,
}

/// The figures of a surface.
#[derive(Debug, Serialize)]
pub(super) struct Info {
    vertices: u32,
    faces: u64,
    levels: u8,
    base_vertices: u32,
    base_faces: usize,
    sharp_edges: usize,
    components: u32,
    genus: u32,
    boundary_loops: u32,
    channels: [&'static str; 3],
    scheme: String,
    /// As `import --wavelet` takes it: lazy, 0, 1 or 2.
    wavelet: String,
    precision: u8,
    /// The model's up axis: x, y or z.
    up: String,
    /// Its unit of length; empty if unknown.
    unit: String,
    complete: bool,
    bytes: u64,
    hash: String,
    /// How far the surface was from the whole after so many bytes of the file: estimates over the diagonal.
    curve: Vec<CurvePoint>,
}

impl Info {
    /// The figures of a model in a file of so many bytes.
    pub(super) fn of(model: &Model, bytes: u64) -> Self {
        let surface = &model.surface;
        let hierarchy = surface.hierarchy();
        let base = hierarchy.base();
        Self {
            vertices: hierarchy.layout(surface.finest()).len(),
            faces: hierarchy.face_count(surface.finest()),
            levels: surface.finest().0,
            base_vertices: base.vertex_count(),
            base_faces: base.faces().len(),
            sharp_edges: base.sharp_edges().len(),
            components: base.components(),
            genus: base.genus(),
            boundary_loops: base.boundary_loops(),
            channels: CHANNELS,
            scheme: surface.form().scheme.to_string(),
            wavelet: match surface.form().wavelet {
                Wavelet::Lazy => "lazy".to_owned(),
                Wavelet::Disc(k) => k.to_string(),
            },
            precision: surface.form().precision,
            up: surface.form().placement.up.to_string(),
            unit: surface.form().placement.unit.clone(),
            complete: model.complete,
            bytes,
            hash: surface.hash().to_string(),
            curve: curve(model),
        }
    }

    /// The figures for people.
    pub(super) fn text(&self) -> String {
        let plural = |n: u32, one: &str, many: &str| format!("{n} {}", if n == 1 { one } else { many });
        let topology = [
            plural(self.components, "component", "components"),
            format!("genus {}", self.genus),
            plural(self.boundary_loops, "boundary loop", "boundary loops"),
        ];
        let wavelet = match self.wavelet.as_str() {
            "lazy" => "lazy".to_owned(),
            k => format!("{k}-disc"),
        };
        let mut lines = vec![
            ("surface", format!("{} vertices, {} faces", self.vertices, self.faces)),
            (
                "levels",
                format!(
                    "{} over {} base vertices, {} base faces",
                    self.levels, self.base_vertices, self.base_faces
                ),
            ),
            ("topology", topology.join(", ")),
            ("wavelet", format!("{wavelet}, scheme {}, {} bits", self.scheme, self.precision)),
            (
                "placement",
                format!("{} up, unit {}", self.up, if self.unit.is_empty() { "unknown" } else { &self.unit }),
            ),
            ("hash", self.hash.clone()),
            ("file", format!("{} bytes{}", self.bytes, if self.complete { "" } else { ", incomplete" })),
        ];
        lines.extend(self.curve_lines());
        if self.sharp_edges > 0 {
            lines.insert(3, ("sharp", format!("{} base edges", self.sharp_edges)));
        }
        lines.into_iter().map(|(key, value)| format!("{key:<13}{value}\n")).collect()
    }

    /// A point of the curve for every doubling of bytes.
    fn curve_lines(&self) -> Vec<(&'static str, String)> {
        let mut lines = Vec::new();
        let mut due = 0;
        for point in self.curve.iter().filter(|point| point.error > 0.0) {
            if point.bytes >= due {
                let decibels = -20.0 * point.error.log10();
                let key = if lines.is_empty() { "curve" } else { "" };
                lines.push((key, format!("{:>9} bytes  about {decibels:.1} dB", point.bytes)));
                due = 2 * point.bytes;
            }
        }
        lines
    }
}

/// The file's curve, errors over the diagonal of the box around the finest vertices.
fn curve(model: &Model) -> Vec<CurvePoint> {
    let diagonal = diagonal(&model.surface);
    let over = |point: &CurvePoint| CurvePoint { error: point.error / diagonal, ..*point };
    model.curve.iter().map(over).filter(|point| point.error.is_finite()).collect()
}

fn diagonal(surface: &Surface) -> f64 {
    let finest = surface.scaling(surface.finest());
    let side = |c: usize| {
        let (low, high) =
            finest.iter().fold((i32::MAX, i32::MIN), |(low, high), v| (low.min(v[c]), high.max(v[c])));
        f64::from(high) - f64::from(low)
    };
    let squares: f64 = (0..3).map(|c| side(c) * side(c)).sum();
    squares.sqrt() * surface.form().placement.step
}

/// Runs the command.
///
/// # Errors
/// The file cannot be read.
pub(super) fn run(args: &Args) -> Result<()> {
    let model = load_surface(&args.file, args.log.options())?;
    let bytes = std::fs::metadata(&args.file).with_context(|| args.file.display().to_string())?.len();
    let info = Info::of(&model, bytes);
    if args.json { output::print_json(&info) } else { output::print(&info.text()) }
}
