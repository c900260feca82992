// Lays the finished picture on the window, pixel for pixel.

@group(0) @binding(0) var picture: texture_2d<f32>;
@group(0) @binding(1) var picture_sampler: sampler;

// Whether the window's format encodes what it is given: then the picture's own encoding is undone first.
override decode: bool = false;

struct Fragment {
    @builtin(position) clip: vec4<f32>,
    @location(0) uv: vec2<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Fragment {
    let corner = vec2(f32(index & 1u), f32(index >> 1u)) * 2.0;
    var out: Fragment;
    out.clip = vec4(corner * 2.0 - 1.0, 0.0, 1.0);
    out.uv = vec2(corner.x, 1.0 - corner.y);
    return out;
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4<f32> {
    let encoded = textureSampleLevel(picture, picture_sampler, in.uv, 0.0).rgb;
    let low = encoded / 12.92;
    let high = pow((encoded + 0.055) / 1.055, vec3(2.4));
    let light = select(high, low, encoded <= vec3(0.04045));
    return vec4(select(encoded, light, decode), 1.0);
}
