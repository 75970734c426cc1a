// compose: mixes prediction and temporal mean by their estimated errors, and makes radiance of it again.
//
// Reads   guide, prediction, history, noise; the caller's albedo, emission; rest: what the other signal came to, where this is
//         the specular one.
// Writes  output: the caller's image, or rest, with its expected error in w
//         error: the output's expected error (layout: include/error), where somebody asks for it
//         mix_weight: share of the temporal mean, where a debug view shows it
// Source  shrinkage towards a model by estimated risk: James and Stein, "Estimation with Quadratic Loss", 1961

//!include frame numbers noise surface demodulate features models error

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var guide: texture_2d<u32>;
@group(0) @binding(2) var prediction: texture_2d<u32>;
@group(0) @binding(3) var history: texture_2d<f32>;
@group(0) @binding(4) var noise: texture_2d<u32>;
@group(0) @binding(5) var albedo: texture_2d<f32>;
@group(0) @binding(6) var emission: texture_2d<f32>;
@group(0) @binding(7) var rest: texture_2d<f32>;
@group(0) @binding(8) var output: texture_storage_2d<rgba16float, write>;
@group(0) @binding(9) var error: texture_storage_2d<r32uint, write>;
@group(0) @binding(10) var mix_weight: texture_storage_2d<r32uint, write>;

const OWN_FEATURES = MODEL_OWN_FEATURES;
const SMOOTH_RADIUS = 1; // pixels; a model's error is smooth over 3x3, noise is not
const POOL_RADIUS = 2;   // pixels; squares are pooled over 5x5
// Pooled smooth noise is twice what is expected of it once in some ten pixels: 25 that overlap are about as good as 5.
const CHANCE = 2.0;
const GLOSSY = 0.5; // roughness below which no feature tells what a surface shows
const BORDER = SMOOTH_RADIUS + POOL_RADIUS;
const POOL_SIDE = 8 + 2 * POOL_RADIUS;
const SIDE = 8 + 2 * BORDER;
const CELLS = SIDE * SIDE;

// A pixel and its border, read once by the workgroup.
var<workgroup> surfaces: array<vec2<u32>, CELLS>;  // as in the guide; a miss, too, what lies outside or has no samples
var<workgroup> residuals: array<vec2<u32>, CELLS>; // temporal mean minus prediction; the mean's deviations: as half floats
var<workgroup> variances: array<vec2<f32>, CELLS>; // of the temporal mean: as expected, as found
var<workgroup> smoothed: array<vec2<f32>, CELLS>;  // squares of the residual and of the deviations, smoothed over 3x3

@compute @workgroup_size(8, 8)
fn compose(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let corner = vec2<i32>(group.xy * 8u) - BORDER;
    for (var cell = i32(lane); cell < CELLS; cell += 64) {
        load_cell(cell, corner + place_of(cell));
    }
    workgroupBarrier();
    for (var i = i32(lane); i < POOL_SIDE * POOL_SIDE; i += 64) {
        smooth_cell(corner, vec2(i % POOL_SIDE, i / POOL_SIDE) + SMOOTH_RADIUS);
    }
    workgroupBarrier();
    if any(id.xy >= frame.size) {
        return;
    }
    let mean = textureLoad(history, id.xy, 0);
    let surface = unpack_surface(textureLoad(guide, id.xy, 0).xy);
    if is_miss(surface) {
        show(id.xy, mean.rgb, 0.0, 1.0);
        return;
    }
    let predicted = unpack_prediction(textureLoad(prediction, id.xy, 0).xy);
    let place = vec2<i32>(local.xy) + BORDER;
    let found = temporal_mix(middle_of(surface, corner, place), corner, place, predicted, mean);
    let reflectance = demodulator_at(id.xy, surface);
    var composed = mix(predicted.signal, mean.rgb, found.share) * reflectance;
    if has(frame, FLAG_EMISSION) && !IS_SPECULAR {
        composed += repair_emission(textureLoad(emission, frame.origin + id.xy, 0).rgb);
    }
    show(id.xy, composed, sqrt(found.square) * luminance(reflectance), found.share);
}

fn show(pixel: vec2<u32>, found: vec3<f32>, found_deviation: f32, share: f32) {
    var radiance = found;
    var deviation = found_deviation;
    if IS_SPECULAR {
        let other = textureLoad(rest, pixel, 0);
        radiance += other.rgb;
        deviation = length(vec2(deviation, other.w));
    }
    let is_rest = has(frame, FLAG_SPLIT) && !IS_SPECULAR;
    let alpha = select(1.0, min(deviation, HALF_MAX), is_rest);
    let texel = select(frame.origin, vec2(0u), is_rest) + pixel; // the rest is no image of the caller's
    let composed = vec4(min(radiance, vec3(HALF_MAX)), alpha);
    // A store may round either way; some drivers always cut off.
    let rounded = vec4(unpack2x16float(pack2x16float(composed.rg)), unpack2x16float(pack2x16float(composed.ba)));
    textureStore(output, texel, rounded);
    if has(frame, FLAG_ERROR) {
        textureStore(error, pixel, vec4(pack_error(OutputError(deviation, luminance(radiance)))));
    }
    if has(frame, FLAG_SHOW_MIX) {
        textureStore(mix_weight, pixel, vec4(bitcast<u32>(share)));
    }
}

fn place_of(cell: i32) -> vec2<i32> {
    return vec2(cell % SIDE, cell / SIDE);
}

fn load_cell(cell: i32, pixel: vec2<i32>) {
    surfaces[cell] = vec2(0u);
    if !inside(pixel, frame.current) {
        return;
    }
    let words = textureLoad(guide, pixel, 0).xy;
    let mean = textureLoad(history, pixel, 0);
    let predicted = unpack_prediction(textureLoad(prediction, pixel, 0).xy);
    if mean.w <= 0.0 || !is_known(predicted) {
        return;
    }
    surfaces[cell] = words;
    let own = unpack_noise(textureLoad(noise, pixel, 0).x, mean.w);
    let expected = standard_error(predicted, own.variance, mean.w);
    variances[cell] = vec2(expected * expected, found_variance(own.deviations));
    let values = clamp(
        vec4(luminance(mean.rgb) - luminance(predicted.signal), own.deviations),
        vec4(-HALF_MAX),
        vec4(HALF_MAX),
    );
    residuals[cell] = vec2(pack2x16float(values.xy), pack2x16float(values.zw));
}

// The surface in the middle of what is summed.
struct Middle {
    surface: Surface,
    position: vec3<f32>,
}

fn middle_of(surface: Surface, corner: vec2<i32>, place: vec2<i32>) -> Middle {
    return Middle(surface, position_of(frame.current, vec2<f32>(corner + place), surface.depth));
}

// Whether a cell shows the same surface and has samples.
fn related(middle: Middle, corner: vec2<i32>, place: vec2<i32>) -> bool {
    let other = unpack_surface(surfaces[place.y * SIDE + place.x]);
    let position = position_of(frame.current, vec2<f32>(corner + place), other.depth);
    return same_surface(middle.surface, other, position - middle.position);
}

fn smooth_cell(corner: vec2<i32>, place: vec2<i32>) {
    let middle = middle_of(unpack_surface(surfaces[place.y * SIDE + place.x]), corner, place);
    var sum = vec4(0.0);
    var count = 0.0;
    for (var y = -SMOOTH_RADIUS; y <= SMOOTH_RADIUS; y++) {
        for (var x = -SMOOTH_RADIUS; x <= SMOOTH_RADIUS; x++) {
            let tap = place + vec2(x, y);
            if related(middle, corner, tap) {
                let words = residuals[tap.y * SIDE + tap.x];
                sum += vec4(unpack2x16float(words.x), unpack2x16float(words.y));
                count += 1.0;
            }
        }
    }
    let mean = sum / max(count, 1.0);
    smoothed[place.y * SIDE + place.x] = vec2(mean.x * mean.x, found_variance(mean.yzw));
}

struct Mix {
    share: f32,  // of the temporal mean
    square: f32, // expected squared error
}

// How much of the mean's variance is left in a model that is fitted to the least window: its coefficients over the pixels.
const MODEL_SHARE = f32(FEATURES + 1u) / f32(5u * TILE * TILE);

// What is left of the mean's noise, the model's error, and the noise that the model has of its own.
fn mixed(share: f32, model_error: f32, variance: f32) -> Mix {
    let rest = 1.0 - share;
    return Mix(share, share * share * variance + rest * (rest * model_error + MODEL_SHARE * variance));
}

// The temporal mean differs from the prediction by the model's error and by its own noise. The best mix gives it the share
// B / (B + V), with B the model's squared error and V the mean's variance. B is what the smoothed residuals have more of than
// the smoothed deviations, which hold noise alone, blended and resampled like the mean's. All are pooled: a pixel's own
// variance is low just where its samples happen to be dark, and would keep them so.
fn temporal_mix(middle: Middle, corner: vec2<i32>, place: vec2<i32>, predicted: Prediction, mean: vec4<f32>) -> Mix {
    var squares = vec2(0.0); // squares of residuals and of deviations
    var variance = vec2(0.0);
    var pooled = 0.0;
    for (var y = -POOL_RADIUS; y <= POOL_RADIUS; y++) {
        for (var x = -POOL_RADIUS; x <= POOL_RADIUS; x++) {
            let tap = place + vec2(x, y);
            if related(middle, corner, tap) {
                squares += smoothed[tap.y * SIDE + tap.x];
                variance += variances[tap.y * SIDE + tap.x];
                pooled += 1.0;
            }
        }
    }
    // Without any model near, the temporal mean is all there is.
    var share = select(1.0, 0.0, is_known(predicted));
    if pooled == 0.0 {
        // Nothing is known of the error: as good as one sample.
        let l = luminance(select(mean.rgb, predicted.signal, is_known(predicted)));
        return Mix(share, max(predicted.relative_noise, 1.0) * l * l);
    }
    // Samples of a mirror also scatter by what passes in it: what is expected of them is too much.
    let noise = select(max(variance.x, variance.y), variance.y, IS_SPECULAR);
    let beyond = max(squares.x - CHANCE * squares.y, 0.0);
    // Firmer than the plain difference: what is hardly beyond chance is chance more often than not.
    var error = beyond * beyond / max(squares.x, 1e-30);
    if IS_SPECULAR || (!has(frame, FLAG_SPLIT) && middle.surface.roughness < GLOSSY) {
        // Where reflections are seen, models err more often than not.
        error = max(squares.x - squares.y, 0.0);
    }
    if has(frame, FLAG_MIX) && error > 0.0 && mean.w > 0.0 && is_known(predicted) {
        // A pixel alone says nothing about the model.
        share = error / (error + noise) * (1.0 - 1.0 / (pooled * pooled));
    }
    return mixed(share, error / pooled, noise / pooled);
}
