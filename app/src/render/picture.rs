//! From a scene to an image in memory, in one call.

use std::borrow::Cow;

use image::{Rgba, RgbaImage};

use super::camera::Camera;
use super::gpu::{Gpu, GpuError};
use super::normals::vertex_normals;
use super::style::{Handle, Line, Samples, Style};
use super::surface_renderer::SurfaceRenderer;

/// A second mesh, drawn translucent over the surface: the control polyhedron.
#[derive(Clone, Copy, Debug, Default)]
pub struct GhostMesh<'a> {
    /// Its vertices.
    pub positions: &'a [[f32; 3]],
    /// Its faces; either orientation, both sides show.
    pub triangles: &'a [[u32; 3]],
    /// The edges to draw, as pairs of its vertices.
    pub edges: &'a [[u32; 2]],
}

/// All that a picture shows, as plain arrays.
#[derive(Clone, Copy, Debug, Default)]
pub struct Scene<'a> {
    /// Vertices of the surface.
    pub positions: &'a [[f32; 3]],
    /// One normal per vertex; if empty, they are made from the triangles.
    pub normals: &'a [[f32; 3]],
    /// Tint and strength per vertex, from the first on; missing ones are no tint.
    pub tints: &'a [[u8; 4]],
    /// Faces, counter-clockwise seen from outside.
    pub triangles: &'a [[u32; 3]],
    /// Level edges, as pairs of vertices.
    pub edges: &'a [[u32; 2]],
    /// Free lines.
    pub lines: &'a [Line],
    /// Handles.
    pub handles: &'a [Handle],
    /// The control polyhedron, or nothing.
    pub ghost: GhostMesh<'a>,
    /// The look of it all.
    pub style: Style,
}

impl Scene<'_> {
    /// The normals given, or those made from the triangles.
    pub(super) fn normals(&self) -> Cow<'_, [[f32; 3]]> {
        if self.normals.is_empty() {
            Cow::Owned(vertex_normals(self.positions, self.triangles))
        } else {
            Cow::Borrowed(self.normals)
        }
    }
}

/// Draws one picture of `size` pixels and reads it back; opaque, sRGB. For several pictures of one scene, keep a
/// [`SurfaceRenderer`] instead.
///
/// # Errors
/// Any [`GpuError`] but those of opening an adapter.
///
/// # Panics
/// If there are normals, but not one per vertex, or a triangle names a vertex that is not there and there are no
/// normals.
pub fn render_png(
    gpu: &Gpu,
    scene: &Scene<'_>,
    camera: &Camera,
    size: [u32; 2],
    samples: Samples,
) -> Result<RgbaImage, GpuError> {
    let mut renderer = SurfaceRenderer::new(gpu, samples);
    renderer.load(scene)?;
    renderer.draw(camera, &scene.style, size)?;
    renderer.read()
}

/// Lays pictures out row by row in `columns` columns, `gap` pixels apart and from the border, each centred in a
/// cell as large as the largest picture. No pictures give an image of one pixel.
///
/// # Panics
/// If `columns` is 0.
pub fn grid(pictures: &[RgbaImage], columns: u32, gap: u32, background: [u8; 4]) -> RgbaImage {
    assert!(columns > 0, "a grid has at least one column");
    let largest = |side: fn(&RgbaImage) -> u32| pictures.iter().map(side).max().unwrap_or(0);
    let (cell_width, cell_height) = (largest(RgbaImage::width), largest(RgbaImage::height));
    let count = pictures.len() as u32;
    let extent = |cells: u32, cell: u32| (cells * (cell + gap) + gap).max(1);
    let width = extent(columns.min(count), cell_width);
    let height = extent(count.div_ceil(columns), cell_height);
    let mut sheet = RgbaImage::from_pixel(width, height, Rgba(background));
    for (index, picture) in (0..).zip(pictures) {
        let (column, row) = (index % columns, index / columns);
        let x = gap + column * (cell_width + gap) + (cell_width - picture.width()) / 2;
        let y = gap + row * (cell_height + gap) + (cell_height - picture.height()) / 2;
        image::imageops::replace(&mut sheet, picture, i64::from(x), i64::from(y));
    }
    sheet
}
