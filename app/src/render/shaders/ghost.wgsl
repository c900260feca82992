// The ghost: a second mesh, translucent, seen from both sides, denser where it grazes the line of sight.

// Where ghost and surface coincide the surface wins, by as much depth as this many pixels span.
const SINK_PIXELS: f32 = 1.0;

struct Fragment {
    @builtin(position) clip: vec4<f32>,
    @location(0) place: vec3<f32>,
}

@vertex
fn vertex(@location(0) position: vec3<f32>) -> Fragment {
    var out: Fragment;
    out.clip = frame.view_projection * vec4(position, 1.0);
    out.clip.z = nearer(out.clip, -SINK_PIXELS);
    out.place = (frame.view * vec4(position, 1.0)).xyz;
    return out;
}

@fragment
fn fragment(in: Fragment) -> @location(0) vec4<f32> {
    let normal = normalize(cross(dpdx(in.place), dpdy(in.place)));
    let facing = abs(dot(normal, normalize(in.place)));
    let alpha = min(frame.ghost_fill.a * (1.0 + 1.8 * (1.0 - facing) * (1.0 - facing)), 1.0);
    return vec4(frame.ghost_fill.rgb * (0.75 + 0.35 * facing) * alpha, alpha);
}
