//! Pictures of a surface, on the window and without one.
//!
//! Plain arrays come in (positions, normals, tints, indices), pictures come out. This module knows `wgpu` and
//! nothing of panels, tools, sessions or hierarchies; one file, `viewport_callback`, knows egui.
//!
//! **Guarantees**
//! - A local change uploads the changed run and nothing else. A frame in which nothing changed uploads only the
//!   uniforms, and if those are the same too it draws nothing: the last picture stays.
//! - The same arrays, camera and style give the same bytes on the same adapter and driver.
//! - Depth is reversed and has no far plane, so neither very near nor very far scenes flicker.
//!
//! **Non-guarantees**
//! - Two drivers need not agree to the last bit; nothing drawn here reaches the document.
//! - Positions are `f32`. A model that lies far from the origin must be handed over relative to its centre.
//! - Translucent faces are blended in two layers (back, then front), not sorted face by face.
//!
//! **How a frame is made** ([`SurfaceRenderer::draw`]): surface → background where nothing was hit → ghost → its
//! edges → level edges → lines → handles, into an offscreen colour and depth target that is resolved when
//! multisampled. The window blits that picture ([`Viewport`]); [`render_png`] reads it back.

mod camera;
mod gpu;
mod gpu_buffer;
mod matcap;
mod mesh_buffers;
mod normals;
mod picture;
mod pipelines;
mod style;
mod surface_renderer;
mod target;
mod uniforms;
mod view;
mod viewport_callback;

#[cfg(test)]
mod tests;

pub use camera::{BoundingSphere, Camera, Ray};
pub use gpu::{Gpu, GpuError, device_descriptor};
pub use normals::vertex_normals;
pub use picture::{GhostMesh, Scene, grid, render_png};
pub use style::{Background, GhostStyle, Handle, HandleState, Line, LineStyle, Samples, Shading, Style};
pub use surface_renderer::SurfaceRenderer;
pub use view::{View, ViewParseError};
pub use viewport_callback::Viewport;
