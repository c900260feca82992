//! The picture itself: colour and depth off screen, resolved when multisampled, and read back to memory.

use image::RgbaImage;

use super::gpu::{Gpu, GpuError};

/// Holds sRGB-encoded colours as they are: shaders mix and blend them encoded, as egui does. Without a GPU,
/// converting to linear light and back for every fragment would cost more than shading it.
pub(super) const COLOR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;
/// Floating point, without which reversed depth would gain nothing.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// Colour and depth of one size and sample count.
pub(super) struct Target {
    size: [u32; 2],
    resolved: wgpu::Texture,
    resolved_view: wgpu::TextureView,
    multisampled: Option<wgpu::TextureView>,
    depth: wgpu::TextureView,
}

impl Target {
    /// Allocates a picture of `size` pixels; `samples` is 1 or 4.
    pub(super) fn new(gpu: &Gpu, size: [u32; 2], samples: u32) -> Result<Self, GpuError> {
        let limit = gpu.device.limits().max_texture_dimension_2d;
        let [width, height] = size;
        if size.iter().any(|side| !(1..=limit).contains(side)) {
            return Err(GpuError::PictureSize { width, height, limit });
        }
        let texture = |label, format, sample_count, usage| {
            gpu.device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage,
                view_formats: &[],
            })
        };
        let attachment = wgpu::TextureUsages::RENDER_ATTACHMENT;
        let readable = attachment | wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC;
        let resolved = texture("picture", COLOR_FORMAT, 1, readable);
        let view = |texture: wgpu::Texture| texture.create_view(&Default::default());
        Ok(Self {
            size,
            resolved_view: resolved.create_view(&Default::default()),
            resolved,
            multisampled: (samples > 1)
                .then(|| view(texture("picture, multisampled", COLOR_FORMAT, samples, attachment))),
            depth: view(texture("depth", DEPTH_FORMAT, samples, attachment)),
        })
    }

    /// Width and height in pixels.
    pub(super) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The finished picture, to sample from.
    pub(super) fn view(&self) -> &wgpu::TextureView {
        &self.resolved_view
    }

    /// Begins a pass that replaces the picture.
    pub(super) fn begin<'a>(&self, encoder: &'a mut wgpu::CommandEncoder) -> wgpu::RenderPass<'a> {
        let (view, resolve_target, store) = match &self.multisampled {
            Some(multisampled) => (multisampled, Some(&self.resolved_view), wgpu::StoreOp::Discard),
            None => (&self.resolved_view, None, wgpu::StoreOp::Store),
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("picture"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth,
                // Reversed depth: nothing is farther than 0.
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }

    /// Copies the picture into memory and waits for it.
    pub(super) fn read(&self, gpu: &Gpu) -> Result<RgbaImage, GpuError> {
        let [width, height] = self.size;
        let row = width as usize * 4;
        let pitch = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize);
        let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("picture read back"),
            size: pitch as u64 * u64::from(height),
            usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.copy_texture_to_buffer(
            self.resolved.as_image_copy(),
            wgpu::TexelCopyBufferInfo {
                buffer: &buffer,
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(pitch as u32),
                    rows_per_image: None,
                },
            },
            self.resolved.size(),
        );
        gpu.queue.submit([encoder.finish()]);

        let failed = |error: &dyn std::fmt::Display| GpuError::ReadBack(error.to_string());
        let (sender, receiver) = std::sync::mpsc::channel();
        buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            // The receiver lives until the answer is in; were it gone, nobody would want it.
            let _ = sender.send(result);
        });
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|e| failed(&e))?;
        receiver.recv().map_err(|e| failed(&e))?.map_err(|e| failed(&e))?;
        let mapped = buffer.get_mapped_range(..).map_err(|e| failed(&e))?;
        let mut pixels = Vec::with_capacity(row * height as usize);
        for line in mapped.chunks_exact(pitch) {
            pixels.extend_from_slice(&line[..row]);
        }
        RgbaImage::from_raw(width, height, pixels).ok_or_else(|| failed(&"too few bytes"))
    }
}
