// Shared by every shader of the picture: the frame's uniforms, and what more than one of them computes.

// Mirrors `FrameUniforms` in `uniforms.rs`.
struct Frame {
    view_projection: mat4x4<f32>,
    view: mat4x4<f32>,
    picture: vec4<f32>,
    lens: vec4<f32>,
    background_top: vec4<f32>,
    background_bottom: vec4<f32>,
    edge_color: vec4<f32>,
    ghost_fill: vec4<f32>,
    ghost_edge_color: vec4<f32>,
    edges: vec4<f32>,
    hidden: vec4<f32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// The depth of clip position `clip`, brought towards the eye by as much as `pixels` pixels span there.
fn nearer(clip: vec4<f32>, pixels: f32) -> f32 {
    return min(clip.z * (1.0 + pixels * frame.lens.y), clip.w);
}

// The corner of a quad drawn as a strip of four vertices, each coordinate -1 or 1.
fn quad_corner(vertex: u32) -> vec2<f32> {
    return vec2(f32(vertex & 1u), f32(vertex >> 1u)) * 2.0 - 1.0;
}
