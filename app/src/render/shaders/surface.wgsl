// The surface: a matcap seen along each vertex's own line of sight, relief by curvature, tints, insides.
//
// Without a GPU the fragment stage is what a frame costs, since small triangles fill few of the pixels they are
// shaded for; so whatever varies slowly is done per vertex.

@group(0) @binding(1) var matcaps: texture_2d_array<f32>;
@group(0) @binding(2) var matcap_sampler: sampler;

// One normal per triangle.
override flat_faces: bool = false;
// World-space normals as colours.
override show_normals: bool = false;

// A normal that turns by one radian within this many pixels makes a full hollow or ridge.
const RELIEF_PIXELS: f32 = 9.0;
const HOLLOW_DARKENING: f32 = 0.62;
const RIDGE_BRIGHTENING: f32 = 0.34;
// The inside of an open surface is cooler and darker than any outside.
const INSIDE: vec3<f32> = vec3(0.43, 0.49, 0.57);
const INSIDE_TINTED: f32 = 0.66;

struct Vertex {
    @location(0) position: vec3<f32>,
    @location(1) normal: vec2<f32>,
    @location(2) tint: vec4<f32>,
}

struct Fragment {
    @builtin(position) clip: vec4<f32>,
    // In axes whose z is the line of sight, so that silhouettes fall on the matcap's rim all over the picture.
    @location(0) normal: vec3<f32>,
    @location(1) tint: vec4<f32>,
    // World space, for `show_normals`; eye space position, for `flat_faces`.
    @location(2) extra: vec3<f32>,
}

// Undoes `packed` in `normals.rs`, but for the length.
fn unpack_normal(packed: vec2<f32>) -> vec3<f32> {
    let z = 1.0 - abs(packed.x) - abs(packed.y);
    let fold = max(-z, 0.0);
    return vec3(packed - select(vec2(-fold), vec2(fold), packed >= vec2(0.0)), z);
}

// A vector of eye space in the axes of the line of sight to `place`.
fn along_sight(vector: vec3<f32>, place: vec3<f32>) -> vec3<f32> {
    let to_eye = normalize(-place);
    let right = normalize(vec3(to_eye.z, 0.0, -to_eye.x));
    return vec3(dot(vector, right), dot(vector, cross(to_eye, right)), dot(vector, to_eye));
}

@vertex
fn vertex(in: Vertex) -> Fragment {
    let place = (frame.view * vec4(in.position, 1.0)).xyz;
    let normal = normalize(unpack_normal(in.normal));
    var out: Fragment;
    out.clip = frame.view_projection * vec4(in.position, 1.0);
    out.normal = along_sight((frame.view * vec4(normal, 0.0)).xyz, place);
    out.tint = in.tint;
    out.extra = select(normal, place, flat_faces);
    return out;
}

@fragment
fn fragment(in: Fragment, @builtin(front_facing) front: bool) -> @location(0) vec4<f32> {
    var normal = select(-in.normal, in.normal, front);
    if flat_faces {
        let face = cross(dpdx(in.extra), dpdy(in.extra));
        normal = along_sight(select(-face, face, dot(face, in.extra) < 0.0), in.extra);
    }
    // A normal that leans away from the eye counts as on the silhouette.
    normal.z = max(normal.z, 0.0);
    normal *= inverseSqrt(max(dot(normal, normal), 1e-24));
    let uv = vec2(normal.x, -normal.y) * 0.495 + 0.5;
    let lit = textureSampleLevel(matcaps, matcap_sampler, uv, i32(frame.lens.w), 0.0);

    // The fourth channel is the light alone, halved to fit. Inside, some of it comes from everywhere.
    let light = select(0.35 + 1.3 * lit.a, 2.0 * lit.a, front);
    var color = lit.rgb;
    if show_normals {
        color = normalize(in.extra) * select(-0.5, 0.5, front) + 0.5;
    }
    color = select(INSIDE * light, color, front);
    let tinted = in.tint.rgb * (light * select(INSIDE_TINTED, 1.0, front));
    color = mix(color, tinted, in.tint.a);

    // Where normals spread over the screen is a ridge, where they gather a hollow.
    let spread = clamp((dpdx(normal.x) - dpdy(normal.y)) * RELIEF_PIXELS * 0.5, -1.0, 1.0);
    let relief = spread * select(RIDGE_BRIGHTENING, HOLLOW_DARKENING, spread < 0.0) * frame.lens.z;
    return vec4(color * (1.0 + relief), 1.0);
}
