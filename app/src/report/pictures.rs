//! The pictures of a report, drawn without a window and put into the page.

use crate::display::{Frame, HeatScale, ShownVertices};
use crate::opening::MeshSource;
use crate::render::{
    Background, BoundingSphere, Camera, Gpu, GpuError, LineStyle, Samples, Scene, Shading, Style, View,
    render_png,
};
use anyhow::Result;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use bozzetto_core::hierarchy::Level;
use bozzetto_core::surface::Surface;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ImageEncoder, RgbaImage};

/// Width and height of a picture, in pixels: four of them take about one megabyte.
const SIZE: [u32; 2] = [640, 560];

/// The pictures, or why there are none.
pub(super) enum Pictures {
    /// Drawn.
    Drawn(Box<Drawn>),
    /// There is no way to draw on this machine; why, in a sentence.
    None(String),
}

/// Pictures from one camera, as data addresses, and the scale of the last.
pub(super) struct Drawn {
    /// The mesh as it was read.
    pub(super) mesh: String,
    /// The surface.
    pub(super) surface: String,
    /// The base mesh with its edges.
    pub(super) base: String,
    /// The surface, painted with its distance to the mesh.
    pub(super) error: String,
    /// The colours of that.
    pub(super) scale: HeatScale,
}

impl Pictures {
    /// Draws all of them. `map` is the distance of every vertex of the finest level.
    ///
    /// # Errors
    /// There is an adapter, but it cannot draw this.
    pub(super) fn draw(
        source: &MeshSource,
        surface: &Surface,
        map: &[f64],
        tolerance: Option<f64>,
    ) -> Result<Self> {
        let gpu = match Gpu::headless() {
            Ok(gpu) => gpu,
            Err(error @ GpuError::NoAdapter(_)) => return Ok(Self::None(error.to_string())),
            Err(error) => return Err(error.into()),
        };
        let finest = ShownVertices::new(surface, surface.finest());
        let sphere = BoundingSphere::of(finest.positions());
        let camera = View::default().camera(sphere, f64::from(SIZE[0]) / f64::from(SIZE[1]));
        let style = Style { background: Background::Light, ..Style::default() };
        let triangles = surface.hierarchy().triangles(surface.finest());
        let shown = Scene {
            positions: finest.positions(),
            normals: finest.normals(),
            triangles: &triangles,
            style,
            ..Scene::default()
        };
        let scale = HeatScale::of(map, tolerance);
        let tints = scale.tints(map);
        let painted = Scene { tints: &tints, style: Style { cavity: 0.0, ..style }, ..shown };
        Ok(Self::Drawn(Box::new(Drawn {
            mesh: mesh_as_read(&gpu, source, surface, &camera, style)?,
            surface: data_address(&render_png(&gpu, &shown, &camera, SIZE, Samples::Four)?)?,
            base: base_mesh(&gpu, surface, &camera, style)?,
            error: data_address(&render_png(&gpu, &painted, &camera, SIZE, Samples::Four)?)?,
            scale,
        })))
    }
}

fn mesh_as_read(
    gpu: &Gpu,
    source: &MeshSource,
    surface: &Surface,
    camera: &Camera,
    style: Style,
) -> Result<String> {
    let frame = Frame::of(&surface.form().placement);
    let positions: Vec<[f32; 3]> =
        source.mesh.positions.iter().map(|&p| frame.place_model(p).as_vec3().to_array()).collect();
    let scene = Scene { positions: &positions, triangles: &source.mesh.faces, style, ..Scene::default() };
    data_address(&render_png(gpu, &scene, camera, SIZE, Samples::Four)?)
}

fn base_mesh(gpu: &Gpu, surface: &Surface, camera: &Camera, style: Style) -> Result<String> {
    let base = ShownVertices::new(surface, Level::BASE);
    let hierarchy = surface.hierarchy();
    let edges = LineStyle { color: [30, 24, 22, 220], width: 1.4, hidden: 0.0 };
    let scene = Scene {
        positions: base.positions(),
        normals: base.normals(),
        triangles: &hierarchy.triangles(Level::BASE),
        edges: &hierarchy.edges(Level::BASE),
        style: Style { shading: Shading::Flat, edges, ..style },
        ..Scene::default()
    };
    data_address(&render_png(gpu, &scene, camera, SIZE, Samples::Four)?)
}

/// A PNG as an address that holds it.
fn data_address(picture: &RgbaImage) -> Result<String> {
    let rgb: Vec<u8> = picture.pixels().flat_map(|p| [p.0[0], p.0[1], p.0[2]]).collect();
    let mut png = Vec::new();
    let encoder = PngEncoder::new_with_quality(&mut png, CompressionType::Best, FilterType::Adaptive);
    encoder.write_image(&rgb, picture.width(), picture.height(), image::ExtendedColorType::Rgb8)?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(&png)))
}
