//! The GPU programs that draw a frame, made once per renderer.

use super::gpu::Gpu;
use super::matcap;
use super::style::{Shading, Style};
use super::target::{COLOR_FORMAT, DEPTH_FORMAT};
use super::uniforms::FrameUniforms;

/// A program for what can be seen, and one for what lies behind the surface.
pub(super) struct Overlay {
    pub(super) seen: wgpu::RenderPipeline,
    pub(super) behind: wgpu::RenderPipeline,
}

/// One way of shading the surface: both sides of it, or its outside only.
struct Sides {
    both: wgpu::RenderPipeline,
    outside: wgpu::RenderPipeline,
}

/// Every program of the picture, and the bindings they share.
pub(super) struct Pipelines {
    smooth: Sides,
    flat: Sides,
    normals: Sides,
    pub(super) background: wgpu::RenderPipeline,
    /// The ghost's far sides, then its near sides.
    pub(super) ghost: [wgpu::RenderPipeline; 2],
    pub(super) edges: Overlay,
    pub(super) ghost_edges: Overlay,
    pub(super) lines: Overlay,
    pub(super) handles: Overlay,
    /// The uniforms and the matcaps: group 0 of all programs.
    pub(super) frame: wgpu::BindGroup,
    /// One storage buffer of positions: group 1 of the edges' programs.
    pub(super) positions_layout: wgpu::BindGroupLayout,
}

/// What sets one program apart from the others.
struct Recipe<'a> {
    label: &'a str,
    module: &'a wgpu::ShaderModule,
    entry: &'a str,
    layout: &'a wgpu::PipelineLayout,
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
    topology: wgpu::PrimitiveTopology,
    cull: Option<wgpu::Face>,
    /// Whether it covers what is behind it and writes depth.
    solid: bool,
    compare: wgpu::CompareFunction,
    constants: &'a [(&'a str, f64)],
}

impl Pipelines {
    /// Compiles all programs for pictures of `samples` samples, reading their uniforms from `uniforms`.
    pub(super) fn new(gpu: &Gpu, samples: u32, uniforms: &wgpu::Buffer) -> Self {
        let frame_layout = frame_layout(gpu);
        let positions_layout = positions_layout(gpu);
        let plain = pipeline_layout(gpu, &[Some(&frame_layout)]);
        let pulling = pipeline_layout(gpu, &[Some(&frame_layout), Some(&positions_layout)]);
        let surface = shader(gpu, "surface", include_str!("shaders/surface.wgsl"));
        let background = shader(gpu, "background", include_str!("shaders/background.wgsl"));
        let ghost = shader(gpu, "ghost", include_str!("shaders/ghost.wgsl"));
        let lines = shader(gpu, "lines", include_str!("shaders/lines.wgsl"));
        let handles = shader(gpu, "handles", include_str!("shaders/handles.wgsl"));

        let solid = |module, buffers, topology| Recipe {
            label: "solid",
            module,
            entry: "vertex",
            layout: &plain,
            buffers,
            topology,
            cull: None,
            solid: true,
            compare: wgpu::CompareFunction::GreaterEqual,
            constants: &[],
        };
        let make = |recipe: Recipe<'_>| pipeline(gpu, samples, &recipe);
        let shaded = |constants: &[(&str, f64)]| {
            let buffers = &[Some(POSITIONS), Some(NORMALS), Some(TINTS)];
            let side = |cull| {
                let recipe = solid(&surface, buffers, wgpu::PrimitiveTopology::TriangleList);
                make(Recipe { label: "surface", constants, cull, ..recipe })
            };
            Sides { both: side(None), outside: side(Some(wgpu::Face::Back)) }
        };
        let ghost_sides = [wgpu::Face::Front, wgpu::Face::Back].map(|hidden_side| {
            make(Recipe {
                label: "ghost",
                cull: Some(hidden_side),
                solid: false,
                ..solid(&ghost, &[Some(POSITIONS)], wgpu::PrimitiveTopology::TriangleList)
            })
        });
        let overlay = |label, module, entry, layout, buffers, ghost| {
            let half = |behind: bool, compare| {
                let constants: &[(&str, f64)] = match (entry, ghost) {
                    ("vertex", _) => &[("behind", f64::from(u8::from(behind)))],
                    (_, ghost) => {
                        &[("behind", f64::from(u8::from(behind))), ("ghost", f64::from(u8::from(ghost)))]
                    }
                };
                make(Recipe {
                    label,
                    entry,
                    layout,
                    solid: false,
                    compare,
                    constants,
                    ..solid(module, buffers, wgpu::PrimitiveTopology::TriangleStrip)
                })
            };
            Overlay {
                seen: half(false, wgpu::CompareFunction::GreaterEqual),
                behind: half(true, wgpu::CompareFunction::Less),
            }
        };
        Self {
            smooth: shaded(&[]),
            flat: shaded(&[("flat_faces", 1.0)]),
            normals: shaded(&[("show_normals", 1.0)]),
            background: make(solid(&background, &[], wgpu::PrimitiveTopology::TriangleList)),
            ghost: ghost_sides,
            edges: overlay("edges", &lines, "edge", &pulling, &[Some(EDGES)], false),
            ghost_edges: overlay("ghost edges", &lines, "edge", &pulling, &[Some(EDGES)], true),
            lines: overlay("lines", &lines, "line", &plain, &[Some(LINES)], false),
            handles: overlay("handles", &handles, "vertex", &plain, &[Some(HANDLES)], false),
            frame: frame_bindings(gpu, &frame_layout, uniforms),
            positions_layout,
        }
    }
}

impl Pipelines {
    /// The program that draws the surface in this style.
    pub(super) fn surface(&self, style: &Style) -> &wgpu::RenderPipeline {
        let sides = match style.shading {
            Shading::Clay | Shading::Porcelain => &self.smooth,
            Shading::Flat => &self.flat,
            Shading::Normals => &self.normals,
        };
        if style.two_sided { &sides.both } else { &sides.outside }
    }
}

const fn buffer_layout(
    stride: u64,
    step_mode: wgpu::VertexStepMode,
    attributes: &[wgpu::VertexAttribute],
) -> wgpu::VertexBufferLayout<'_> {
    wgpu::VertexBufferLayout { array_stride: stride, step_mode, attributes }
}

const POSITIONS: wgpu::VertexBufferLayout<'_> =
    buffer_layout(12, wgpu::VertexStepMode::Vertex, &wgpu::vertex_attr_array![0 => Float32x3]);
const NORMALS: wgpu::VertexBufferLayout<'_> =
    buffer_layout(4, wgpu::VertexStepMode::Vertex, &wgpu::vertex_attr_array![1 => Snorm16x2]);
const TINTS: wgpu::VertexBufferLayout<'_> =
    buffer_layout(4, wgpu::VertexStepMode::Vertex, &wgpu::vertex_attr_array![2 => Unorm8x4]);
const EDGES: wgpu::VertexBufferLayout<'_> =
    buffer_layout(8, wgpu::VertexStepMode::Instance, &wgpu::vertex_attr_array![0 => Uint32x2]);
/// [`super::style::Line`].
const LINES: wgpu::VertexBufferLayout<'_> = buffer_layout(
    32,
    wgpu::VertexStepMode::Instance,
    &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3, 2 => Unorm8x4, 3 => Float32],
);
/// `PackedHandle` in `surface_renderer.rs`.
const HANDLES: wgpu::VertexBufferLayout<'_> = buffer_layout(
    28,
    wgpu::VertexStepMode::Instance,
    &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32, 2 => Unorm8x4, 3 => Unorm8x4, 4 => Uint32],
);

fn shader(gpu: &Gpu, label: &str, source: &str) -> wgpu::ShaderModule {
    let source = format!("{}\n{source}", include_str!("shaders/frame.wgsl"));
    gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some(label),
        source: wgpu::ShaderSource::Wgsl(source.into()),
    })
}

fn pipeline_layout(gpu: &Gpu, groups: &[Option<&wgpu::BindGroupLayout>]) -> wgpu::PipelineLayout {
    gpu.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: None,
        bind_group_layouts: groups,
        immediate_size: 0,
    })
}

fn pipeline(gpu: &Gpu, samples: u32, recipe: &Recipe<'_>) -> wgpu::RenderPipeline {
    let compilation_options =
        wgpu::PipelineCompilationOptions { constants: recipe.constants, ..Default::default() };
    gpu.device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(recipe.label),
        layout: Some(recipe.layout),
        vertex: wgpu::VertexState {
            module: recipe.module,
            entry_point: Some(recipe.entry),
            compilation_options: compilation_options.clone(),
            buffers: recipe.buffers,
        },
        primitive: wgpu::PrimitiveState {
            topology: recipe.topology,
            cull_mode: recipe.cull,
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH_FORMAT,
            depth_write_enabled: Some(recipe.solid),
            depth_compare: Some(recipe.compare),
            stencil: Default::default(),
            bias: Default::default(),
        }),
        multisample: wgpu::MultisampleState { count: samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module: recipe.module,
            entry_point: Some("fragment"),
            compilation_options,
            targets: &[Some(wgpu::ColorTargetState {
                format: COLOR_FORMAT,
                blend: (!recipe.solid).then_some(wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING),
                write_mask: wgpu::ColorWrites::ALL,
            })],
        }),
        multiview_mask: None,
        cache: None,
    })
}

fn frame_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    let entry = |binding, visibility, ty| wgpu::BindGroupLayoutEntry { binding, visibility, ty, count: None };
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("frame"),
        entries: &[
            entry(
                0,
                wgpu::ShaderStages::VERTEX_FRAGMENT,
                wgpu::BindingType::Buffer {
                    ty: wgpu::BufferBindingType::Uniform,
                    has_dynamic_offset: false,
                    min_binding_size: std::num::NonZeroU64::new(size_of::<FrameUniforms>() as u64),
                },
            ),
            entry(
                1,
                wgpu::ShaderStages::FRAGMENT,
                wgpu::BindingType::Texture {
                    sample_type: wgpu::TextureSampleType::Float { filterable: true },
                    view_dimension: wgpu::TextureViewDimension::D2Array,
                    multisampled: false,
                },
            ),
            entry(
                2,
                wgpu::ShaderStages::FRAGMENT,
                wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
            ),
        ],
    })
}

fn positions_layout(gpu: &Gpu) -> wgpu::BindGroupLayout {
    gpu.device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("positions"),
        entries: &[wgpu::BindGroupLayoutEntry {
            binding: 0,
            visibility: wgpu::ShaderStages::VERTEX,
            ty: wgpu::BindingType::Buffer {
                ty: wgpu::BufferBindingType::Storage { read_only: true },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        }],
    })
}

fn frame_bindings(gpu: &Gpu, layout: &wgpu::BindGroupLayout, uniforms: &wgpu::Buffer) -> wgpu::BindGroup {
    let matcaps = matcap::texture(gpu).create_view(&wgpu::TextureViewDescriptor {
        dimension: Some(wgpu::TextureViewDimension::D2Array),
        ..Default::default()
    });
    let sampler = gpu.device.create_sampler(&wgpu::SamplerDescriptor {
        label: Some("matcaps"),
        mag_filter: wgpu::FilterMode::Linear,
        min_filter: wgpu::FilterMode::Linear,
        ..Default::default()
    });
    let resources = [
        uniforms.as_entire_binding(),
        wgpu::BindingResource::TextureView(&matcaps),
        wgpu::BindingResource::Sampler(&sampler),
    ];
    let entries: Vec<_> =
        (0..).zip(resources).map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource }).collect();
    gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("frame"),
        layout,
        entries: &entries,
    })
}
