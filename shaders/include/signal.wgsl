// The signal image: a pixel's demodulated radiance of this frame in a word, or that it has none.
//
// Three mantissas of 9 bits share an exponent of 5 (values up to 65408), rounded at random so that means are right.

const NO_SAMPLE = 0xffffffffu;
const LARGEST_SIGNAL = 65408.0;

fn pack_signal(colour: vec3<f32>, pixel: vec2<u32>, seed: u32) -> u32 {
    let bounded = clamp(colour, vec3(0.0), vec3(LARGEST_SIGNAL));
    let largest = max(bounded.x, max(bounded.y, bounded.z));
    let least = u32(max(i32(bitcast<u32>(largest) >> 23u) - 111, 0));
    // Where the largest mantissa has no place to be rounded up to, the next exponent.
    let exponent = least + select(0u, 1u, largest * exp2(24.0 - f32(least)) > 511.0);
    let mantissas = vec3<u32>(min(floor(bounded * exp2(24.0 - f32(exponent)) + random_thirds(random_at(pixel, seed))), vec3(511.0)));
    let word = mantissas.x | (mantissas.y << 9u) | (mantissas.z << 18u) | (exponent << 27u);
    return min(word, NO_SAMPLE - 1u);
}

fn unpack_signal(word: u32) -> vec3<f32> {
    let mantissas = vec3(word & 511u, (word >> 9u) & 511u, (word >> 18u) & 511u);
    return vec3<f32>(mantissas) * exp2(f32(word >> 27u) - 24.0);
}

// Samples traced at a pixel; a pass binds sample_count.
fn samples_at(pixel: vec2<u32>) -> f32 {
    if has(frame, FLAG_SAMPLE_COUNT) {
        return f32(min(textureLoad(sample_count, frame.origin + pixel, 0).x, 1024u));
    }
    return 1.0;
}
