// accumulate: plain temporal accumulation, the simplest peer of the denoiser. Each pixel's radiance is averaged
// with its history, found along the motion vector; there is no spatial filter.
//
// Reads:  the G-buffer of this frame; mean, count and surfaces of the previous frame.
// Writes: mean radiance and count; surfaces; the output.
// Source: exponential and cumulative averaging with reprojection as in Yang, Liu and Salvi, "A Survey of Temporal
//         Antialiasing Techniques" (Computer Graphics Forum 2020), without colour clamping.

//!include frame
//!include surface
//!include taps
//!include reproject

@group(0) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var normal_roughness: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var motion: texture_2d<f32>;
@group(0) @binding(5) var surface_id: texture_2d<u32>;
@group(0) @binding(6) var sample_count: texture_2d<u32>;
@group(0) @binding(7) var prev_mean: texture_2d<f32>;
@group(0) @binding(8) var prev_surface: texture_2d<u32>;
@group(0) @binding(9) var out_mean: texture_storage_2d<rgba32float, write>;
@group(0) @binding(10) var out_surface: texture_storage_2d<rg32uint, write>;
@group(0) @binding(11) var output: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn accumulate(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = id.xy;
    let current = sanitise(textureLoad(radiance, pixel, 0).rgb);
    let d = textureLoad(depth, pixel, 0).r;
    if is_miss(d) {
        textureStore(out_mean, pixel, vec4(current, 0.0));
        textureStore(out_surface, pixel, vec4(0u));
        textureStore(output, pixel, vec4(current, 1.0));
        return;
    }
    let surface =
        surface_of(d, textureLoad(normal_roughness, pixel, 0).xyz, textureLoad(surface_id, pixel, 0).r);
    let m = textureLoad(motion, pixel, 0).xyz;
    let taps = taps_at(prev_position(pixel, m), surface, expected_depth(pixel, d, m.z));
    // Mean in rgb, count in a.
    let history = fetch(prev_mean, taps);

    var mean = history.rgb;
    var count = history.a;
    if textureLoad(sample_count, pixel, 0).r > 0u {
        count = min(count, frame.max_history - 1.0) + 1.0;
        mean += (current - mean) / count;
    }
    textureStore(out_mean, pixel, vec4(mean, count));
    textureStore(out_surface, pixel, vec4(pack_surface(surface, count > 0.0), 0u, 0u));
    textureStore(output, pixel, vec4(mean, 1.0));
}
