// svgf_temporal: integrates the demodulated signal and the moments of its luminance over time.
//
// Reads:  the G-buffer of this frame; colour (after the first filter level), state and surfaces of the previous one.
// Writes: integrated colour with the variance of its luminance; state; surfaces.
// Source: Schied et al., "Spatiotemporal Variance-Guided Filtering" (HPG 2017), sections 4.1 (temporal filtering) and
//         4.2 (variance estimation).

//!include frame
//!include surface
//!include taps
//!include reproject
//!include signal
//!include svgf_state

@group(0) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var albedo: texture_2d<f32>;
@group(0) @binding(3) var normal_roughness: texture_2d<f32>;
@group(0) @binding(4) var depth: texture_2d<f32>;
@group(0) @binding(5) var motion: texture_2d<f32>;
@group(0) @binding(6) var surface_id: texture_2d<u32>;
@group(0) @binding(7) var emission: texture_2d<f32>;
@group(0) @binding(8) var sample_count: texture_2d<u32>;
@group(0) @binding(9) var prev_color: texture_2d<f32>;
@group(0) @binding(10) var prev_state: texture_2d<u32>;
@group(0) @binding(11) var prev_surface: texture_2d<u32>;
@group(0) @binding(12) var out_color: texture_storage_2d<rgba16float, write>;
@group(0) @binding(13) var out_state: texture_storage_2d<rg32uint, write>;
@group(0) @binding(14) var out_surface: texture_storage_2d<rg32uint, write>;

// Weight of a new frame in colour and moments, at least (the paper's, for both).
const ALPHA = 0.2;
// The history's length saturates here: 8 bits hold it.
const LONGEST = 255.0;

struct History {
    color: vec3<f32>,
    moments: vec2<f32>,
    length: f32,
}

fn add_tap(history: ptr<function, History>, tap: vec2<i32>, weight: f32) {
    let state = textureLoad(prev_state, tap, 0).xy;
    (*history).color += weight * textureLoad(prev_color, tap, 0).rgb;
    (*history).moments += weight * moments_of(state);
    (*history).length += weight * f32(length_of(state));
}

// Section 4.1: bilinear over the 2x2 taps whose depth, normal and mesh id agree; where none does, a 3x3 search.
fn history_at(position: vec2<f32>, surface: Surface, expected: f32) -> History {
    var history = History(vec3(0.0), vec2(0.0), 0.0);
    let taps = taps_at(position, surface, expected);
    if has_history(taps) {
        for (var i = 0; i < 4; i++) {
            if taps.weights[i] > 0.0 {
                add_tap(&history, taps.base + tap_offset(i), taps.weights[i]);
            }
        }
        return history;
    }
    var found = 0.0;
    let middle = vec2<i32>(floor(position));
    for (var i = 0; i < 9; i++) {
        let tap = middle + vec2(i % 3 - 1, i / 3 - 1);
        if showed(tap, surface, expected) {
            add_tap(&history, tap, 1.0);
            found += 1.0;
        }
    }
    let scale = 1.0 / max(found, 1.0);
    return History(history.color * scale, history.moments * scale, history.length * scale);
}

// The smaller of the steps to both neighbours, which does not reach over an edge of the surface, relative to depth.
fn depth_slope(pixel: vec2<i32>, d: f32, axis: vec2<i32>) -> f32 {
    var slope = HALF_MAX;
    for (var side = -1; side <= 1; side += 2) {
        let at = pixel + side * axis;
        if inside(at) {
            let neighbour = textureLoad(depth, at, 0).r;
            let step = (neighbour - d) / d * f32(side);
            slope = select(slope, step, !is_miss(neighbour) && abs(step) < abs(slope));
        }
    }
    return select(slope, 0.0, slope == HALF_MAX);
}

@compute @workgroup_size(8, 8)
fn svgf_temporal(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = id.xy;
    let d = textureLoad(depth, pixel, 0).r;
    if is_miss(d) {
        textureStore(out_color, pixel, vec4(vec3(0.0), NO_ESTIMATE));
        textureStore(out_state, pixel, vec4(0u));
        textureStore(out_surface, pixel, vec4(0u));
        return;
    }
    let surface =
        surface_of(d, textureLoad(normal_roughness, pixel, 0).xyz, textureLoad(surface_id, pixel, 0).r);
    let m = textureLoad(motion, pixel, 0).xyz;
    let history = history_at(prev_position(pixel, m), surface, expected_depth(pixel, d, m.z));

    var color = history.color;
    var moments = history.moments;
    var length = round(history.length);
    let seen = textureLoad(radiance, pixel, 0).rgb;
    if textureLoad(sample_count, pixel, 0).r > 0u && all_finite(seen) {
        let sample = demodulated(seen, textureLoad(albedo, pixel, 0).rgb, textureLoad(emission, pixel, 0).rgb);
        length = min(length + 1.0, LONGEST);
        // Exponential, beginning with the plain mean.
        let alpha = max(ALPHA, 1.0 / min(length, frame.max_history));
        let l = luminance(sample);
        color = mix(color, sample, alpha);
        moments = mix(moments, vec2(l, l * l), alpha);
    }
    let slope = vec2(depth_slope(vec2<i32>(pixel), d, vec2(1, 0)), depth_slope(vec2<i32>(pixel), d, vec2(0, 1)));
    let variance = select(NO_ESTIMATE, min(variance_of(moments), HALF_MAX), length > 0.0);
    textureStore(out_color, pixel, vec4(color, variance));
    textureStore(out_state, pixel, vec4(pack_state(moments, slope, u32(length)), 0u, 0u));
    textureStore(out_surface, pixel, vec4(pack_surface(surface, length > 0.0), 0u, 0u));
}
