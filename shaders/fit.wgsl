// fit: one linear model per centre, from the moments of the tiles in its window.
//
// Reads   tile_means, tile_squares_low, tile_squares_high.
// Writes  models (layout: include/features)
// Source  Moon et al. 2015, section 4, with the recursion over pixels replaced by the equal sum of tile moments; merging
//         moments about different means: Chan, Golub and LeVeque 1979

//!include frame numbers surface features ridge

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> tile_means: array<f32>;
@group(0) @binding(2) var<storage, read> tile_squares_low: array<f32>;
@group(0) @binding(3) var<storage, read> tile_squares_high: array<f32>;
@group(0) @binding(4) var<storage, read_write> models: array<f32>;

const MAX_WINDOW_TILES = 49u; // 7x7

var<workgroup> window: array<array<f32, TILE_STRIDE>, MAX_WINDOW_TILES>; // weights already by variance
var<workgroup> window_tiles: array<u32, MAX_WINDOW_TILES>;
var<workgroup> means: array<f32, COLUMNS>;

// How much more a noiseless tile may count than the window's average one: a variance from few samples may be 0 by luck.
const VARIANCE_FLOOR = 0.1;
// Variance of one sample over its squared mean that is believed; more comes of windows that are all but black.
const MOST_NOISE = 1e3;

@compute @workgroup_size(64)
fn fit(@builtin(workgroup_id) centre: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let side = 2u * frame.window_radius + 1u;
    let tile_count = side * side;
    load_tile(centre.xy, side, lane);
    workgroupBarrier();
    // Of one sample, over the window.
    let variance = window_mean(TILE_VARIANCE, window_weight(tile_count), tile_count);
    workgroupBarrier(); // all have read the weights that are now replaced
    weigh_tile(variance, tile_count, lane);
    workgroupBarrier();
    let weight = window_weight(tile_count);
    if lane < COLUMNS {
        means[lane] = window_mean(TILE_MEAN + lane, weight, tile_count);
    }
    workgroupBarrier();
    for (var entry = lane; entry < SQUARES; entry += RIDGE_LANES) {
        ridge_squares[entry] = window_square(entry, tile_count);
    }
    if lane < FEATURES {
        let distance = length(vec3(means[3], means[4], means[5]));
        ridge_floors[lane] = feature_floor(lane, distance);
        // Noise of one sample over the prior's variance, that of a slope of the mean colour per unit.
        let unit = feature_unit(lane, distance, window_reach(frame));
        ridge_priors[lane] = relative_noise(variance) * unit * unit;
    }
    workgroupBarrier();
    // An empty window solves a harmless system instead of leaving uniform control flow.
    ridge_solve(select(1.0, weight, weight > 0.0), lane);
    let start = (centre.y * frame.centres.x + centre.x) * MODEL_STRIDE;
    if lane == 0u {
        let found = window_mean(TILE_FOUND, weight, tile_count);
        let expected = window_mean(TILE_EXPECTED, weight, tile_count);
        models[start + MODEL_WEIGHT] = weight;
        models[start + MODEL_NOISE_GAIN] = noise_gain(found, expected);
        models[start + MODEL_RELATIVE_NOISE] = relative_noise(variance);
        models[start + MODEL_TRUST] = trust(found * weight);
    }
    write_coefficients(start, lane);
}

// Tiles outside the frame stay, with weight 0, so that all windows have one shape.
fn load_tile(centre: vec2<u32>, side: u32, lane: u32) {
    if lane >= side * side {
        return;
    }
    let tile = vec2<i32>(centre * CENTRE_STRIDE) + vec2<i32>(vec2(lane % side, lane / side))
        - vec2(i32(frame.window_radius));
    if any(tile < vec2(0)) || any(tile >= vec2<i32>(frame.tiles)) {
        window_tiles[lane] = 0u;
        for (var i = 0u; i < TILE_STRIDE; i++) {
            window[lane][i] = 0.0;
        }
        return;
    }
    let index = u32(tile.y) * frame.tiles.x + u32(tile.x);
    window_tiles[lane] = index;
    for (var i = 0u; i < TILE_STRIDE; i++) {
        window[lane][i] = tile_means[index * TILE_STRIDE + i];
    }
}

// Inverse-variance weighting by tiles; the variance slot then holds the factor.
fn weigh_tile(variance: f32, tile_count: u32, lane: u32) {
    if lane < tile_count {
        let noise = window[lane][TILE_VARIANCE] / max(variance, 1e-30);
        let factor = (1.0 + VARIANCE_FLOOR) / (noise + VARIANCE_FLOOR);
        window[lane][TILE_VARIANCE] = factor;
        window[lane][TILE_WEIGHT] *= factor;
    }
}

fn window_weight(tile_count: u32) -> f32 {
    var weight = 0.0;
    for (var t = 0u; t < tile_count; t++) {
        weight += window[t][TILE_WEIGHT];
    }
    return weight;
}

// Weighted mean of one of the tiles' entries.
fn window_mean(entry: u32, weight: f32, tile_count: u32) -> f32 {
    var sum = 0.0;
    for (var t = 0u; t < tile_count; t++) {
        sum += window[t][TILE_WEIGHT] * window[t][entry];
    }
    return select(0.0, sum / weight, weight > 0.0);
}

// Variance of one sample over its squared mean.
fn relative_noise(variance: f32) -> f32 {
    let colour = luminance(vec3(means[FEATURES], means[FEATURES + 1u], means[FEATURES + 2u]));
    return min(variance / max(colour * colour, 1e-12), MOST_NOISE);
}

// How much less the temporal means vary than as many independent samples would: resampling averages over neighbours, and
// an exponential mean of length n over more than n samples.
fn noise_gain(found: f32, expected: f32) -> f32 {
    return select(1.0, clamp(found / expected, 0.0, 1.0), expected > 0.0);
}

const LEAST_TRUST = 1e-4; // where all models are bad, they still are compared

// Squared ratio of the temporal means' noise and the model's residual: 1 where it explains all but noise, less where an edge
// that no feature knows runs through the window. So pixels beside the edge are predicted by the models on their side.
fn trust(noise: f32) -> f32 {
    var residual = 0.0;
    for (var c = 0u; c < CHANNELS; c++) {
        for (var d = 0u; d < CHANNELS; d++) {
            residual += LUMINANCE[c] * LUMINANCE[d]
                * ridge_squares[square_index(FEATURES + min(c, d), FEATURES + max(c, d))];
        }
    }
    for (var i = 0u; i < FEATURES; i++) {
        var slope = 0.0;
        var product = 0.0;
        for (var c = 0u; c < CHANNELS; c++) {
            slope += LUMINANCE[c] * ridge_slopes[i][c];
            product += LUMINANCE[c] * ridge_squares[square_index(i, FEATURES + c)];
        }
        residual -= slope * product;
    }
    let fit = clamp(noise / max(residual, 1e-20), LEAST_TRUST, 1.0);
    return fit * fit;
}

// Squares of the window about its mean: those of its tiles about theirs, plus those of the tiles' means.
fn window_square(entry: u32, tile_count: u32) -> f32 {
    let ij = square_entry(entry);
    var sum = 0.0;
    for (var t = 0u; t < tile_count; t++) {
        if window[t][TILE_WEIGHT] > 0.0 {
            let di = window[t][TILE_MEAN + ij.x] - means[ij.x];
            let dj = window[t][TILE_MEAN + ij.y] - means[ij.y];
            sum += window[t][TILE_VARIANCE] * tile_square(window_tiles[t], entry)
                + window[t][TILE_WEIGHT] * di * dj;
        }
    }
    return sum;
}

fn tile_square(tile: u32, entry: u32) -> f32 {
    if entry < HALF_SQUARES {
        return tile_squares_low[tile * HALF_SQUARES + entry];
    }
    return tile_squares_high[tile * HALF_SQUARES + entry - HALF_SQUARES];
}

fn write_coefficients(start: u32, lane: u32) {
    if lane < COLUMNS {
        models[start + MODEL_MEAN + lane] = means[lane];
    }
    if lane < FEATURES * CHANNELS {
        models[start + MODEL_SLOPE + lane] = ridge_slopes[lane / CHANNELS][lane % CHANNELS];
    }
}
