// Bits of floats: what arithmetic may assume away, and rounding that does not drift.

// NaN and infinity by their exponent: compilers may treat `x != x` as false.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

fn all_finite(v: vec3<f32>) -> bool {
    return is_finite(v.x) && is_finite(v.y) && is_finite(v.z);
}

const HALF_MAX = 65504.0;

// PCG hash. Source: Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020.
fn pcg(v: u32) -> u32 {
    let state = v * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

// A random number of a pixel's own, another one for each seed.
fn random_at(pixel: vec2<u32>, seed: u32) -> u32 {
    return pcg(pixel.x + pcg(pixel.y + pcg(seed)));
}

// Three numbers in 0..1, from 10 bits each.
fn random_thirds(random: u32) -> vec3<f32> {
    return vec3<f32>(vec3(random, random >> 10u, random >> 20u) & vec3(1023u)) / 1024.0;
}

// Uniform in 0..1, from 24 of the bits.
fn random_unit(random: u32) -> f32 {
    return f32(random >> 8u) / 16777216.0;
}

// Rounds to half precision at random, up or down so that the mean is right. Rounding to nearest would swallow every step of a long temporal mean that is smaller than half a unit in the last place.
fn dither_to_half(v: vec3<f32>, pixel: vec2<u32>, seed: u32) -> vec3<f32> {
    let random = random_at(pixel, seed);
    let steps = vec3(random, random >> 9u, random >> 18u) & vec3(0x1fffu);
    let rounded = bitcast<vec3<f32>>((bitcast<vec3<u32>>(v) + steps) & vec3(0xffffe000u));
    return clamp(rounded, vec3(-HALF_MAX), vec3(HALF_MAX));
}
