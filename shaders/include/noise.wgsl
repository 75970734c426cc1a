// The noise image: how far samples scatter, and how far their mean is off by chance.
//
// A deviation takes the same recursion and the same resampling as the temporal mean, but its samples' signs alternate: the
// signal cancels, the noise stays. So its square is about the mean's variance, however history was blended and resampled.
// Three of them, whose signs alternate every one, two and four frames: where two bright samples cancel in one, they add up in
// another.
// Source: the wild bootstrap: Wu, "Jackknife, Bootstrap and Other Resampling Methods in Regression Analysis", 1986; signs:
// Rademacher functions

struct Noise {
    variance: f32,         // of one sample's luminance
    deviations: vec3<f32>, // of the temporal mean's luminance
}

// In a word, from the lowest bits: three deviations, 7 each, in units of what the mean of `count` such samples should deviate
// by; the standard deviation of one sample, logarithmic, 11. All are rounded at random, so that long recursions are right in
// the mean.
const DEVIATIONS_RANGE = 4.0; // of the mean's expected deviation
// What the variance is multiplied by at most to make room for them. What goes farther is no sample's noise, but a history that is
// wrong.
const MOST_WIDENING = 4096.0;
const DEVIATION_OCTAVES = vec2(-24.0, 40.0); // the least, and how many

fn unpack_noise(word: u32, count: f32) -> Noise {
    let deviation = unpack_deviation(word >> 21u);
    let codes = vec3<i32>(vec3(word & 127u, (word >> 7u) & 127u, (word >> 14u) & 127u)) - 63;
    return Noise(deviation * deviation, vec3<f32>(codes) * deviation_unit(deviation, count));
}

fn pack_noise(noise: Noise, count: f32, pixel: vec2<u32>, seed: u32) -> u32 {
    let random = random_at(pixel, seed);
    // What deviates so far scatters so much: of few samples the variance is the neighbours', which know nothing of a firefly.
    let farthest = max(max(abs(noise.deviations.x), abs(noise.deviations.y)), abs(noise.deviations.z)) / DEVIATIONS_RANGE;
    let variance = clamp(count * farthest * farthest, noise.variance, MOST_WIDENING * noise.variance);
    let code = pack_deviation(sqrt(variance), random_unit(pcg(random)));
    let unit = deviation_unit(unpack_deviation(code), count);
    let codes = clamp(floor(noise.deviations / max(unit, 1e-30) + random_thirds(random)), vec3(-63.0), vec3(63.0));
    let bits = vec3<u32>(vec3<i32>(select(vec3(0.0), codes, unit > 0.0)) + 63);
    return bits.x | (bits.y << 7u) | (bits.z << 14u) | (code << 21u);
}

fn deviation_unit(deviation: f32, count: f32) -> f32 {
    return select(0.0, DEVIATIONS_RANGE / 63.0 * deviation * inverseSqrt(max(count, 1e-6)), count > 0.0);
}

fn pack_deviation(deviation: f32, dither: f32) -> u32 {
    let octave = log2(max(deviation, 1e-30)) - DEVIATION_OCTAVES.x;
    let code = floor(octave / DEVIATION_OCTAVES.y * 2046.0 + dither) + 1.0;
    return select(0u, u32(clamp(code, 1.0, 2047.0)), octave >= 0.0);
}

fn unpack_deviation(code: u32) -> f32 {
    let octave = f32(code - 1u) / 2046.0 * DEVIATION_OCTAVES.y + DEVIATION_OCTAVES.x;
    return select(0.0, exp2(octave), code > 0u);
}

// Variance of the temporal mean.
fn found_variance(deviations: vec3<f32>) -> f32 {
    return dot(deviations, deviations) / 3.0;
}
