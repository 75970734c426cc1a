// gains: what a model of its own may gain each tile of a level that coarser ones do not cover well; and whether the model that
// it had in the frame before still holds. Runs under a budget only; `choose` then spends it.
//
// Reads   coverage, moments, models.
// Writes  kept (layout: include/models); histogram: tiles by their gain; models: the kept ones, moved along with the camera
// Source  Moon et al. 2015, section 4.3, places models where the error is large; squared errors from moments: section 4.2

//!include frame numbers surface features linear_model windows models

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<uniform> level: vec4<u32>; // its number in x
@group(0) @binding(2) var<storage, read> coverage: array<u32>;
@group(0) @binding(3) var<storage, read> moments: array<vec4<f32>>;
@group(0) @binding(4) var<storage, read_write> models: array<vec4<f32>>;
@group(0) @binding(5) var<storage, read_write> kept: array<u32>;
@group(0) @binding(6) var<storage, read_write> histogram: array<atomic<u32>>;

const OWN_FEATURES = MODEL_OWN_FEATURES;
const LANES = 64u;

// A kept model holds while its squared error on the tile is at most this many times what it had predicted, noise included,
// as far as the errors of tiles of one model scatter; and while the tile's mean is within three standard errors, in which a
// new light shows although single pixels are noisy.
const KEPT_ERROR = 2.0;
const KEPT_MEAN_ERROR = 9.0;
// Frames after which it is dropped all the same: half the default history, over which the means that it was fitted to have
// been replaced.
const KEPT_FRAMES = 16u;

// The least gain that is told apart, and how finely.
const LEAST_GAIN = 1e-12;
const BUCKETS_AN_OCTAVE = 16.0;
const DARK = 1e-2; // squared luminance below which an error counts absolutely
const LEAST_EXCESS = 0.02; // of the noise

// Of each lane's model: its error in luminance, as a linear form of the columns.
var<workgroup> form: array<array<f32, LANES>, COLUMNS>;

@compute @workgroup_size(8, 8)
fn gains(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let own = frame.levels[level.x];
    let tile = id.xy * own.stride + own.stride / 2u;
    if any(tile >= frame.tiles) {
        return;
    }
    let index = tile.y * frame.tiles.x + tile.x;
    let start = index * TILE_STRIDE;
    var entry = 0u;
    // A tile without samples is left to the coarsest models, a tile of one of these to it.
    if coverage[index] < own.covered && moments[start][TILE_WEIGHT] > 0.0 && any(tile != coarsest_centre(frame, tile)) {
        entry = candidate(tile, index, lane);
    }
    kept[index] = entry;
}

fn candidate(tile: vec2<u32>, index: u32, lane: u32) -> u32 {
    let start = index * TILE_STRIDE;
    let before = kept[index] & ((1u << KEPT_BITS) - 1u);
    let age = (before >> WINDOW_BITS) + 1u;
    var entry = 0u;
    var error = 0.0;
    var urgency = 1.0;
    if before != 0u && age <= KEPT_FRAMES && follow(index * MODEL_STRIDE, start) {
        let errors = tile_errors(index * MODEL_STRIDE, start, lane);
        let expected = models[index * MODEL_STRIDE][HEAD_ERROR];
        let found = moments[start][TILE_FOUND];
        error = errors.x;
        if errors.x <= KEPT_ERROR * (expected + found)
            && errors.y <= KEPT_ERROR * expected + KEPT_MEAN_ERROR * found / pixels_of(start) {
            entry = stored_window(before) | (age << WINDOW_BITS);
            urgency = f32(age);
        }
    }
    if entry == 0u {
        let coarsest = coarsest_centre(frame, tile);
        error = tile_errors((coarsest.y * frame.tiles.x + coarsest.x) * MODEL_STRIDE, start, lane).x;
    }
    // So that equal gains take turns.
    let jitter = 0.75 + 0.5 * random_unit(random_at(tile, frame.index));
    let octave = log2(max(gain(error, start) * urgency * jitter, LEAST_GAIN) / LEAST_GAIN);
    let bucket = 1u + min(u32(octave * BUCKETS_AN_OCTAVE), BUCKETS - 2u);
    atomicAdd(&histogram[level.x * BUCKETS + bucket], 1u);
    return entry | (bucket << KEPT_BITS);
}

// Relative squared error beyond noise, times the pixels that have it.
fn gain(error: f32, start: u32) -> f32 {
    let found = moments[start][TILE_FOUND];
    var colour: vec3<f32>;
    for (var c = 0u; c < CHANNELS; c++) {
        colour[c] = tile_mean(start, FEATURES + c);
    }
    let l = luminance(colour);
    let excess = max(error - found, LEAST_EXCESS * found);
    return excess / (l * l + DARK) * pixels_of(start);
}

// Pixels with samples in a tile: as many as would weigh as much with the mean number of samples, the ratio of both variances.
fn pixels_of(start: u32) -> f32 {
    let variance = max(moments[start][TILE_VARIANCE], 1e-30);
    return clamp(moments[start][TILE_WEIGHT] * moments[start][TILE_EXPECTED] / variance, 1.0, f32(TILE * TILE));
}

// Mean squared error of a model's luminance on a tile, and the squared error of the mean. The error is a linear form of the
// columns, so its square needs first and second moments only.
fn tile_errors(model: u32, start: u32, lane: u32) -> vec2<f32> {
    var residual = -luminance_of(model, 0u);
    for (var f = 0u; f < FEATURES; f++) {
        form[f][lane] = -luminance_of(model, f + 1u);
    }
    for (var c = 0u; c < CHANNELS; c++) {
        form[FEATURES + c][lane] = LUMINANCE[c];
    }
    var sum = 0.0;
    var entry = 0u;
    for (var i = 0u; i < COLUMNS; i++) {
        residual += form[i][lane] * tile_mean(start, i);
        var row = 0.5 * form[i][lane] * tile_square(start, entry);
        entry++;
        for (var j = i + 1u; j < COLUMNS; j++) {
            row += form[j][lane] * tile_square(start, entry);
            entry++;
        }
        sum += 2.0 * form[i][lane] * row;
    }
    let of_mean = residual * residual;
    return vec2(max(sum, 0.0) / moments[start][TILE_WEIGHT] + of_mean, of_mean);
}

fn tile_mean(start: u32, column: u32) -> f32 {
    return moments[start + 1u + column / 4u][column % 4u];
}

// By its place in the triangle.
fn tile_square(start: u32, entry: u32) -> f32 {
    return moments[start + 1u + MEAN_QUADS + entry / 4u][entry % 4u];
}

// Of what a model multiplies regressor `at` with.
fn luminance_of(model: u32, at: u32) -> f32 {
    var sum = 0.0;
    for (var c = 0u; c < CHANNELS; c++) {
        sum += LUMINANCE[c] * models[model + 1u + c * MODEL_ROW + at / 4u][at % 4u];
    }
    return sum;
}

// Moves a model to where the camera is now: positions are relative to the eye, and pixels moved as the tile's middle did. Once a
// frame: `kept` forgets what did not hold. Tells whether that could be told.
fn follow(model: u32, start: u32) -> bool {
    let position = vec3(tile_mean(start, 3u), tile_mean(start, 4u), tile_mean(start, 5u));
    let now = project(frame.current, position);
    let before = project(frame.previous, position + frame.eye_delta);
    if now.z <= 0.0 || before.z <= 0.0 {
        return false;
    }
    let moved_px = (before.xy - now.xy) * frame.current.size - (frame.previous.jitter - frame.current.jitter);
    for (var c = 0u; c < CHANNELS; c++) {
        let row = model + 1u + c * MODEL_ROW;
        models[row].x += dot(models[row + 1u].xyz, frame.eye_delta) + dot(models[row + 2u].zw, moved_px);
    }
    return true;
}
