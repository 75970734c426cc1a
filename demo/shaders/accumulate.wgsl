// accumulate: adds a frame's radiance to the running mean that becomes a reference.
//
// Reads:  radiance (mean of `spp` samples), prev_mean (radiance, sample count)
// Writes: mean_out
// Source: -

struct Accumulate {
    spp: u32,
    // 1 starts anew.
    is_first: u32,
}

@group(0) @binding(0) var radiance: texture_2d<f32>;
@group(0) @binding(1) var prev_mean: texture_2d<f32>;
@group(0) @binding(2) var mean_out: texture_storage_2d<rgba32float, write>;
@group(0) @binding(3) var<uniform> accumulate_: Accumulate;

@compute @workgroup_size(8, 8)
fn accumulate(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(radiance)) {
        return;
    }
    let samples = f32(accumulate_.spp);
    var mean = vec4f(textureLoad(radiance, id.xy, 0).xyz, samples);
    if accumulate_.is_first == 0u {
        let prev = textureLoad(prev_mean, id.xy, 0);
        let count = prev.w + samples;
        mean = vec4f(mix(prev.xyz, mean.xyz, samples / count), count);
    }
    textureStore(mean_out, id.xy, mean);
}
