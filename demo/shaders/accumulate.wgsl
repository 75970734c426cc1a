// accumulate: adds a frame's radiance to the sum that becomes a reference.
//
// Reads:  radiance (mean of `spp` samples), prev_sum (radiance, sample count)
// Writes: sum
// Source: -

struct Accumulate {
    spp: u32,
    // 1 starts a new sum.
    is_first: u32,
}

@group(0) @binding(0) var radiance: texture_2d<f32>;
@group(0) @binding(1) var prev_sum: texture_2d<f32>;
@group(0) @binding(2) var sum_out: texture_storage_2d<rgba32float, write>;
@group(0) @binding(3) var<uniform> accumulate_: Accumulate;

@compute @workgroup_size(8, 8)
fn accumulate(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= textureDimensions(radiance)) {
        return;
    }
    let samples = f32(accumulate_.spp);
    var sum = vec4f(textureLoad(radiance, id.xy, 0).xyz * samples, samples);
    if accumulate_.is_first == 0u {
        sum += textureLoad(prev_sum, id.xy, 0);
    }
    textureStore(sum_out, id.xy, sum);
}
