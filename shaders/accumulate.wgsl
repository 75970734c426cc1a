// accumulate: the weighted temporal sample. This frame's sample joins the history of its surface, which is relit first.
//
// Reads   signal, guide; reprojected history and noise; innovations.
// Writes  history: temporal mean of demodulated radiance, effective sample count in w
//         noise (layout: include/noise)
// Source  incremental weighted mean and variance: West, "Updating mean and variance estimates", CACM 1979; spatial
//         fall-back for short histories: Schied et al. 2017, section 4.2; truncated means: Bubeck, Cesa-Bianchi and Lugosi,
//         "Bandits with Heavy Tail", 2013, section 2.1

//!include frame numbers noise surface features innovations

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var signal: texture_2d<f32>;
@group(0) @binding(2) var guide: texture_2d<u32>;
@group(0) @binding(3) var reprojected: texture_2d<f32>;
@group(0) @binding(4) var reprojected_noise: texture_2d<f32>;
@group(0) @binding(5) var<storage, read> innovations: array<f32>;
@group(0) @binding(6) var history: texture_storage_2d<rgba16float, write>;
@group(0) @binding(7) var noise: texture_storage_2d<rgba16float, write>;

// Below this many samples a pixel's own variance means nothing, and its neighbours' spread is used.
const LEAST_SAMPLES = 4.0;
const SPATIAL_RADIUS = 3;

@compute @workgroup_size(8, 8)
fn accumulate(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    var sample = textureLoad(signal, id.xy, 0);
    let relit = relight(id.xy);
    let old = relit.history;
    let old_noise = relit.noise;
    sample = vec4(sample.rgb * min(1.0, relit.most / max(luminance(sample.rgb), 1e-30)), sample.w);

    // A pixel traced k times this frame enters with weight k; without samples the history stays as it is.
    let k = sample.w;
    let count = min(old.w, max(frame.max_history - k, 0.0)) + k;
    if k == 0.0 {
        textureStore(history, id.xy, vec4(old.rgb, min(old.w, frame.max_history)));
        textureStore(noise, id.xy, pack_noise(old_noise, id.xy, 2u * frame.index + 1u));
        return;
    }
    let alpha = k / count;
    // What is new in this sample is less than what it differs by from the mean before it, which is noisy too; as noisy as
    // its samples make it, even where they count for less because the light changed.
    let new_share = relit.samples / (relit.samples + k);
    let mean = mix(old.rgb, sample.rgb, alpha);
    let d = luminance(sample.rgb) - luminance(old.rgb);
    var v = 0.0;
    var innovation = sqrt(new_share) * d;
    let first = alpha == 1.0; // nothing of the past is left: only the neighbours tell what is new
    if first || count < LEAST_SAMPLES {
        let spread = spatial_spread(id.xy);
        v = spread.variance;
        if first {
            innovation = luminance(sample.rgb) - spread.mean;
        }
    } else {
        // Unbiased where v was: E[d^2] = v (1/k + 1/n) with n samples before, so n / (n + k) k d^2 estimates v.
        v = mix(old_noise.variance, new_share * k * d * d, alpha);
    }
    let flips = select(vec3(1.0), vec3(-1.0), vec3(frame.index) % vec3(1u, 2u, 4u) == vec3(0u));
    let deviations = alpha * innovation + flips * (1.0 - alpha) * old_noise.deviations;
    textureStore(history, id.xy, vec4(dither_to_half(mean, id.xy, 2u * frame.index + 1u), count));
    textureStore(noise, id.xy, pack_noise(Noise(v, deviations), id.xy, 2u * frame.index + 1u));
}

// What the history is believed to be in this frame's light.
struct Relit {
    history: vec4<f32>,
    noise: Noise,
    samples: f32, // that are in it
    most: f32, // luminance of a sample beyond which it is a firefly
}

const KALMAN_GAIN = 3.0; // how much less a history counts that was moved by a standard deviation of one sample
const MOST_BRIGHTENING = 16.0; // of how far samples scatter: more is measured anew

// Moves the history by the predicted change, blended between the four nearest regions' models.
fn relight(pixel: vec2<u32>) -> Relit {
    let old = textureLoad(reprojected, pixel, 0);
    let old_noise = unpack_noise(textureLoad(reprojected_noise, pixel, 0));
    var relit = Relit(old, old_noise, min(old.w, frame.max_history), HALF_MAX);
    let surface = unpack_surface(textureLoad(guide, pixel, 0));
    if is_miss(surface) || old.w <= 0.0 {
        return relit;
    }
    let z = surface_features(surface, position_of(frame, frame.current, vec2<f32>(pixel), surface.depth));
    let place = (vec2<f32>(pixel) + 0.5) / f32(REGION) - 0.5;
    let corner = vec2<i32>(floor(place));
    let f = place - floor(place);
    var sum = vec4(0.0); // change; weight
    var spread = 0.0;    // what a sample may differ by
    for (var i = 0; i < 4; i++) {
        let step = vec2(i & 1, i >> 1u);
        let region = corner + step;
        if any(region < vec2(0)) || any(region >= vec2<i32>(frame.regions)) {
            continue;
        }
        let start = (u32(region.y) * frame.regions.x + u32(region.x)) * INNOVATION_STRIDE;
        let samples = innovations[start + INNOVATION_SAMPLES];
        if samples > 0.0 {
            let sides = select(1.0 - f, f, step == vec2(1));
            let weight = sides.x * sides.y;
            sum += weight * vec4(predicted_change(start, z), 1.0);
            spread += weight * sqrt(samples * innovations[start + INNOVATION_VARIANCE]);
        }
    }
    if sum.w <= 0.0 {
        return relit;
    }
    let moved = max(old.rgb + sum.rgb / sum.w, vec3(0.0));
    let change = luminance(moved) - luminance(old.rgb);
    let gain = clamp(luminance(moved) / max(luminance(old.rgb), 1e-6), 0.0, MOST_BRIGHTENING);
    // Kalman: the more a sample would have moved the history, the less the history is worth.
    let doubt = KALMAN_GAIN * old.w * change * change / max(old_noise.variance, 1e-12);
    relit.history = vec4(moved, old.w / (1.0 + doubt));
    relit.noise.variance = gain * gain * old_noise.variance;
    if spread > 0.0 {
        // Where history never varied, as in darkness, nothing tells a firefly from light.
        relit.most = luminance(moved) + frame.firefly_limit * spread / sum.w;
    }
    return relit;
}

fn predicted_change(start: u32, z: array<f32, FEATURES>) -> vec3<f32> {
    var change = innovation_vector(start + INNOVATION_MEAN + FEATURES);
    for (var i = 0u; i < FEATURES; i++) {
        change += (z[i] - innovations[start + INNOVATION_MEAN + i])
            * innovation_vector(start + INNOVATION_SLOPE + i * CHANNELS);
    }
    return change;
}

fn innovation_vector(at: u32) -> vec3<f32> {
    return vec3(innovations[at], innovations[at + 1u], innovations[at + 2u]);
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
