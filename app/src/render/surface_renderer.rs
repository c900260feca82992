//! The surface and its overlays on the GPU, and the drawing of a frame.

use image::RgbaImage;

use super::camera::Camera;
use super::gpu::{Gpu, GpuError};
use super::gpu_buffer::GpuBuffer;
use super::mesh_buffers::MeshBuffers;
use super::normals::packed;
use super::picture::{GhostMesh, Scene};
use super::pipelines::{Overlay, Pipelines};
use super::style::{Handle, Line, Samples, Style};
use super::target::Target;
use super::uniforms::FrameUniforms;

/// Owns the GPU's copy of a surface and draws it.
///
/// Everything is kept until it is replaced. Vertices are shared by triangles and level edges, so moving a run of
/// vertices ([`Self::write_vertices`]) moves both. Arrays grow as they are written; what was never written is
/// zero, which for a tint means none.
///
/// Triangles or edges that name a vertex not yet written are not drawn, so the order of calls does not matter.
pub struct SurfaceRenderer {
    gpu: Gpu,
    samples: Samples,
    pipelines: Pipelines,
    uniforms: wgpu::Buffer,
    target: Option<Target>,
    surface: MeshBuffers,
    normals: GpuBuffer,
    tints: GpuBuffer,
    ghost: MeshBuffers,
    lines: GpuBuffer,
    handles: GpuBuffer,
    /// What the picture in the target was drawn with, if the arrays are still the same.
    drawn: Option<(FrameUniforms, Style)>,
}

/// [`Handle`] as `handles.wgsl` reads it.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct PackedHandle {
    position: [f32; 3],
    radius: f32,
    fill: [u8; 4],
    rim: [u8; 4],
    state: u32,
}

impl From<&Handle> for PackedHandle {
    fn from(handle: &Handle) -> Self {
        let &Handle { position, radius, fill, rim, state } = handle;
        Self { position, radius, fill, rim, state: state as u32 }
    }
}

impl SurfaceRenderer {
    /// A renderer that holds nothing yet. Compiles the shaders: some tens of milliseconds.
    pub fn new(gpu: &Gpu, samples: Samples) -> Self {
        let uniforms = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("frame"),
            size: size_of::<FrameUniforms>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let pipelines = Pipelines::new(gpu, samples.count(), &uniforms);
        let vertex = wgpu::BufferUsages::VERTEX;
        Self {
            surface: MeshBuffers::new(gpu, &pipelines.positions_layout),
            normals: GpuBuffer::new(gpu, "normals", 4, vertex),
            tints: GpuBuffer::new(gpu, "tints", 4, vertex),
            ghost: MeshBuffers::new(gpu, &pipelines.positions_layout),
            lines: GpuBuffer::new(gpu, "lines", size_of::<Line>() as u64, vertex),
            handles: GpuBuffer::new(gpu, "handles", size_of::<PackedHandle>() as u64, vertex),
            gpu: gpu.clone(),
            samples,
            pipelines,
            uniforms,
            target: None,
            drawn: None,
        }
    }

    /// Replaces triangles and level edges. Cost: both arrays.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], as every method here that takes an array.
    pub fn set_topology(&mut self, triangles: &[[u32; 3]], edges: &[[u32; 2]]) -> Result<(), GpuError> {
        self.set_triangles(triangles)?;
        self.set_edges(edges)
    }

    /// Replaces the triangles: vertex indices, counter-clockwise seen from outside.
    pub fn set_triangles(&mut self, triangles: &[[u32; 3]]) -> Result<(), GpuError> {
        self.drawn = None;
        self.surface.set_triangles(&self.gpu, triangles)
    }

    /// Replaces the level edges: pairs of vertex indices, each drawn as a straight line.
    pub fn set_edges(&mut self, edges: &[[u32; 2]]) -> Result<(), GpuError> {
        self.drawn = None;
        self.surface.set_edges(&self.gpu, edges)
    }

    /// Replaces all vertices, and forgets all tints. Cost: both arrays.
    ///
    /// # Panics
    /// If the two arrays differ in length; so does [`Self::write_vertices`].
    pub fn set_vertices(&mut self, positions: &[[f32; 3]], normals: &[[f32; 3]]) -> Result<(), GpuError> {
        self.surface.positions.truncate(0);
        self.normals.truncate(0);
        self.tints.zero(&self.gpu);
        self.write_vertices(0, positions, normals)
    }

    /// Writes the vertices `start..start + positions.len()`; normals need not have unit length. Cost: the run.
    pub fn write_vertices(
        &mut self,
        start: u32,
        positions: &[[f32; 3]],
        normals: &[[f32; 3]],
    ) -> Result<(), GpuError> {
        assert_eq!(positions.len(), normals.len(), "each vertex has one position and one normal");
        self.drawn = None;
        let packed: Vec<[i16; 2]> = normals.iter().copied().map(packed).collect();
        self.surface.write_positions(&self.gpu, &self.pipelines.positions_layout, start, positions)?;
        self.normals.write(&self.gpu, start, &packed)?;
        self.tints.extend_to(&self.gpu, self.surface.positions.len())
    }

    /// Writes the tints of the vertices `start..start + tints.len()`: red, green, blue, and strength, from 0 (the
    /// material shows) to 255 (the tint does, lit as the material is). Cost: the run.
    pub fn write_tints(&mut self, start: u32, tints: &[[u8; 4]]) -> Result<(), GpuError> {
        self.drawn = None;
        self.tints.write(&self.gpu, start, tints)?;
        Ok(())
    }

    /// Takes all tints away, on the GPU: nothing is uploaded.
    pub fn clear_tints(&mut self) {
        self.drawn = None;
        self.tints.zero(&self.gpu);
    }

    /// Replaces the free lines.
    pub fn set_lines(&mut self, lines: &[Line]) -> Result<(), GpuError> {
        self.drawn = None;
        self.lines.replace(&self.gpu, lines)
    }

    /// Replaces the handles.
    pub fn set_handles(&mut self, handles: &[Handle]) -> Result<(), GpuError> {
        self.handles.truncate(0);
        self.write_handles(0, handles)
    }

    /// Writes the handles `start..start + handles.len()`, e.g. the one under the cursor. Cost: the run.
    pub fn write_handles(&mut self, start: u32, handles: &[Handle]) -> Result<(), GpuError> {
        self.drawn = None;
        let packed: Vec<PackedHandle> = handles.iter().map(PackedHandle::from).collect();
        self.handles.write(&self.gpu, start, &packed)?;
        Ok(())
    }

    /// Replaces the ghost; [`GhostMesh::default`] takes it away.
    pub fn set_ghost(&mut self, ghost: GhostMesh<'_>) -> Result<(), GpuError> {
        self.ghost.positions.truncate(0);
        self.write_ghost_vertices(0, ghost.positions)?;
        self.ghost.set_triangles(&self.gpu, ghost.triangles)?;
        self.ghost.set_edges(&self.gpu, ghost.edges)
    }

    /// Writes the ghost's vertices `start..start + positions.len()`. Cost: the run.
    pub fn write_ghost_vertices(&mut self, start: u32, positions: &[[f32; 3]]) -> Result<(), GpuError> {
        self.drawn = None;
        self.ghost.write_positions(&self.gpu, &self.pipelines.positions_layout, start, positions)
    }

    /// Replaces everything by what a scene holds; its style is for [`Self::draw`].
    pub fn load(&mut self, scene: &Scene<'_>) -> Result<(), GpuError> {
        self.set_vertices(scene.positions, &scene.normals())?;
        self.write_tints(0, scene.tints)?;
        self.set_topology(scene.triangles, scene.edges)?;
        self.set_lines(scene.lines)?;
        self.set_handles(scene.handles)?;
        self.set_ghost(scene.ghost)
    }

    /// Draws a picture of `size` pixels and says whether there was anything to do: if neither the arrays nor
    /// camera, style and size have changed, the last picture stays. Uploads the uniforms only.
    ///
    /// # Errors
    /// [`GpuError::PictureSize`].
    pub fn draw(&mut self, camera: &Camera, style: &Style, size: [u32; 2]) -> Result<bool, GpuError> {
        if self.target.as_ref().is_none_or(|target| target.size() != size) {
            self.drawn = None;
            self.target = Some(Target::new(&self.gpu, size, self.samples.count())?);
        }
        let uniforms = FrameUniforms::new(camera, style, size);
        if self.drawn == Some((uniforms, *style)) {
            return Ok(false);
        }
        self.gpu.queue.write_buffer(&self.uniforms, 0, bytemuck::bytes_of(&uniforms));
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        if let Some(target) = &self.target {
            self.record(&mut target.begin(&mut encoder), style);
        }
        self.gpu.queue.submit([encoder.finish()]);
        self.drawn = Some((uniforms, *style));
        Ok(true)
    }

    /// The last picture drawn, copied to memory. Waits for the GPU.
    ///
    /// # Errors
    /// [`GpuError::ReadBack`], also if nothing was ever drawn.
    pub fn read(&self) -> Result<RgbaImage, GpuError> {
        match &self.target {
            Some(target) => target.read(&self.gpu),
            None => Err(GpuError::ReadBack("nothing has been drawn yet".to_owned())),
        }
    }

    /// The last picture drawn, to sample from.
    pub(super) fn picture(&self) -> Option<&wgpu::TextureView> {
        self.target.as_ref().map(Target::view)
    }

    /// Solid things first, then the background where none was, then what is translucent, from the surface
    /// outwards.
    fn record(&self, pass: &mut wgpu::RenderPass<'_>, style: &Style) {
        let programs = &self.pipelines;
        pass.set_bind_group(0, &programs.frame, &[]);
        if self.surface.has_triangles() {
            pass.set_pipeline(programs.surface(style));
            pass.set_vertex_buffer(1, self.normals.slice());
            pass.set_vertex_buffer(2, self.tints.slice());
            self.surface.draw_triangles(pass);
        }
        pass.set_pipeline(&programs.background);
        pass.draw(0..3, 0..1);
        if self.ghost.has_triangles() {
            for side in &programs.ghost {
                pass.set_pipeline(side);
                self.ghost.draw_triangles(pass);
            }
        }
        each_half(pass, &programs.ghost_edges, style.ghost.edges.hidden, |pass| self.ghost.draw_edges(pass));
        each_half(pass, &programs.edges, style.edges.hidden, |pass| self.surface.draw_edges(pass));
        each_half(pass, &programs.lines, style.lines_hidden, |pass| draw_quads(pass, &self.lines));
        each_half(pass, &programs.handles, style.handles_hidden, |pass| draw_quads(pass, &self.handles));
    }
}

/// Draws what is hidden, if it is to show at all, then what is seen.
fn each_half(
    pass: &mut wgpu::RenderPass<'_>,
    programs: &Overlay,
    hidden: f32,
    draw: impl Fn(&mut wgpu::RenderPass<'_>),
) {
    if hidden > 0.0 {
        pass.set_pipeline(&programs.behind);
        draw(pass);
    }
    pass.set_pipeline(&programs.seen);
    draw(pass);
}

/// One quad per element.
fn draw_quads(pass: &mut wgpu::RenderPass<'_>, instances: &GpuBuffer) {
    if instances.len() > 0 {
        pass.set_vertex_buffer(0, instances.slice());
        pass.draw(0..4, 0..instances.len());
    }
}
