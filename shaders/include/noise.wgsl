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

fn unpack_noise(texel: vec4<f32>) -> Noise {
    return Noise(texel.x * texel.x, texel.yzw);
}

// The standard deviation has the range that half precision needs.
fn pack_noise(noise: Noise, pixel: vec2<u32>, seed: u32) -> vec4<f32> {
    let deviations = dither_to_half(noise.deviations, pixel, seed);
    return vec4(dither_to_half(vec3(sqrt(noise.variance)), pixel, seed + 0x9e3779b9u).x, deviations);
}

// Variance of the temporal mean.
fn found_variance(deviations: vec3<f32>) -> f32 {
    return dot(deviations, deviations) / 3.0;
}
