//! `bozzetto render`: a picture of a surface, without a window.

use super::export::existing_level;
use super::input::{LogArgs, load_surface};
use super::output;
use crate::display::{Influence, ShownVertices, support_border, tints};
use crate::render::{
    Background, BoundingSphere, GhostMesh, Gpu, Handle, HandleState, Line, Samples, Scene, Shading, Style,
    View, render_png,
};
use anyhow::{Context, Result, bail};
use bozzetto_core::edit::Kind;
use bozzetto_core::hierarchy::{PublicId, Slot};
use bozzetto_core::surface::Surface;
use clap::ValueEnum;
use std::path::PathBuf;
use std::str::FromStr;

/// Draw a picture of a surface.
#[derive(Debug, clap::Args)]
#[command(after_help = "Overlays, several allowed: edges[=LEVEL], handles=LEVEL, control=LEVEL,\n\
    scaling=LEVEL/VERTEX and wavelet=LEVEL/VERTEX (a coefficient's influence and support).\n\n\
    Example: bozzetto render assets/head.boz -o head.png --view 30,10,1 --overlay edges=1")]
pub(super) struct Args {
    /// A .boz file or a mesh.
    file: PathBuf,
    /// The picture to write, a PNG.
    #[arg(short, long)]
    output: PathBuf,
    /// Width and height in pixels.
    #[arg(long, value_name = "WxH", default_value = "1280x800")]
    size: Size,
    /// The level to show; the finest if left out.
    #[arg(long)]
    level: Option<u8>,
    /// Where to look from: front, right, top, or yaw,pitch,distance in degrees and fitting distances.
    #[arg(long, value_name = "VIEW", allow_hyphen_values = true, default_value = "30,18,1")]
    view: View,
    /// What to draw over the surface.
    #[arg(long, value_name = "OVERLAY")]
    overlay: Vec<Overlay>,
    /// How the surface is lit.
    #[arg(long, default_value = "clay")]
    shading: ShadingArg,
    /// A light background, for documents.
    #[arg(long)]
    light: bool,
    #[command(flatten)]
    log: LogArgs,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum ShadingArg {
    Clay,
    Porcelain,
    Normals,
    Flat,
}

#[derive(Debug, Clone, Copy)]
struct Size([u32; 2]);

/// Larger pictures are refused: few adapters can draw them.
const LARGEST: u32 = 8192;

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let sides =
            text.split_once(['x', 'X', '×']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
        let sides = sides.filter(|sides| sides.iter().all(|s| (1..=LARGEST).contains(s)));
        sides.map(Size).ok_or_else(|| format!("give width and height from 1 to {LARGEST}, such as 1280x800"))
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Overlay {
    Edges(Option<u8>),
    Handles(u8),
    Control(u8),
    Influence(Kind, u8, u32),
}

impl FromStr for Overlay {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text.split_once('=').map_or((text, None), |(name, value)| (name, Some(value)));
        let level = || value.and_then(|v| v.parse().ok());
        let coefficient = |kind| {
            let (level, vertex) = value?.split_once('/')?;
            Some(Overlay::Influence(kind, level.parse().ok()?, vertex.parse().ok()?))
        };
        match (name, value) {
            ("edges", None) => Some(Overlay::Edges(None)),
            ("edges", _) => level().map(|l| Overlay::Edges(Some(l))),
            ("handles", _) => level().map(Overlay::Handles),
            ("control", _) => level().map(Overlay::Control),
            ("scaling", _) => coefficient(Kind::Scaling),
            ("wavelet", _) => coefficient(Kind::Wavelet),
            _ => None,
        }
        .ok_or_else(|| {
            "give edges[=LEVEL], handles=LEVEL, control=LEVEL, scaling=L/VERTEX or wavelet=L/VERTEX".into()
        })
    }
}

/// Runs the command.
///
/// # Errors
/// The file cannot be read, an overlay names what is not there, there is no way to draw, or the picture cannot be
/// written.
pub(super) fn run(args: &Args) -> Result<()> {
    if args.output.extension().is_none_or(|e| !e.eq_ignore_ascii_case("png")) {
        bail!("{}: pictures are PNG files; let the name end in .png", args.output.display());
    }
    output::check(&args.output)?;
    let surface = load_surface(&args.file, args.log.options())?.surface;
    let name = || args.file.display().to_string();
    let level = existing_level(&surface, args.level).with_context(name)?;
    let shown = ShownVertices::new(&surface, level);
    let overlays = Overlays::collect(&surface, &shown, &args.overlay).with_context(name)?;
    let picture = draw(&Gpu::headless()?, &surface, &shown, &overlays, args)?;
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, image::ImageFormat::Png)?;
    output::replace(&args.output, bytes.get_ref())
}

fn draw(
    gpu: &Gpu,
    surface: &Surface,
    shown: &ShownVertices,
    drawn: &Overlays,
    args: &Args,
) -> Result<image::RgbaImage> {
    let style = Style {
        shading: match args.shading {
            ShadingArg::Clay => Shading::Clay,
            ShadingArg::Porcelain => Shading::Porcelain,
            ShadingArg::Normals => Shading::Normals,
            ShadingArg::Flat => Shading::Flat,
        },
        background: if args.light { Background::Light } else { Background::Dark },
        ..Style::default()
    };
    let scene = Scene {
        positions: shown.positions(),
        normals: shown.normals(),
        tints: &drawn.tints,
        triangles: &surface.hierarchy().triangles(shown.level()),
        edges: &drawn.edges,
        lines: &drawn.lines,
        handles: &drawn.handles,
        ghost: GhostMesh {
            positions: &drawn.control.positions,
            triangles: &drawn.control.triangles,
            edges: &drawn.control.edges,
        },
        style,
    };
    let Size(size) = args.size;
    // The base mesh's hull may be larger than the surface, but pictures of one file should share one frame.
    let finest = ShownVertices::new(surface, surface.finest());
    let sphere = BoundingSphere::of(finest.positions());
    let camera = args.view.camera(sphere, f64::from(size[0]) / f64::from(size[1]));
    Ok(render_png(gpu, &scene, &camera, size, Samples::Four)?)
}

/// The control polyhedron of a level.
#[derive(Default)]
struct Control {
    positions: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    edges: Vec<[u32; 2]>,
}

/// Everything drawn over the surface, gathered.
#[derive(Default)]
struct Overlays {
    tints: Vec<[u8; 4]>,
    edges: Vec<[u32; 2]>,
    lines: Vec<Line>,
    handles: Vec<Handle>,
    control: Control,
}

impl Overlays {
    fn collect(surface: &Surface, shown: &ShownVertices, wanted: &[Overlay]) -> Result<Self> {
        let mut all = Self::default();
        for overlay in wanted {
            all.add(surface, shown, *overlay)?;
        }
        Ok(all)
    }

    fn add(&mut self, surface: &Surface, shown: &ShownVertices, overlay: Overlay) -> Result<()> {
        let hierarchy = surface.hierarchy();
        match overlay {
            Overlay::Edges(level) => {
                let level = existing_level(surface, level.or(Some(shown.level().0)))?.min(shown.level());
                self.edges = hierarchy.edges_shown_on(level, shown.level());
            }
            Overlay::Handles(level) => {
                let level = existing_level(surface, Some(level))?.min(shown.level());
                let at = |s: u32| hierarchy.refine_slot(level, shown.level(), Slot(s));
                self.handles.extend((0..hierarchy.layout(level).len()).map(|s| Handle {
                    position: shown.positions()[at(s).index()],
                    radius: 4.0,
                    fill: [244, 238, 226, 255],
                    rim: [30, 30, 34, 255],
                    state: HandleState::Idle,
                }));
            }
            Overlay::Control(level) => {
                let level = existing_level(surface, Some(level))?;
                let control = ShownVertices::new(surface, level);
                self.control = Control {
                    positions: control.positions().to_vec(),
                    triangles: hierarchy.triangles(level),
                    edges: hierarchy.edges(level),
                };
            }
            Overlay::Influence(kind, level, vertex) => {
                let level = existing_level(surface, Some(level))?;
                let Some(influence) = Influence::of(surface, kind, level, PublicId(vertex), shown.level())
                else {
                    bail!(
                        "{kind} coefficient {vertex} of level {level} does not exist or is finer than the level shown"
                    );
                };
                self.tints.resize(shown.positions().len(), [0; 4]);
                for (slot, tint) in tints(&influence) {
                    self.tints[slot.index()] = tint;
                }
                let at = |slot: u32| shown.positions()[slot as usize];
                let outline = support_border(hierarchy.layout(shown.level()), &influence);
                let color = [250, 246, 236, 230];
                self.lines.extend(outline.iter().map(|&[a, b]| Line {
                    from: at(a),
                    to: at(b),
                    color,
                    width: 2.0,
                }));
            }
        }
        Ok(())
    }
}
