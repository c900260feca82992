// Lines as quads of constant width on the screen, with soft sides: level edges, ghost edges, free lines.

// Whether this pipeline draws what lies behind the surface.
override behind: bool = false;
// Whether the edges are the ghost's.
override ghost: bool = false;

// Vertices of the surface or of the ghost, three floats each.
@group(1) @binding(0) var<storage, read> positions: array<f32>;

// Lines lie on the surface; this brings them out of it, by as much as this many pixels span.
const LIFT_PIXELS: f32 = 2.5;

struct Fragment {
    @builtin(position) clip: vec4<f32>,
    @location(0) color: vec4<f32>,
    // Pixels from the middle of the line, and half its width.
    @location(1) across: vec2<f32>,
}

fn position_of(vertex: u32) -> vec3<f32> {
    return vec3(positions[vertex * 3u], positions[vertex * 3u + 1u], positions[vertex * 3u + 2u]);
}

// Moves the end `a` along the line to the near plane if it lies behind it.
fn clipped(a: vec4<f32>, b: vec4<f32>) -> vec4<f32> {
    let near = frame.lens.x;
    return select(a, mix(a, b, (near - a.w) / (b.w - a.w)), a.w < near && b.w > near);
}

fn corner(index: u32, a: vec3<f32>, b: vec3<f32>, color: vec4<f32>, width: f32) -> Fragment {
    let ends = array(frame.view_projection * vec4(a, 1.0), frame.view_projection * vec4(b, 1.0));
    let from_end = clipped(ends[0], ends[1]);
    let to_end = clipped(ends[1], ends[0]);
    var out: Fragment;
    if max(from_end.w, to_end.w) < frame.lens.x || width <= 0.0 {
        // Behind the eye: a quad of no size.
        out.clip = vec4(0.0, 0.0, 0.0, 1.0);
        return out;
    }
    let half_picture = frame.picture.xy * 0.5;
    let from_pixel = from_end.xy / from_end.w * half_picture;
    let to_pixel = to_end.xy / to_end.w * half_picture;
    let span = to_pixel - from_pixel;
    let length = length(span);
    let along = select(vec2(1.0, 0.0), span / length, length > 1e-6);

    let which = quad_corner(index);
    let at_start = which.x < 0.0;
    let end = select(to_end, from_end, vec4(at_start));
    let reach = max(width, 1.0) * 0.5 + 0.5;
    let pixel = select(to_pixel, from_pixel, vec2(at_start)) + vec2(-along.y, along.x) * (reach * which.y);
    // Divided here, so that `across` runs evenly over the screen.
    out.clip = vec4(pixel / half_picture, nearer(end, LIFT_PIXELS) / end.w, 1.0);
    // A line thinner than a pixel is drawn one pixel wide and fainter.
    out.color = vec4(color.rgb, color.a * min(width, 1.0));
    out.across = vec2(reach * which.y, reach);
    return out;
}

@vertex
fn edge(@builtin(vertex_index) index: u32, @location(0) ends: vec2<u32>) -> Fragment {
    var color = frame.edge_color;
    var look = frame.edges.xy;
    if ghost {
        color = frame.ghost_edge_color;
        look = frame.edges.zw;
    }
    color.a *= select(1.0, look.y, behind);
    return corner(index, position_of(ends.x), position_of(ends.y), color, look.x);
}

@vertex
fn line(
    @builtin(vertex_index) index: u32,
    @location(0) a: vec3<f32>,
    @location(1) b: vec3<f32>,
    @location(2) own: vec4<f32>,
    @location(3) width: f32,
) -> Fragment {
    var color = own;
    color.a *= select(1.0, frame.hidden.x, behind);
    return corner(index, a, b, color, width * frame.hidden.z);
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4<f32> {
    let alpha = in.color.a * clamp(in.across.y - abs(in.across.x), 0.0, 1.0);
    return vec4(in.color.rgb * alpha, alpha);
}
