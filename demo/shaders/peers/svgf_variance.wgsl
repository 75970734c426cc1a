// svgf_variance: estimates the variance of luminance in space where history is too short for one over time.
//
// Reads:  integrated colour, state and surfaces of this frame.
// Writes: colour with its variance.
// Source: Schied et al., "Spatiotemporal Variance-Guided Filtering" (HPG 2017), section 4.2.

//!include frame
//!include surface
//!include svgf_state
//!include svgf_edges

@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var state: texture_2d<u32>;
@group(0) @binding(3) var surface: texture_2d<u32>;
@group(0) @binding(4) var out_color: texture_storage_2d<rgba16float, write>;

// Frames of history from which on the variance over time is used.
const ENOUGH = 4u;
// Of the bilateral filter: 7x7.
const RADIUS = 3;

@compute @workgroup_size(8, 8)
fn svgf_variance(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let integrated = textureLoad(color, pixel, 0);
    let center_state = textureLoad(state, pixel, 0).xy;
    if integrated.a < 0.0 || length_of(center_state) >= ENOUGH {
        textureStore(out_color, pixel, integrated);
        return;
    }
    let center = textureLoad(surface, pixel, 0).xy;
    let normal = normal_of(center);
    let slope = slope_of(center_state);
    var moments = vec2(0.0);
    var total = 0.0;
    for (var y = -RADIUS; y <= RADIUS; y++) {
        for (var x = -RADIUS; x <= RADIUS; x++) {
            let tap = pixel + vec2(x, y);
            if !inside(tap) {
                continue;
            }
            let tap_state = textureLoad(state, tap, 0).xy;
            if length_of(tap_state) == 0u {
                continue;
            }
            let weight = geometry_weight(
                center, normal, slope, textureLoad(surface, tap, 0).xy, vec2<f32>(vec2(x, y)));
            moments += weight * moments_of(tap_state);
            total += weight;
        }
    }
    // The centre itself always counts.
    textureStore(out_color, pixel, vec4(integrated.rgb, min(variance_of(moments / total), HALF_MAX)));
}
