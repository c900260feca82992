// Handles: discs of constant size on the screen.

// Whether this pipeline draws what lies behind the surface.
override behind: bool = false;

const HOVERED: u32 = 1u;
const SELECTED: u32 = 2u;
// Points outside the disc that a halo or a ring may take.
const MARGIN: f32 = 6.0;

struct Handle {
    @location(0) position: vec3<f32>,
    @location(1) radius: f32,
    @location(2) fill: vec4<f32>,
    @location(3) rim: vec4<f32>,
    @location(4) state: u32,
}

struct Fragment {
    @builtin(position) clip: vec4<f32>,
    // Points from the centre.
    @location(0) offset: vec2<f32>,
    @location(1) @interpolate(flat) radius: f32,
    @location(2) @interpolate(flat) fill: vec4<f32>,
    @location(3) @interpolate(flat) rim: vec4<f32>,
    @location(4) @interpolate(flat) state: u32,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32, in: Handle) -> Fragment {
    let center = frame.view_projection * vec4(in.position, 1.0);
    var out: Fragment;
    if center.w < frame.lens.x {
        out.clip = vec4(0.0, 0.0, 0.0, 1.0);
        return out;
    }
    out.radius = in.radius * select(select(1.0, 1.2, in.state == HOVERED), 1.3, in.state == SELECTED);
    out.offset = quad_corner(index) * (out.radius + MARGIN);
    // Lifted by its own radius, so that the surface around its centre does not cut it.
    let depth = nearer(center, (out.radius + 2.0) * frame.hidden.z) / center.w;
    out.clip = vec4(center.xy / center.w + out.offset * 2.0 * frame.hidden.z * frame.picture.zw, depth, 1.0);
    let fade = select(1.0, frame.hidden.y, behind);
    out.fill = in.fill * vec4(1.0, 1.0, 1.0, fade);
    out.rim = in.rim * vec4(1.0, 1.0, 1.0, fade);
    out.state = in.state;
    return out;
}

// `top` over `below`; both have their colour multiplied by their opacity.
fn over(top: vec4<f32>, below: vec4<f32>) -> vec4<f32> {
    return top + below * (1.0 - top.a);
}

fn covered(color: vec4<f32>, coverage: f32) -> vec4<f32> {
    let alpha = color.a * clamp(coverage, 0.0, 1.0);
    return vec4(color.rgb * alpha, alpha);
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4<f32> {
    let distance = length(in.offset);
    let rim_width = clamp(in.radius * 0.28, 1.0, 2.5);
    // A touch of light from above, like the surface's own.
    let sheen = 1.0 + 0.18 * in.offset.y / in.radius;
    let fill = vec4(in.fill.rgb * sheen, in.fill.a);
    var color = over(
        covered(fill, in.radius - rim_width - distance + 0.5),
        covered(in.rim, in.radius - distance + 0.5),
    );
    if in.state == HOVERED {
        let glow = 1.0 - clamp((distance - in.radius) / (MARGIN - 1.0), 0.0, 1.0);
        color = over(color, covered(in.fill, 0.55 * glow * glow));
    }
    if in.state == SELECTED {
        let ring = 1.4 - abs(distance - in.radius - 3.4) + 0.5;
        color = over(color, covered(in.fill, ring));
        color = over(color, covered(in.rim, 0.6 * (2.4 - abs(distance - in.radius - 3.4) + 0.5)));
    }
    return color;
}
