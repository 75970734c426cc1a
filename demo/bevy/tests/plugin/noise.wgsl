// Multiplies light by noise with a mean of 1.

@group(0) @binding(0) var<uniform> seed: vec4u;
@group(0) @binding(1) var clean: texture_2d<f32>;
@group(0) @binding(2) var noisy: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn noise(@builtin(global_invocation_id) id: vec3u) {
    let size = textureDimensions(clean);
    if any(id.xy >= size) {
        return;
    }
    let uniform_sample = f32(hash(hash(id.x + size.x * id.y) + seed.x) >> 8) / 16777216;
    textureStore(noisy, id.xy, vec4f(2 * uniform_sample * textureLoad(clean, id.xy, 0).rgb, 1));
}

// PCG (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020).
fn hash(value: u32) -> u32 {
    let state = value * 747796405 + 2891336453;
    let word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737;
    return (word >> 22) ^ word;
}
