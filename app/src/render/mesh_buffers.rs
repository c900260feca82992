//! Positions, triangles and edges of one mesh on the GPU: the surface's, or the ghost's.

use super::gpu::{Gpu, GpuError};
use super::gpu_buffer::GpuBuffer;

/// A mesh on the GPU.
pub(super) struct MeshBuffers {
    /// Three floats per vertex, read as a vertex buffer by triangles and as storage by edges.
    pub(super) positions: GpuBuffer,
    triangles: GpuBuffer,
    edges: GpuBuffer,
    /// Vertices that the triangles, and the edges, need: one more than the largest index.
    triangles_need: u32,
    edges_need: u32,
    pulled: wgpu::BindGroup,
}

impl MeshBuffers {
    /// A mesh of nothing.
    pub(super) fn new(gpu: &Gpu, layout: &wgpu::BindGroupLayout) -> Self {
        let both = wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::STORAGE;
        let positions = GpuBuffer::new(gpu, "positions", 12, both);
        Self {
            pulled: bind(gpu, layout, &positions),
            positions,
            triangles: GpuBuffer::new(gpu, "triangles", 12, wgpu::BufferUsages::INDEX),
            edges: GpuBuffer::new(gpu, "edges", 8, wgpu::BufferUsages::VERTEX),
            triangles_need: 0,
            edges_need: 0,
        }
    }

    /// Writes a run of positions.
    pub(super) fn write_positions(
        &mut self,
        gpu: &Gpu,
        layout: &wgpu::BindGroupLayout,
        start: u32,
        run: &[[f32; 3]],
    ) -> Result<(), GpuError> {
        if self.positions.write(gpu, start, run)? {
            self.pulled = bind(gpu, layout, &self.positions);
        }
        Ok(())
    }

    /// Replaces the triangles.
    pub(super) fn set_triangles(&mut self, gpu: &Gpu, triangles: &[[u32; 3]]) -> Result<(), GpuError> {
        self.triangles_need = needed(triangles.as_flattened());
        self.triangles.replace(gpu, triangles)
    }

    /// Replaces the edges.
    pub(super) fn set_edges(&mut self, gpu: &Gpu, edges: &[[u32; 2]]) -> Result<(), GpuError> {
        self.edges_need = needed(edges.as_flattened());
        self.edges.replace(gpu, edges)
    }

    /// Whether there are triangles, and all their vertices.
    pub(super) fn has_triangles(&self) -> bool {
        self.triangles.len() > 0 && self.triangles_need <= self.positions.len()
    }

    /// Draws the triangles, if [`Self::has_triangles`], with positions in slot 0.
    pub(super) fn draw_triangles(&self, pass: &mut wgpu::RenderPass<'_>) {
        pass.set_vertex_buffer(0, self.positions.slice());
        pass.set_index_buffer(self.triangles.slice(), wgpu::IndexFormat::Uint32);
        pass.draw_indexed(0..self.triangles.len() * 3, 0, 0..1);
    }

    /// Draws one quad per edge, if there are edges and all their vertices.
    pub(super) fn draw_edges(&self, pass: &mut wgpu::RenderPass<'_>) {
        if self.edges.len() > 0 && self.edges_need <= self.positions.len() {
            pass.set_bind_group(1, &self.pulled, &[]);
            pass.set_vertex_buffer(0, self.edges.slice());
            pass.draw(0..4, 0..self.edges.len());
        }
    }
}

/// How many vertices there must be for these indices.
fn needed(indices: &[u32]) -> u32 {
    indices.iter().max().map_or(0, |largest| largest.saturating_add(1))
}

fn bind(gpu: &Gpu, layout: &wgpu::BindGroupLayout, positions: &GpuBuffer) -> wgpu::BindGroup {
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("positions"),
        layout,
        entries: &[wgpu::BindGroupEntry { binding: 0, resource: positions.buffer().as_entire_binding() }],
    })
}
