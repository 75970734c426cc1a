// compose: predicts every pixel by the models, mixes prediction and temporal mean by their estimated errors, and makes radiance of
// it again.
//
// Reads   guide, models, windows, history, noise; the caller's albedo, emission; rest: what the other signal came to, where this
//         is the specular one.
// Writes  output: the caller's image, or rest, with its expected error in w
//         error: the output's expected error (layout: include/error), where somebody asks for it
//         prediction (layout: include/models), mix_weight: share of the temporal mean; where a debug view shows them
// Source  shrinkage towards a model by estimated risk: James and Stein, "Estimation with Quadratic Loss", 1961

//!include frame numbers noise surface demodulate features linear_model windows models prediction error

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var guide: texture_2d<u32>;
@group(0) @binding(2) var<storage, read> models: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> windows: array<u32>;
@group(0) @binding(4) var history: texture_2d<f32>;
@group(0) @binding(5) var noise: texture_2d<u32>;
@group(0) @binding(6) var albedo: texture_2d<f32>;
@group(0) @binding(7) var emission: texture_2d<f32>;
@group(0) @binding(8) var rest: texture_2d<f32>;
@group(0) @binding(9) var output: texture_storage_2d<rgba16float, write>;
@group(0) @binding(10) var error: texture_storage_2d<r32uint, write>;
@group(0) @binding(11) var prediction: texture_storage_2d<rg32uint, write>;
@group(0) @binding(12) var mix_weight: texture_storage_2d<r32uint, write>;

const OWN_FEATURES = MODEL_OWN_FEATURES;
const POOL_RADIUS = 2;   // pixels, as far as links reach; squares are pooled over 5x5
// Pooled smooth noise is twice what is expected of it once in some ten pixels: 25 that overlap are about as good as 5.
const CHANCE = 2.0;
const GLOSSY = 0.5; // roughness below which no feature tells what a surface shows
const GROUP = 16;
const CELLS = GROUP * GROUP;
const GROUP_TILES = u32(GROUP) / TILE;
const SLOT_BITS = 5u; // of an invocation: the slot that it looks at; above, for which tile
const_assert REACH_SLOTS <= 1u << SLOT_BITS && (GROUP_TILES * GROUP_TILES) << SLOT_BITS <= u32(CELLS);
const SHIFT_FRAMES = 16u;

var<workgroup> reaching: array<atomic<u32>, GROUP_TILES * GROUP_TILES>; // models that reach each tile (include/prediction)

// The workgroup's pixels, a cell for each invocation. What is no longer needed makes room for what comes next.
// surfaces: as in the guide, a miss outside of the frame; then sums of three residuals in a row; then of five squares
// residuals: temporal mean minus prediction, the mean's deviations, as half floats; then squares of both, smoothed over 3x3
var<workgroup> surfaces: array<vec2<u32>, CELLS>;
var<workgroup> residuals: array<vec2<u32>, CELLS>;
var<workgroup> deviations: array<u32, CELLS>; // of the temporal mean: as expected, as found; as half floats
var<workgroup> links: array<u32, CELLS>;
var<workgroup> row_counts: array<u32, CELLS>; // pixels with samples: in sums of three, then in those of five
var<workgroup> row_noises: array<u32, CELLS>; // deviations of five in a row, as half floats

// Bits of a link: which cells to the right and below show the same surface, none beyond the workgroup's; whether the cell itself has
// samples.
const RIGHT = 1u; // and twice as far: the next bit
const DOWN = 4u;  // likewise
const SAMPLED = 16u;

// Sums over a neighbourhood are sums of rows, each of the pixels that go with the one in the middle, where this goes with the
// middle of all: few pixels differ from those that go with the middle of all themselves. They end at the workgroup's border, which
// moves from time to time, so that its pixels, which know less of their neighbourhood, draw no lines.
@compute @workgroup_size(16, 16)
fn compose(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let cell = i32(lane);
    let place = vec2<i32>(local.xy);
    let corner = vec2<i32>(group.xy) * GROUP - group_shift(frame.index);
    let pixel = corner + place;
    let reached = find_models(corner / i32(TILE), vec2<u32>(place) / TILE, lane);
    let seen = see_pixel(pixel, reached);
    load_cell(cell, pixel, seen);
    workgroupBarrier();
    link_cell(cell, place, corner);
    workgroupBarrier();
    smooth_row(cell);
    workgroupBarrier();
    smooth_column(cell);
    workgroupBarrier();
    pool_row(cell);
    workgroupBarrier();
    if inside(pixel, frame.current) {
        compose_pixel(vec2<u32>(pixel), cell, seen);
    }
}

// How far the workgroups' grid lies to the left of the frame and above it: by no tile or one, each in turn. It stays for some frames:
// what moved in each of them would flicker.
fn group_shift(index: u32) -> vec2<i32> {
    let turn = index / SHIFT_FRAMES;
    return vec2<i32>(TILE * (vec2(turn ^ (turn >> 1u), turn >> 1u) % 2u));
}

// Which models reach the workgroup's tiles, of which the first is given: those that reach the invocation's own.
fn find_models(first: vec2<i32>, own: vec2<u32>, lane: u32) -> u32 {
    if lane < GROUP_TILES * GROUP_TILES {
        atomicStore(&reaching[lane], 0u);
    }
    workgroupBarrier();
    let tile = lane >> SLOT_BITS;
    if tile < GROUP_TILES * GROUP_TILES {
        let place = vec2<i32>(vec2(tile % GROUP_TILES, tile / GROUP_TILES));
        atomicOr(&reaching[tile], reaching_bit(first + place, lane & ((1u << SLOT_BITS) - 1u)));
    }
    workgroupBarrier();
    return atomicLoad(&reaching[own.y * GROUP_TILES + own.x]);
}

// What is known of a pixel.
struct Seen {
    words: vec2<u32>, // of the guide
    predicted: Prediction,
    mean: vec4<f32>,
}

fn see_pixel(at: vec2<i32>, reached: u32) -> Seen {
    var seen = Seen(vec2(0u), NO_PREDICTION, vec4(0.0));
    if !inside(at, frame.current) {
        return seen;
    }
    let pixel = vec2<u32>(at);
    seen.words = textureLoad(guide, pixel, 0).xy;
    seen.mean = textureLoad(history, pixel, 0);
    let surface = unpack_surface(seen.words);
    if !is_miss(surface) {
        seen.predicted = predict(pixel, surface, reached);
    }
    if has(frame, FLAG_DEBUG) {
        textureStore(prediction, pixel, vec4(pack_prediction(seen.predicted), 0u, 0u));
    }
    return seen;
}

fn compose_pixel(pixel: vec2<u32>, cell: i32, seen: Seen) {
    let mean = seen.mean;
    let surface = unpack_surface(seen.words);
    if is_miss(surface) {
        show(pixel, mean.rgb, 0.0, 1.0);
        return;
    }
    let predicted = seen.predicted;
    let found = temporal_mix(pool(cell), surface, predicted, mean);
    let reflectance = demodulator_at(pixel, surface);
    var composed = mix(predicted.signal, mean.rgb, found.share) * reflectance;
    if has(frame, FLAG_EMISSION) && !IS_SPECULAR {
        composed += repair_emission(textureLoad(emission, frame.origin + pixel, 0).rgb);
    }
    show(pixel, composed, sqrt(found.square) * luminance(reflectance), found.share);
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
    if has(frame, FLAG_DEBUG) {
        textureStore(mix_weight, pixel, vec4(bitcast<u32>(share)));
    }
}

fn load_cell(cell: i32, pixel: vec2<i32>, seen: Seen) {
    surfaces[cell] = seen.words;
    residuals[cell] = vec2(0u);
    deviations[cell] = 0u;
    links[cell] = 0u;
    if seen.mean.w <= 0.0 || !is_known(seen.predicted) {
        return;
    }
    links[cell] = SAMPLED;
    let own = unpack_noise(textureLoad(noise, pixel, 0).x, seen.mean.w);
    let expected = standard_error(seen.predicted, own.variance, seen.mean.w);
    deviations[cell] = pack_halves(vec2(expected, sqrt(found_variance(own.deviations))));
    let residual = luminance(seen.mean.rgb) - luminance(seen.predicted.signal);
    residuals[cell] = vec2(pack_halves(vec2(residual, own.deviations.x)), pack_halves(own.deviations.yz));
}

// A quarter of the largest half float at most, so that sums of three have room however they are rounded. What is below 6e-5 may be 0.
fn pack_halves(values: vec2<f32>) -> u32 {
    return pack2x16float(clamp(values, vec2(-HALF_MAX / 4.0), vec2(HALF_MAX / 4.0)));
}

fn link_cell(cell: i32, place: vec2<i32>, corner: vec2<i32>) {
    let own = unpack_surface(surfaces[cell]);
    if is_miss(own) {
        return;
    }
    let along = elevation_along(frame.current, own.normal);
    let level = elevation_of(along, vec2<f32>(corner + place), own.depth);
    var found = links[cell];
    for (var i = 0u; i < 4u; i++) {
        let reach = 1 + i32(i % 2u);
        let at = place + select(vec2(reach, 0), vec2(0, reach), i >= 2u);
        if all(at < vec2(GROUP)) {
            let other = unpack_surface(surfaces[at.y * GROUP + at.x]);
            let distance = elevation_of(along, vec2<f32>(corner + at), other.depth) - level;
            found |= select(0u, RIGHT << i, same_surface(own, other, distance, LINK_COSINE));
        }
    }
    links[cell] = found;
}

// Wider than NORMAL_COSINE: two links must hold where the middle of all would be compared once.
const LINK_COSINE = 0.8;

// Two cells are linked by a bit of the earlier one. A row's last cells have none to the right.
fn is_linked(earlier: i32, bit: u32) -> bool {
    return earlier >= 0 && (links[earlier] & bit) != 0u;
}

fn samples_of(cell: i32) -> u32 {
    return select(0u, 1u, is_linked(cell, SAMPLED));
}

fn unpack_halves(words: vec2<u32>) -> vec4<f32> {
    return vec4(unpack2x16float(words.x), unpack2x16float(words.y));
}

// A model's error is smooth over 3x3 pixels, noise is not.
fn smooth_row(cell: i32) {
    var sum = unpack_halves(residuals[cell]);
    var count = samples_of(cell);
    if is_linked(cell - 1, RIGHT) {
        sum += unpack_halves(residuals[cell - 1]);
        count += samples_of(cell - 1);
    }
    if is_linked(cell, RIGHT) {
        sum += unpack_halves(residuals[cell + 1]);
        count += samples_of(cell + 1);
    }
    surfaces[cell] = vec2(pack2x16float(sum.xy), pack2x16float(sum.zw));
    row_counts[cell] = count;
}

fn smooth_column(cell: i32) {
    var sum = unpack_halves(surfaces[cell]);
    var count = row_counts[cell];
    if is_linked(cell - GROUP, DOWN) {
        sum += unpack_halves(surfaces[cell - GROUP]);
        count += row_counts[cell - GROUP];
    }
    if is_linked(cell, DOWN) {
        sum += unpack_halves(surfaces[cell + GROUP]);
        count += row_counts[cell + GROUP];
    }
    let mean = sum / max(f32(count), 1.0);
    // What has no samples itself counts for nothing.
    let squares = select(vec2(0.0), vec2(mean.x * mean.x, found_variance(mean.yzw)), is_linked(cell, SAMPLED));
    residuals[cell] = bitcast<vec2<u32>>(squares);
}

// Whether the cell at `distance` cells in a direction goes with a cell.
fn goes_with(cell: i32, distance: i32, step: i32, bit: u32) -> bool {
    let earlier = select(cell, cell + distance * step, distance < 0);
    return distance == 0 || is_linked(earlier, select(bit, bit << 1u, abs(distance) == 2));
}

fn pool_row(cell: i32) {
    var squares = vec2(0.0);
    var variances = vec2(0.0);
    var count = 0u;
    for (var x = -POOL_RADIUS; x <= POOL_RADIUS; x++) {
        if goes_with(cell, x, 1, RIGHT) {
            squares += bitcast<vec2<f32>>(residuals[cell + x]);
            let own = unpack2x16float(deviations[cell + x]);
            variances += own * own;
            count += samples_of(cell + x);
        }
    }
    surfaces[cell] = bitcast<vec2<u32>>(squares);
    row_noises[cell] = pack2x16float(sqrt(variances));
    row_counts[cell] = count;
}

// Sums over 5x5 pixels.
struct Pool {
    squares: vec2<f32>,   // of residuals and of deviations, smoothed
    variances: vec2<f32>, // of the temporal mean: as expected, as found
    count: f32,           // pixels with samples
}

fn pool(cell: i32) -> Pool {
    var sum: Pool;
    for (var y = -POOL_RADIUS; y <= POOL_RADIUS; y++) {
        let row = cell + y * GROUP;
        if goes_with(cell, y, GROUP, DOWN) {
            sum.squares += bitcast<vec2<f32>>(surfaces[row]);
            let of_row = unpack2x16float(row_noises[row]);
            sum.variances += of_row * of_row;
            sum.count += f32(row_counts[row]);
        }
    }
    return sum;
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
fn temporal_mix(pooled: Pool, surface: Surface, predicted: Prediction, mean: vec4<f32>) -> Mix {
    let squares = pooled.squares;
    // Without any model near, the temporal mean is all there is.
    var share = select(1.0, 0.0, is_known(predicted));
    if pooled.count == 0.0 {
        // Nothing is known of the error: as good as one sample.
        let l = luminance(select(mean.rgb, predicted.signal, is_known(predicted)));
        return Mix(share, max(predicted.relative_noise, 1.0) * l * l);
    }
    // Samples of a mirror also scatter by what passes in it: what is expected of them is too much.
    let noise = select(max(pooled.variances.x, pooled.variances.y), pooled.variances.y, IS_SPECULAR);
    let beyond = max(squares.x - CHANCE * squares.y, 0.0);
    // Firmer than the plain difference: what is hardly beyond chance is chance more often than not.
    var error = beyond * beyond / max(squares.x, 1e-30);
    if IS_SPECULAR || (!has(frame, FLAG_SPLIT) && surface.roughness < GLOSSY) {
        // Where reflections are seen, models err more often than not.
        error = max(squares.x - squares.y, 0.0);
    }
    if has(frame, FLAG_MIX) && error > 0.0 && mean.w > 0.0 && is_known(predicted) {
        // A pixel alone says nothing about the model.
        share = error / (error + noise) * (1.0 - 1.0 / (pooled.count * pooled.count));
    }
    return mixed(share, error / pooled.count, noise / pooled.count);
}
