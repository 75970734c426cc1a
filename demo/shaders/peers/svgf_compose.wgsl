// svgf_compose: the last level of the wavelet filter; puts albedo and emission back.
//
// Reads:  colour and variance; state and surfaces; radiance, albedo and emission of this frame.
// Writes: the output.
// Source: Schied et al., "Spatiotemporal Variance-Guided Filtering" (HPG 2017), sections 3 and 4.3.

//!include frame
//!include surface
//!include signal
//!include svgf_state
//!include svgf_edges
//!include svgf_level

@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var state: texture_2d<u32>;
@group(0) @binding(3) var surface: texture_2d<u32>;
@group(0) @binding(4) var radiance: texture_2d<f32>;
@group(0) @binding(5) var albedo: texture_2d<f32>;
@group(0) @binding(6) var emission: texture_2d<f32>;
@group(0) @binding(7) var output: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn svgf_compose(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = id.xy;
    if depth_of(textureLoad(surface, pixel, 0).xy) == 0.0 {
        textureStore(output, pixel, vec4(sanitise(textureLoad(radiance, pixel, 0).rgb), 1.0));
        return;
    }
    let composed = remodulated(
        filtered(vec2<i32>(pixel)).rgb, textureLoad(albedo, pixel, 0).rgb, textureLoad(emission, pixel, 0).rgb);
    textureStore(output, pixel, vec4(composed, 1.0));
}
