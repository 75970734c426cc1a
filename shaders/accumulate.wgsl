// accumulate: the weighted temporal sample. This frame's sample joins the history of its surface.
//
// Reads   signal, guide; reprojected history and noise.
// Writes  history: temporal mean of demodulated radiance, effective sample count in w
//         noise: variance of one sample's luminance, and a deviation with the variance of the temporal mean
// Source  incremental weighted mean and variance: West, "Updating mean and variance estimates", CACM 1979; spatial
//         fall-back for short histories: Schied et al. 2017, section 4.2; deviations with flipped signs: the wild bootstrap,
//         Wu, "Jackknife, Bootstrap and Other Resampling Methods in Regression Analysis", 1986

//!include frame numbers surface

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var signal: texture_2d<f32>;
@group(0) @binding(2) var guide: texture_2d<u32>;
@group(0) @binding(3) var reprojected: texture_2d<f32>;
@group(0) @binding(4) var reprojected_noise: texture_2d<f32>;
@group(0) @binding(5) var history: texture_storage_2d<rgba16float, write>;
@group(0) @binding(6) var noise: texture_storage_2d<rg32float, write>;

// Below this many samples a pixel's own variance means nothing, and its neighbours' spread is used.
const LEAST_SAMPLES = 4.0;
const SPATIAL_RADIUS = 3;

@compute @workgroup_size(8, 8)
fn accumulate(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let sample = textureLoad(signal, id.xy, 0);
    let old = textureLoad(reprojected, id.xy, 0);
    let old_noise = textureLoad(reprojected_noise, id.xy, 0).xy;

    // A pixel traced k times this frame enters with weight k; without samples the history stays as it is.
    let k = sample.w;
    let count = min(old.w, max(frame.max_history - k, 0.0)) + k;
    if k == 0.0 {
        textureStore(history, id.xy, vec4(old.rgb, min(old.w, frame.max_history)));
        textureStore(noise, id.xy, vec4(old_noise, 0.0, 0.0));
        return;
    }
    let alpha = k / count;
    let mean = mix(old.rgb, sample.rgb, alpha);
    let d = luminance(sample.rgb) - luminance(old.rgb);
    var v = 0.0;
    // What is new in this sample is less than what it differs by from the mean before it, which is noisy too.
    var innovation = sqrt(1.0 - alpha) * d;
    let first = alpha == 1.0; // nothing of the past is left: only the neighbours tell what is new
    if first || count < LEAST_SAMPLES {
        let spread = spatial_spread(id.xy);
        v = spread.variance;
        if first {
            innovation = luminance(sample.rgb) - spread.mean;
        }
    } else {
        // Unbiased where v was: E[d^2] = v (1/k + 1/(count - k)), so (1 - alpha) k d^2 estimates v.
        v = (1.0 - alpha) * (old_noise.x + alpha * k * d * d);
    }
    // The same recursion and the same resampling as the mean's, but its sign flips with every sample: the signal cancels, the
    // noise stays. So its square is about the mean's variance, however history was blended and resampled. Flipping, and not
    // at random, because after a bright sample the next ones deviate downwards: flipped, these add to it and do not hide it.
    let deviation = alpha * innovation - (1.0 - alpha) * old_noise.y;
    textureStore(history, id.xy, vec4(dither_to_half(mean, id.xy, 2u * frame.index + 1u), count));
    textureStore(noise, id.xy, vec4(v, deviation, 0.0, 0.0));
}

struct Spread {
    mean: f32,
    variance: f32, // of one sample
}

// Mean and variance of luminance over this frame's samples on the same surface.
fn spatial_spread(pixel: vec2<u32>) -> Spread {
    let centre = unpack_surface(textureLoad(guide, pixel, 0));
    let p = position_of(frame, frame.current, vec2<f32>(pixel), centre.depth);
    // About the pixel's own value: the difference of two large squares would lose f32's digits.
    let origin = luminance(textureLoad(signal, pixel, 0).rgb);
    var weight = 0.0;
    var sum = 0.0;
    var sum_squares = 0.0;
    var samples = 0.0;
    for (var y = -SPATIAL_RADIUS; y <= SPATIAL_RADIUS; y++) {
        for (var x = -SPATIAL_RADIUS; x <= SPATIAL_RADIUS; x++) {
            let texel = vec2<i32>(pixel) + vec2(x, y);
            if !inside(texel, frame) {
                continue;
            }
            let sample = textureLoad(signal, texel, 0);
            let other = unpack_surface(textureLoad(guide, texel, 0));
            let q = position_of(frame, frame.current, vec2<f32>(texel), other.depth);
            if sample.w > 0.0 && same_surface(centre, other, q - p) {
                let l = luminance(sample.rgb) - origin;
                weight += 1.0;
                sum += l;
                sum_squares += l * l;
                samples += sample.w;
            }
        }
    }
    if weight < 2.0 {
        // Alone: as uncertain as the value is large.
        return Spread(0.0, origin * origin * samples);
    }
    let spread = max(sum_squares - sum * sum / weight, 0.0) / (weight - 1.0);
    // The images hold means of several samples, one of which spreads more.
    return Spread(origin + sum / weight, spread * samples / weight);
}
