// bmfr_taa: temporal antialiasing of the composed image, the last of three accumulations.
//
// Reads:  composed radiance, motion and depth of this frame; what this pass wrote for the previous one.
// Writes: the output, and the same as history.
// Source: Koskela et al., "Blockwise Multi-Order Feature Regression for Real-Time Path-Tracing Reconstruction"
//         (TOG 2019), its last step; history is clamped to the neighbourhood in YCoCg as in Karis, "High Quality Temporal
//         Supersampling" (SIGGRAPH courses 2014), to the mean of the boxes of 3x3 pixels and of the cross in it.

//!include frame
//!include toned

@group(0) @binding(1) var composed: texture_2d<f32>;
@group(0) @binding(2) var motion: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var prev_output: texture_2d<f32>;
@group(0) @binding(5) var out_history: texture_storage_2d<rgba16float, write>;
@group(0) @binding(6) var output: texture_storage_2d<rgba16float, write>;

// Weight of a new frame.
const ALPHA = 0.2;

// Bilinear, toned, without a test of what is seen there: that is what clamping is for.
fn history_at(position: vec2<f32>) -> vec3<f32> {
    let corner = position - 0.5;
    let base = vec2<i32>(floor(corner));
    let t = fract(corner);
    var sum = vec3(0.0);
    for (var i = 0; i < 4; i++) {
        let offset = vec2(i & 1, i >> 1);
        let tap = clamp(base + offset, vec2(0), vec2<i32>(frame.size) - 1);
        let weights = select(1.0 - t, t, offset == vec2(1));
        sum += weights.x * weights.y * tone(textureLoad(prev_output, tap, 0).rgb);
    }
    return sum;
}

@compute @workgroup_size(8, 8)
fn bmfr_taa(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let current = textureLoad(composed, pixel, 0);
    let m = textureLoad(motion, pixel, 0).xyz;
    let position = vec2<f32>(pixel) + 0.5 + m.xy;
    let history = frame.restart == 0u && all_finite(vec3(m.xy, 0.0))
        && all(position >= vec2(0.0)) && all(position < vec2<f32>(frame.size));
    // What is beyond all surfaces has no motion, and is not filtered.
    if !history || is_miss(textureLoad(depth, pixel, 0).r) {
        textureStore(out_history, pixel, current);
        textureStore(output, pixel, current);
        return;
    }
    let here = ycocg(tone(current.rgb));
    var cross_low = here;
    var cross_high = here;
    var low = here;
    var high = here;
    for (var i = 0; i < 9; i++) {
        let offset = vec2(i % 3 - 1, i / 3 - 1);
        if !inside(pixel + offset) {
            continue;
        }
        let neighbour = ycocg(tone(textureLoad(composed, pixel + offset, 0).rgb));
        low = min(low, neighbour);
        high = max(high, neighbour);
        if offset.x == 0 || offset.y == 0 {
            cross_low = min(cross_low, neighbour);
            cross_high = max(cross_high, neighbour);
        }
    }
    let clamped =
        clamp(ycocg(history_at(position)), 0.5 * (low + cross_low), 0.5 * (high + cross_high));
    let alpha = max(ALPHA, 1.0 / frame.max_history);
    let result = vec4(radiance_of(rgb(mix(clamped, here, alpha))), 1.0);
    textureStore(out_history, pixel, result);
    textureStore(output, pixel, result);
}
