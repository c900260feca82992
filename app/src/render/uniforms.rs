//! What a frame needs besides its buffers: camera and style as the shaders read them (`Frame` in `frame.wgsl`).

use glam::Mat4;

use super::camera::Camera;
use super::style::{LineStyle, Shading, Style};

/// Mirrors `Frame` in `frame.wgsl`, field for field. Colours are sRGB-encoded, 0 to 1, with straight opacity.
#[derive(Clone, Copy, Debug, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct FrameUniforms {
    view_projection: [[f32; 4]; 4],
    view: [[f32; 4]; 4],
    /// Width, height, and their inverses.
    picture: [f32; 4],
    /// Near plane; tan of half the vertical angle of view times 2 / height, which is the relative change of
    /// depth worth one pixel; cavity strength; matcap layer.
    lens: [f32; 4],
    background_top: [f32; 4],
    background_bottom: [f32; 4],
    edge_color: [f32; 4],
    ghost_fill: [f32; 4],
    ghost_edge_color: [f32; 4],
    /// Width of edges in pixels, their hidden factor; width of ghost edges, theirs.
    edges: [f32; 4],
    /// Hidden factors of lines and handles, pixels per point.
    hidden: [f32; 4],
}

impl FrameUniforms {
    /// For a picture of `size` pixels.
    pub(super) fn new(camera: &Camera, style: &Style, size: [u32; 2]) -> Self {
        let [width, height] = size.map(|side| side as f32);
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let pixel = 2.0 * (camera.vertical_fov * 0.5).tan() / f64::from(size[1]);
        let [top, bottom] = style.background.gradient();
        let LineStyle { width: edge_width, hidden: edge_hidden, .. } = style.edges;
        let ghost = style.ghost;
        Self {
            view_projection: matrix(camera.view_projection(aspect).as_mat4()),
            view: matrix(camera.view().as_mat4()),
            picture: [width, height, 1.0 / width, 1.0 / height],
            lens: [camera.near() as f32, pixel as f32, style.cavity, matcap_layer(style.shading)],
            background_top: unit_rgba(top),
            background_bottom: unit_rgba(bottom),
            edge_color: unit_rgba(style.edges.color),
            ghost_fill: unit_rgba(ghost.fill),
            ghost_edge_color: unit_rgba(ghost.edges.color),
            edges: [
                edge_width * style.scale,
                edge_hidden,
                ghost.edges.width * style.scale,
                ghost.edges.hidden,
            ],
            hidden: [style.lines_hidden, style.handles_hidden, style.scale, 0.0],
        }
    }
}

/// The layer of the matcap texture that a shading uses, if any.
fn matcap_layer(shading: Shading) -> f32 {
    match shading {
        Shading::Clay | Shading::Flat | Shading::Normals => 0.0,
        Shading::Porcelain => 1.0,
    }
}

fn unit_rgba(color: [u8; 4]) -> [f32; 4] {
    color.map(|channel| f32::from(channel) / 255.0)
}

fn matrix(m: Mat4) -> [[f32; 4]; 4] {
    m.to_cols_array_2d()
}
