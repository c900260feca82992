// What lies behind everything: a vertical gradient at infinite distance, dithered against banding.

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    // One triangle over the whole picture, at the depth of infinity.
    return vec4(f32(index & 1u) * 4.0 - 1.0, f32(index >> 1u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fragment(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let place = pixel.xy * frame.picture.zw;
    let off_center = place - vec2(0.5, 0.42);
    let vignette = 1.0 - 0.16 * dot(off_center, off_center);
    // Interleaved gradient noise (Jimenez 2014), half a step each way.
    let noise = fract(52.9829189 * fract(dot(pixel.xy, vec2(0.06711056, 0.00583715)))) - 0.5;
    let color = mix(frame.background_top.rgb, frame.background_bottom.rgb, place.y);
    return vec4(color * vignette + noise / 255.0, 1.0);
}
