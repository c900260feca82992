//! The picture inside the window: egui asks for it, the renderer draws it, egui's pass blits it.
//!
//! The only file here that knows egui. The picture has its own colour and depth, so the window needs neither a
//! depth buffer nor multisampling: leave both at zero in eframe's options, or the blit will not fit its pass.

use std::sync::{Arc, OnceLock};

use egui::mutex::{Mutex, MutexGuard};
use egui_wgpu::CallbackTrait;

use super::camera::Camera;
use super::gpu::{Gpu, GpuError};
use super::style::{Samples, Style};
use super::surface_renderer::SurfaceRenderer;

/// A renderer shared between the program, which writes to it, and the window, which draws it.
///
/// It holds one picture: place it once in a window.
pub struct Viewport {
    shared: Arc<Shared>,
}

struct Shared {
    renderer: Mutex<SurfaceRenderer>,
    /// Why the last picture could not be drawn.
    failure: Mutex<Option<GpuError>>,
    blit: Blit,
}

/// The program that lays a picture on the window.
struct Blit {
    pipeline: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
}

impl Viewport {
    /// Makes a renderer on the window's device.
    ///
    /// # Errors
    /// [`GpuError::TooOld`].
    pub fn new(state: &egui_wgpu::RenderState, samples: Samples) -> Result<Self, GpuError> {
        let gpu = Gpu::from_window(state)?;
        let shared = Shared {
            renderer: Mutex::new(SurfaceRenderer::new(&gpu, samples)),
            failure: Mutex::new(None),
            blit: Blit::new(&gpu, state.target_format),
        };
        Ok(Self { shared: Arc::new(shared) })
    }

    /// The renderer, to write to. Let go of it before the frame ends.
    pub fn renderer(&self) -> MutexGuard<'_, SurfaceRenderer> {
        self.shared.renderer.lock()
    }

    /// What to add to a painter so that the picture fills `rect` (in points) of this frame. `style.scale` is
    /// replaced by the window's.
    pub fn shape(&self, rect: egui::Rect, camera: &Camera, style: &Style) -> egui::Shape {
        let callback = ViewportCallback {
            shared: Arc::clone(&self.shared),
            rect,
            camera: *camera,
            style: *style,
            bound: OnceLock::new(),
        };
        egui::Shape::Callback(egui_wgpu::Callback::new_paint_callback(rect, callback))
    }

    /// Why the last picture could not be drawn, once.
    pub fn take_failure(&self) -> Option<GpuError> {
        self.shared.failure.lock().take()
    }
}

/// One frame's request.
struct ViewportCallback {
    shared: Arc<Shared>,
    rect: egui::Rect,
    camera: Camera,
    style: Style,
    /// The picture to lay on the window, once it is drawn.
    bound: OnceLock<wgpu::BindGroup>,
}

impl CallbackTrait for ViewportCallback {
    fn prepare(
        &self,
        device: &wgpu::Device,
        _queue: &wgpu::Queue,
        screen: &egui_wgpu::ScreenDescriptor,
        _encoder: &mut wgpu::CommandEncoder,
        _resources: &mut egui_wgpu::CallbackResources,
    ) -> Vec<wgpu::CommandBuffer> {
        // The very pixels that egui will give the blit, so that it neither shrinks nor stretches.
        let pixels = egui::epaint::ViewportInPixels::from_points(
            &self.rect,
            screen.pixels_per_point,
            screen.size_in_pixels,
        );
        let (Ok(width @ 1..), Ok(height @ 1..)) =
            (u32::try_from(pixels.width_px), u32::try_from(pixels.height_px))
        else {
            return Vec::new();
        };
        let style = Style { scale: screen.pixels_per_point, ..self.style };
        let mut renderer = self.shared.renderer.lock();
        match renderer.draw(&self.camera, &style, [width, height]) {
            Ok(_) => {
                if let Some(picture) = renderer.picture() {
                    self.bound.get_or_init(|| self.shared.blit.bind(device, picture));
                }
            }
            Err(failure) => *self.shared.failure.lock() = Some(failure),
        }
        Vec::new()
    }

    fn paint(
        &self,
        _info: egui::PaintCallbackInfo,
        pass: &mut wgpu::RenderPass<'static>,
        _resources: &egui_wgpu::CallbackResources,
    ) {
        if let Some(picture) = self.bound.get() {
            pass.set_pipeline(&self.shared.blit.pipeline);
            pass.set_bind_group(0, picture, &[]);
            pass.draw(0..3, 0..1);
        }
    }
}

impl Blit {
    fn new(gpu: &Gpu, window_format: wgpu::TextureFormat) -> Self {
        let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("blit"),
            source: wgpu::ShaderSource::Wgsl(include_str!("shaders/blit.wgsl").into()),
        });
        let decode = f64::from(u8::from(window_format.is_srgb()));
        let pipeline = gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("blit"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("vertex"),
                compilation_options: Default::default(),
                buffers: &[],
            },
            primitive: Default::default(),
            depth_stencil: None,
            multisample: Default::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("fragment"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &[("decode", decode)],
                    ..Default::default()
                },
                targets: &[Some(window_format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor::default());
        Self { pipeline, sampler }
    }

    fn bind(&self, device: &wgpu::Device, picture: &wgpu::TextureView) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("blit"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(picture) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&self.sampler) },
            ],
        })
    }
}
