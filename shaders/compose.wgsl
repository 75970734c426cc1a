// compose: mixes prediction and temporal mean by their estimated errors, and makes radiance of it again.
//
// Reads   guide, prediction, history, noise; the caller's radiance (at misses), albedo, emission.
// Writes  output: the caller's image; mix_weight: share of the temporal mean
// Source  shrinkage towards a model by estimated risk: James and Stein, "Estimation with Quadratic Loss", 1961

//!include frame numbers noise surface demodulate

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var guide: texture_2d<u32>;
@group(0) @binding(2) var prediction: texture_2d<f32>;
@group(0) @binding(3) var history: texture_2d<f32>;
@group(0) @binding(4) var noise: texture_2d<f32>;
@group(0) @binding(5) var radiance: texture_2d<f32>;
@group(0) @binding(6) var albedo: texture_2d<f32>;
@group(0) @binding(7) var emission: texture_2d<f32>;
@group(0) @binding(8) var output: texture_storage_2d<rgba16float, write>;
@group(0) @binding(9) var mix_weight: texture_storage_2d<r32float, write>;

const SMOOTH_RADIUS = 1; // pixels; a model's error is smooth over 3x3, noise is not
const POOL_RADIUS = 2;   // pixels; squares are pooled over 5x5
const CHANCE = 1.5;      // pooled smooth noise deviates by about as much as it is
const BORDER = SMOOTH_RADIUS + POOL_RADIUS;
const POOL_SIDE = 8 + 2 * POOL_RADIUS;
const SIDE = 8 + 2 * BORDER;
const CELLS = SIDE * SIDE;

// A pixel and its border, read once by the workgroup. Depth 0 is a miss or lies outside the frame.
var<workgroup> normals: array<vec3<f32>, CELLS>;
var<workgroup> positions: array<vec3<f32>, CELLS>;
var<workgroup> depths: array<f32, CELLS>;
var<workgroup> ids: array<u32, CELLS>;
var<workgroup> variances: array<f32, CELLS>;       // of the temporal mean, as expected; < 0 without samples
var<workgroup> residuals: array<vec4<f32>, CELLS>; // temporal mean minus prediction; the mean's deviations
var<workgroup> smoothed: array<vec4<f32>, CELLS>;  // residuals, over 3x3

@compute @workgroup_size(8, 8)
fn compose(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    for (var cell = i32(lane); cell < CELLS; cell += 64) {
        load_cell(cell, vec2<i32>(group.xy * 8u) + vec2(cell % SIDE, cell / SIDE) - vec2(BORDER));
    }
    workgroupBarrier();
    for (var i = i32(lane); i < POOL_SIDE * POOL_SIDE; i += 64) {
        smooth_cell(vec2(i % POOL_SIDE, i / POOL_SIDE) + vec2(SMOOTH_RADIUS));
    }
    workgroupBarrier();
    if any(id.xy >= frame.size) {
        return;
    }
    let cell = (i32(local.y) + BORDER) * SIDE + i32(local.x) + BORDER;
    if depths[cell] <= 0.0 {
        let seen = textureLoad(radiance, id.xy, 0).rgb;
        let shown = clamp(select(vec3(0.0), seen, all_finite(seen)), vec3(0.0), vec3(HALF_MAX));
        textureStore(output, id.xy, vec4(shown, 1.0));
        textureStore(mix_weight, id.xy, vec4(1.0));
        return;
    }
    let share = temporal_share(cell);
    let filtered = mix(textureLoad(prediction, id.xy, 0).rgb, textureLoad(history, id.xy, 0).rgb, share);
    var composed = filtered * demodulator(textureLoad(albedo, id.xy, 0).rgb);
    if has(frame, FLAG_EMISSION) {
        composed += repair_emission(textureLoad(emission, id.xy, 0).rgb);
    }
    textureStore(output, id.xy, vec4(min(composed, vec3(HALF_MAX)), 1.0));
    textureStore(mix_weight, id.xy, vec4(share));
}

fn load_cell(cell: i32, pixel: vec2<i32>) {
    depths[cell] = 0.0;
    if !inside(pixel, frame) {
        return;
    }
    let surface = unpack_surface(textureLoad(guide, pixel, 0));
    normals[cell] = surface.normal;
    depths[cell] = surface.depth;
    ids[cell] = surface.id;
    positions[cell] = position_of(frame, frame.current, vec2<f32>(pixel), surface.depth);
    let predicted = textureLoad(prediction, pixel, 0);
    let mean = luminance(textureLoad(history, pixel, 0).rgb);
    variances[cell] = predicted.w * abs(predicted.w);
    residuals[cell] = vec4(mean - luminance(predicted.rgb), unpack_noise(textureLoad(noise, pixel, 0)).deviations);
}

// Whether the cells show one surface and both have samples.
fn related(a: i32, b: i32) -> bool {
    return depths[b] > 0.0
        && variances[b] >= 0.0
        && ids[a] == ids[b]
        && continues(normals[a], depths[a], normals[b], positions[b] - positions[a]);
}

fn smooth_cell(place: vec2<i32>) {
    let cell = place.y * SIDE + place.x;
    var sum = vec4(0.0);
    var count = 0.0;
    for (var y = -SMOOTH_RADIUS; y <= SMOOTH_RADIUS; y++) {
        for (var x = -SMOOTH_RADIUS; x <= SMOOTH_RADIUS; x++) {
            let tap = cell + y * SIDE + x;
            if related(cell, tap) {
                sum += residuals[tap];
                count += 1.0;
            }
        }
    }
    smoothed[cell] = sum / max(count, 1.0);
}

// The temporal mean differs from the prediction by the model's error and by its own noise. The best mix gives it the share
// B / (B + V), with B the model's squared error and V the mean's variance. B is what the smoothed residuals have more of than
// the smoothed deviations, which hold noise alone, blended and resampled like the mean's. All are pooled: a pixel's own
// variance is low just where its samples happen to be dark, and would keep them so.
fn temporal_share(cell: i32) -> f32 {
    if !has(frame, FLAG_MIX) || variances[cell] < 0.0 {
        return 0.0;
    }
    var smooth_residual = 0.0;
    var smooth_noise = 0.0;
    var expected = 0.0;
    var found = 0.0;
    var pooled = 0.0;
    for (var y = -POOL_RADIUS; y <= POOL_RADIUS; y++) {
        for (var x = -POOL_RADIUS; x <= POOL_RADIUS; x++) {
            let tap = cell + y * SIDE + x;
            if related(cell, tap) {
                smooth_residual += smoothed[tap].x * smoothed[tap].x;
                smooth_noise += CHANCE * found_variance(smoothed[tap].yzw);
                expected += variances[tap];
                found += found_variance(residuals[tap].yzw);
                pooled += 1.0;
            }
        }
    }
    if smooth_residual <= smooth_noise {
        return 0.0;
    }
    // Firmer than the plain difference: what is hardly beyond chance is chance more often than not.
    let beyond = smooth_residual - smooth_noise;
    let error = beyond * beyond / smooth_residual;
    // A pixel alone says nothing about the model.
    return error / (error + max(expected, found)) * (1.0 - 1.0 / pooled);
}
