// bmfr_accumulate: accumulates the noisy signal over time before it is fitted.
//
// Reads:  the G-buffer of this frame; mean, count and surfaces of the previous one.
// Writes: mean of the demodulated signal and its count; surfaces; where history was found.
// Source: Koskela et al., "Blockwise Multi-Order Feature Regression for Real-Time Path-Tracing Reconstruction"
//         (TOG 2019): temporal accumulation of the noisy data.

//!include frame
//!include surface
//!include taps
//!include reproject
//!include signal
//!include bmfr

@group(0) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var albedo: texture_2d<f32>;
@group(0) @binding(3) var normal_roughness: texture_2d<f32>;
@group(0) @binding(4) var depth: texture_2d<f32>;
@group(0) @binding(5) var motion: texture_2d<f32>;
@group(0) @binding(6) var surface_id: texture_2d<u32>;
@group(0) @binding(7) var emission: texture_2d<f32>;
@group(0) @binding(8) var sample_count: texture_2d<u32>;
@group(0) @binding(9) var prev_mean: texture_2d<f32>;
@group(0) @binding(10) var prev_surface: texture_2d<u32>;
@group(0) @binding(11) var out_mean: texture_storage_2d<rgba16float, write>;
@group(0) @binding(12) var out_surface: texture_storage_2d<rg32uint, write>;
@group(0) @binding(13) var out_taps: texture_storage_2d<rg32uint, write>;

// Weight of a new frame, at least; before, history is a plain mean.
const ALPHA = 0.2;
// Counts saturate here, exact in half precision.
const LONGEST = 255.0;

@compute @workgroup_size(8, 8)
fn bmfr_accumulate(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = id.xy;
    let d = textureLoad(depth, pixel, 0).r;
    if is_miss(d) {
        textureStore(out_mean, pixel, vec4(0.0));
        textureStore(out_surface, pixel, vec4(0u));
        textureStore(out_taps, pixel, vec4(0u));
        return;
    }
    let surface =
        surface_of(d, textureLoad(normal_roughness, pixel, 0).xyz, textureLoad(surface_id, pixel, 0).r);
    let m = textureLoad(motion, pixel, 0).xyz;
    let taps = taps_at(prev_position(pixel, m), surface, expected_depth(pixel, d, m.z));
    // Mean in rgb, count in a.
    let history = fetch(prev_mean, taps);
    var mean = history.rgb;
    var count = round(history.a);
    let seen = textureLoad(radiance, pixel, 0).rgb;
    if textureLoad(sample_count, pixel, 0).r > 0u && all_finite(seen) {
        let sample = demodulated(seen, textureLoad(albedo, pixel, 0).rgb, textureLoad(emission, pixel, 0).rgb);
        count = min(count + 1.0, min(LONGEST, frame.max_history));
        mean = mix(mean, sample, max(ALPHA, 1.0 / count));
    }
    textureStore(out_mean, pixel, vec4(mean, count));
    textureStore(out_surface, pixel, vec4(pack_surface(surface, count > 0.0), 0u, 0u));
    textureStore(out_taps, pixel, vec4(pack_taps(taps), 0u, 0u));
}
