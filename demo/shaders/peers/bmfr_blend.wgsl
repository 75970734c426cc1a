// bmfr_blend: accumulates the fitted signal over time, which hides the blocks; puts albedo and emission back.
//
// Reads:  the fitted signal; counts and where history is, of this frame; what this pass wrote for the previous one;
//         radiance, albedo and emission of this frame.
// Writes: the accumulated signal; radiance composed from it.
// Source: Koskela et al., "Blockwise Multi-Order Feature Regression for Real-Time Path-Tracing Reconstruction"
//         (TOG 2019): temporal accumulation of the filtered data.

//!include frame
//!include signal
//!include taps
//!include bmfr

@group(0) @binding(1) var fitted: texture_2d<f32>;
@group(0) @binding(2) var mean: texture_2d<f32>;
@group(0) @binding(3) var taps: texture_2d<u32>;
@group(0) @binding(4) var prev_accumulated: texture_2d<f32>;
@group(0) @binding(5) var depth: texture_2d<f32>;
@group(0) @binding(6) var radiance: texture_2d<f32>;
@group(0) @binding(7) var albedo: texture_2d<f32>;
@group(0) @binding(8) var emission: texture_2d<f32>;
@group(0) @binding(9) var out_accumulated: texture_storage_2d<rgba16float, write>;
@group(0) @binding(10) var out_composed: texture_storage_2d<rgba16float, write>;

// Weight of a new fit, at least.
const ALPHA = 0.1;

@compute @workgroup_size(8, 8)
fn bmfr_blend(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = id.xy;
    if is_miss(textureLoad(depth, pixel, 0).r) {
        textureStore(out_accumulated, pixel, vec4(0.0));
        textureStore(out_composed, pixel, vec4(sanitise(textureLoad(radiance, pixel, 0).rgb), 1.0));
        return;
    }
    var signal = textureLoad(fitted, pixel, 0).rgb;
    let history = unpack_taps(textureLoad(taps, pixel, 0).xy);
    if has_history(history) {
        let previous = fetch(prev_accumulated, history).rgb;
        let count = textureLoad(mean, pixel, 0).a;
        signal = mix(previous, signal, max(ALPHA, 1.0 / max(count, 1.0)));
    }
    textureStore(out_accumulated, pixel, vec4(signal, 1.0));
    let composed = remodulated(
        signal, textureLoad(albedo, pixel, 0).rgb, textureLoad(emission, pixel, 0).rgb);
    textureStore(out_composed, pixel, vec4(composed, 1.0));
}
