// innovation: predicts the change of the light from the change of the samples, linear models at every other tile.
//
// Reads   moments, of the change.
// Writes  innovations (layout: include/innovations)
// Source  Kalman, "A New Approach to Linear Filtering and Prediction Problems", 1960; shrinkage: James and Stein 1961; its
//         threshold: Laurent and Massart, "Adaptive Estimation of a Quadratic Functional by Model Selection", 2000, lemma 1

//!include frame numbers surface features linear_model innovations windows window ridge

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> moments: array<vec4<f32>>;
@group(0) @binding(2) var<storage, read_write> innovations: array<vec4<f32>>;

const OWN_FEATURES = INNOVATION_OWN_FEATURES;
const LANES = 32u;
const RIDGE = 0.3; // of the total weight: a few pixels with features of their own are no light
// Deviation of a feature that counts, in its units: as where a tenth of the pixels differ by one. With less, single bright
// samples on the few would be a change of the light.
const LEAST_VARIATION = 0.3;
// What stands in the noises of a tile of changes.
const TILE_HISTORY = TILE_FOUND;   // luminance of the history
const TILE_LENGTH = TILE_EXPECTED; // samples in it

var<workgroup> means: array<f32, TILE_SQUARES>;
var<workgroup> significance: f32;

@compute @workgroup_size(LANES)
fn innovation(@builtin(workgroup_id) centre: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let samples = load_window(centre.xy * innovation_tiles(frame), MOST_TILES, lane);
    // An empty window solves a harmless system instead of leaving uniform control flow.
    let weight = select(1.0, window_weight(0u, MOST_TILES), samples > 0.0);
    if lane < TILE_SQUARES {
        means[lane] = window_moment(lane, 0u, MOST_TILES) / weight; // of columns: about the origin
    }
    workgroupBarrier();
    if lane < SQUARE_QUADS {
        let places = square_quad(lane);
        var of_means: vec4<f32>;
        for (var i = 0u; i < 4u; i++) {
            of_means[i] = means[TILE_MEAN + places.rows[i]] * means[TILE_MEAN + places.columns[i]];
        }
        ridge_squares[lane] = window_squares(lane, places, 0u, MOST_TILES) - weight * of_means;
    }
    workgroupBarrier();
    let depth = length(vec3(column_mean(3u), column_mean(4u), column_mean(5u)));
    let level = light_level();
    if lane < FEATURES {
        // Noise of one sample over the prior's variance: that of a change of as much as there is, per unit.
        let unit = feature_unit(lane, depth);
        ridge_floors[lane] = LEAST_VARIATION * unit;
        ridge_priors[lane] = means[TILE_VARIANCE] / (level * level) * unit * unit;
    }
    workgroupBarrier();
    ridge_solve(weight, lane);
    if lane == 0u {
        significance = significant_share(samples, weight);
    }
    workgroupBarrier();
    write_model((centre.y * innovation_centres(frame).x + centre.x) * MODEL_STRIDE, samples, lane);
}

fn column_mean(column: u32) -> f32 {
    return origin_of(column) + means[TILE_MEAN + column];
}

fn mean_change() -> vec3<f32> {
    return vec3(column_mean(FEATURES), column_mean(FEATURES + 1u), column_mean(FEATURES + 2u));
}

// The larger of the light before and after.
fn light_level() -> f32 {
    let before = means[TILE_HISTORY];
    return max(max(before, before + luminance(mean_change())), 1e-6);
}

// How much of the found change is no chance: 1 - (T / E)^2, with E the change that the model explains, in variances of a
// sample, and T what noise alone explains by as many unknowns once in as many frames as the history is long. Squared, because
// 1 - T / E would leave a tenth of a light that went as a ghost where E is ten times T.
fn significant_share(samples: f32, weight: f32) -> f32 {
    let of_mean = luminance(mean_change());
    let change = weight * of_mean * of_mean;
    var explained = change;
    let unknowns = f32(FEATURES + 1u);
    for (var i = 0u; i < FEATURES; i++) {
        explained += luminance_slope(i) * luminance_product(i);
    }
    let total = luminance_square();
    let residual = max(total + change - explained, 0.0) / max(samples - unknowns, 1.0);
    // Not less than what the history knows: where no sample of a frame saw the light, it varies by nothing.
    let expected = means[TILE_VARIANCE] * (1.0 + 1.0 / max(means[TILE_LENGTH], 1.0)) * weight / max(samples, 1e-30);
    let variance = max(residual, expected);
    let x = log(1.0 + means[TILE_LENGTH]);
    let chance = unknowns + 2.0 * sqrt(unknowns * x) + 2.0 * x;
    if !has(frame, FLAG_INNOVATION) || samples <= unknowns || explained <= 0.0 {
        return 0.0;
    }
    let doubt = chance * variance / explained;
    return max(1.0 - doubt * doubt, 0.0);
}

// In luminance: what the system has on its right side, and the square that is to be explained.
fn luminance_product(feature: u32) -> f32 {
    var sum = 0.0;
    for (var c = 0u; c < CHANNELS; c++) {
        sum += LUMINANCE[c] * ridge_square(feature, FEATURES + c);
    }
    return sum;
}

fn luminance_square() -> f32 {
    var sum = 0.0;
    for (var c = 0u; c < CHANNELS; c++) {
        for (var d = 0u; d < CHANNELS; d++) {
            sum += LUMINANCE[c] * LUMINANCE[d] * ridge_square(FEATURES + min(c, d), FEATURES + max(c, d));
        }
    }
    return sum;
}

fn write_model(start: u32, samples: f32, lane: u32) {
    if lane == 0u {
        innovations[start] = vec4(samples, means[TILE_VARIANCE], significance, 0.0);
    }
    if lane < CHANNELS * MODEL_ROW {
        innovations[start + 1u + lane] = significance * model_part(lane / MODEL_ROW, lane % MODEL_ROW);
    }
}
