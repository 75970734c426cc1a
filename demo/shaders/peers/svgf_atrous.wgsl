// svgf_atrous: one of the first four levels of the wavelet filter. The first one's result is next frame's history.
//
// Reads:  colour and variance; state and surfaces of this frame.
// Writes: colour and variance.
// Source: Schied et al., "Spatiotemporal Variance-Guided Filtering" (HPG 2017), sections 4.3 and 4.4.

//!include frame
//!include surface
//!include signal
//!include svgf_state
//!include svgf_edges
//!include svgf_level

@group(0) @binding(1) var color: texture_2d<f32>;
@group(0) @binding(2) var state: texture_2d<u32>;
@group(0) @binding(3) var surface: texture_2d<u32>;
@group(0) @binding(4) var out_color: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn svgf_atrous(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    textureStore(out_color, id.xy, filtered(vec2<i32>(id.xy)));
}
