// accumulate: the weighted temporal sample. This frame's sample joins the history of its surface, which is relit first; then
// the moments of features and temporal means are summed, per tile.
//
// Reads   signal, guide, sample_count; reprojected history and noise; innovations.
// Writes  history: temporal mean of demodulated radiance, effective sample count in w; at a miss its radiance
//         noise; moments (layouts: include/noise, include/features)
// Source  incremental weighted mean and variance: West, "Updating mean and variance estimates", CACM 1979; spatial
//         fall-back for short histories: Schied et al. 2017, section 4.2; truncated means: Bubeck, Cesa-Bianchi and Lugosi,
//         "Bandits with Heavy Tail", 2013, section 2.1; moments: Moon et al. 2015, section 4

//!include frame numbers noise surface signal memory features linear_model models innovations tile_moments

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var signal: texture_2d<u32>;
@group(0) @binding(2) var guide: texture_2d<u32>;
@group(0) @binding(3) var sample_count: texture_2d<u32>;
@group(0) @binding(4) var reprojected: texture_2d<u32>;
@group(0) @binding(5) var reprojected_noise: texture_2d<u32>;
@group(0) @binding(6) var<storage, read> innovations: array<vec4<f32>>;
@group(0) @binding(7) var history: texture_storage_2d<rgba16float, write>;
@group(0) @binding(8) var noise: texture_storage_2d<r32uint, write>;
@group(0) @binding(9) var<storage, read_write> moments: array<vec4<f32>>;

const OWN_FEATURES = MODEL_OWN_FEATURES;

// Below this many samples a pixel's own variance means nothing, and its neighbours' spread is used.
const LEAST_SAMPLES = 4.0;
const AROUND_RADIUS = 3; // pixels on each side

@compute @workgroup_size(8, 8)
fn accumulate(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    leave_out(lane);
    if IS_SPECULAR {
        sum_rows(tile.xy, lane);
        workgroupBarrier();
    }
    if all(id.xy < frame.size) {
        enter_pixel(id.xy, lane);
    }
    workgroupBarrier();
    if skip_tile(tile.xy, lane) {
        return;
    }
    weigh_quarters(lane);
    sum_tile(tile.xy, lane);
}

fn enter_pixel(pixel: vec2<u32>, lane: u32) {
    let surface = unpack_surface(textureLoad(guide, pixel, 0).xy);
    let seed = 2u * frame.index + 1u;
    if is_miss(surface) {
        textureStore(history, pixel, load_reprojected(pixel));
        return;
    }
    let position = position_of(frame.current, vec2<f32>(pixel), surface.depth);
    let z = surface_features(surface, position);
    let now = accumulated(pixel, surface, position, z);
    // Rounded as they are stored, so that the moments are those of the images.
    let mean = dither_to_half(now.history.rgb, pixel, seed);
    let count = unpack2x16float(pack2x16float(vec2(now.history.w))).x;
    let word = pack_noise(now.noise, count, pixel, seed);
    textureStore(history, pixel, vec4(mean, count));
    textureStore(noise, pixel, vec4(word));
    if count <= 0.0 {
        return;
    }
    own_row = row_of(z, vec3(vec2<f32>(pixel), mean.r), mean.gb);
    let own = unpack_noise(word, count);
    weights[lane] = count;
    noises[lane] = vec3(own.variance, found_variance(own.deviations), own.variance / count);
}

struct Accumulated {
    history: vec4<f32>,
    noise: Noise,
}

fn accumulated(
    pixel: vec2<u32>,
    surface: Surface,
    position: vec3<f32>,
    z: array<f32, SURFACE_FEATURES>,
) -> Accumulated {
    let sample = load_sample(pixel);
    let relit = relight(pixel, surface_regressors(z, vec2(0.0)));
    let k = sample.w;
    var old = relit.history;
    var most = relit.most;
    if IS_SPECULAR {
        let drift = find_drift(pixel, surface, relit.change);
        // With a bias d and a sample's variance v, n samples are worth no more than v / (v / n + d^2).
        old.w /= 1.0 + old.w * drift.square / max(drift.variance, 1e-12);
        // What many pixels show is no firefly.
        most = select(most, HALF_MAX, drift.square > 0.0);
    } else if !has(frame, FLAG_SPLIT) && !has(frame, FLAG_HIT_DISTANCE) {
        // The rest of split radiance looks alike from everywhere; where hit distances are known, `reproject` has seen to it.
        old.w = min(old.w, max(k, 1.0) * memory(surface, position));
    }
    // Without samples the history stays as it is; a pixel traced k times this frame enters with weight k.
    let count = joined_count(old.w, k);
    // In all pixels alike, sampled or not: neighbours are blended when history is resampled.
    let flips = select(vec3(1.0), vec3(-1.0), vec3(frame.index) % vec3(1u, 2u, 4u) == vec3(0u));
    let flipped = flips * relit.noise.deviations;
    if k == 0.0 {
        return Accumulated(vec4(old.rgb, count), Noise(relit.noise.variance, flipped));
    }
    let colour = sample.rgb * min(1.0, most / max(luminance(sample.rgb), 1e-30));
    let alpha = k / count;
    // What is new in this sample is less than what it differs by from the mean before it, which is noisy too; as noisy as
    // its samples make it, even where they count for less because the light changed.
    let new_share = relit.samples / (relit.samples + k);
    let d = luminance(colour) - luminance(old.rgb);
    // Unbiased where the old one was: E[d^2] = v (1/k + 1/n) with n samples before, so n / (n + k) k d^2 estimates v.
    var v = mix(relit.noise.variance, new_share * k * d * d, alpha);
    var innovation = sqrt(new_share) * d;
    let first = alpha == 1.0; // nothing of the past is left: only the neighbours tell what is new
    if first || count < LEAST_SAMPLES {
        let spread = spatial_spread(pixel, surface);
        v = spread.variance;
        if first {
            innovation = luminance(colour) - spread.mean;
        }
    }
    let deviations = alpha * innovation + (1.0 - alpha) * flipped;
    return Accumulated(vec4(mix(old.rgb, colour, alpha), count), Noise(v, deviations));
}

// What history and `k` new samples count for. All of it up to `max_history` samples; beyond, history loses its
// `max_history`th part in a frame. So history is as long in time wherever samples are dense, and the more samples a pixel
// gets, the less noise is left.
fn joined_count(old: f32, k: f32) -> f32 {
    let whole = min(old + k, frame.max_history);
    return min(max(whole, old * (1.0 - 1.0 / frame.max_history) + k), HALF_MAX);
}

// This frame's demodulated radiance and how many samples made it: 0 for none.
fn load_sample(pixel: vec2<u32>) -> vec4<f32> {
    let word = textureLoad(signal, pixel, 0).x;
    if word == NO_SAMPLE {
        return vec4(0.0);
    }
    return vec4(unpack_signal(word), samples_at(pixel));
}

fn load_reprojected(pixel: vec2<u32>) -> vec4<f32> {
    let words = textureLoad(reprojected, pixel, 0).xy;
    return vec4(unpack2x16float(words.x), unpack2x16float(words.y));
}

// Inverse-variance weights within the tile, by its quarters: how noisy a pixel is cannot be told from its own samples, which
// would favour those that happen to be dark. What tiles count for is judged in `fit`.
const QUARTER_SIDE = TILE / 2u;

var<workgroup> quarters: array<vec2<f32>, 4>; // weighted variance, weight

fn weigh_quarters(lane: u32) {
    if lane < 4u {
        let corner = vec2(lane % 2u, lane / 2u) * QUARTER_SIDE;
        var sum = vec2(0.0);
        for (var i = 0u; i < QUARTER_SIDE * QUARTER_SIDE; i++) {
            let place = corner + vec2(i % QUARTER_SIDE, i / QUARTER_SIDE);
            let member = place.y * TILE + place.x;
            sum += weights[member] * vec2(noises[member].x, 1.0);
        }
        quarters[lane] = sum;
    }
    workgroupBarrier();
    let whole = quarters[0] + quarters[1] + quarters[2] + quarters[3];
    let own = quarters[lane % TILE / QUARTER_SIDE + 2u * (lane / (TILE * QUARTER_SIDE))];
    let ratio = own.x * whole.y / max(own.y * whole.x, 1e-30);
    weights[lane] *= variance_factor(ratio);
    workgroupBarrier();
}

// What the history is believed to be in this frame's light.
struct Relit {
    history: vec4<f32>,
    noise: Noise,
    samples: f32, // that are in it
    change: f32,  // of its luminance
    most: f32, // luminance of a sample beyond which it is a firefly
}

const KALMAN_GAIN = 3.0; // how much less a history counts that was moved by a standard deviation of one sample
const MOST_BRIGHTENING = 16.0; // of how far samples scatter: more is measured anew

// Moves the history by the predicted change, blended between the four nearest models.
fn relight(pixel: vec2<u32>, z: Regressors) -> Relit {
    let old = load_reprojected(pixel);
    let old_noise = unpack_noise(textureLoad(reprojected_noise, pixel, 0).x, old.w);
    var relit = Relit(old, old_noise, old.w, 0.0, HALF_MAX);
    if old.w <= 0.0 {
        return relit;
    }
    // In units of centres, which are the middles of their tiles.
    let place = (vec2<f32>(pixel) + 0.5 - 0.5 * f32(TILE)) / f32(TILE * innovation_tiles(frame));
    let corner = vec2<i32>(floor(place));
    let f = place - floor(place);
    var sum = vec4(0.0); // change; weight
    var spread = 0.0;    // what a sample may differ by
    var changed = 0u;    // a bit for each that says that the light did
    for (var i = 0; i < 4; i++) {
        let near = near_centre(i, corner, f);
        if any(near.centre < vec2(0)) || any(near.centre >= vec2<i32>(innovation_centres(frame))) {
            continue;
        }
        let head = innovations[near.start];
        if head[HEAD_SAMPLES] > 0.0 {
            sum.w += near.weight;
            changed |= select(0u, 1u << u32(i), head[HEAD_SIGNIFICANCE] > 0.0);
            spread += near.weight * sqrt(head[HEAD_SAMPLES] * head[HEAD_VARIANCE]);
        }
    }
    if sum.w <= 0.0 {
        return relit;
    }
    // Not within the loop above: a CPU takes a loop's end, but no branch past a body.
    for (var round = 0; round < 4 && changed != 0u; round++) {
        let near = near_centre(i32(firstTrailingBit(changed)), corner, f);
        changed &= changed - 1u;
        sum += near.weight * vec4(predicted_change(near.start, z), 0.0);
    }
    let moved = max(old.rgb + sum.rgb / sum.w, vec3(0.0));
    let change = luminance(moved) - luminance(old.rgb);
    let gain = clamp(luminance(moved) / max(luminance(old.rgb), 1e-6), 0.0, MOST_BRIGHTENING);
    // Kalman: the more a sample would have moved the history, the less the history is worth.
    let doubt = KALMAN_GAIN * old.w * change * change / max(old_noise.variance, 1e-12);
    relit.history = vec4(moved, old.w / (1.0 + doubt));
    relit.change = change;
    relit.noise.variance = gain * gain * old_noise.variance;
    if spread > 0.0 {
        // Where history never varied, as in darkness, nothing tells a firefly from light.
        relit.most = luminance(moved) + frame.firefly_limit * spread / sum.w;
    }
    return relit;
}

// One of the four centres about a place: where its model lies, and its bilinear weight.
struct NearCentre {
    centre: vec2<i32>,
    start: u32, // of use where there is such a centre
    weight: f32,
}

fn near_centre(i: i32, corner: vec2<i32>, f: vec2<f32>) -> NearCentre {
    let step = vec2(i & 1, i >> 1u);
    let centre = corner + step;
    let sides = select(1.0 - f, f, step == vec2(1));
    let start = (u32(centre.y) * innovation_centres(frame).x + u32(centre.x)) * MODEL_STRIDE;
    return NearCentre(centre, start, sides.x * sides.y);
}

fn predicted_change(start: u32, z: Regressors) -> vec3<f32> {
    var value: vec3<f32>;
    for (var c = 0u; c < CHANNELS; c++) {
        let row = start + 1u + c * MODEL_ROW;
        value[c] = dot(innovations[row], z[0]) + dot(innovations[row + 1u], z[1]) + dot(innovations[row + 2u], z[2]);
    }
    return value;
}

struct Spread {
    mean: f32,
    variance: f32, // of one sample
}

// Mean and variance of luminance over this frame's samples on the same surface.
fn spatial_spread(pixel: vec2<u32>, centre: Surface) -> Spread {
    let along = elevation_along(frame.current, centre.normal);
    let own = elevation_of(along, vec2<f32>(pixel), centre.depth);
    // About the pixel's own: the difference of two large squares would lose f32's digits.
    let middle = luminance(load_sample(pixel).rgb);
    var count = 0.0;
    var sum = 0.0;
    var squares = 0.0;
    var samples = 0.0;
    for (var y = -AROUND_RADIUS; y <= AROUND_RADIUS; y++) {
        for (var x = -AROUND_RADIUS; x <= AROUND_RADIUS; x++) {
            let texel = vec2<i32>(pixel) + vec2(x, y);
            if !inside(texel, frame.current) {
                continue;
            }
            let sample = load_sample(vec2<u32>(texel));
            let other = unpack_surface(textureLoad(guide, texel, 0).xy);
            let distance = elevation_of(along, vec2<f32>(texel), other.depth) - own;
            if sample.w > 0.0 && same_surface(centre, other, distance, NORMAL_COSINE) {
                let l = luminance(sample.rgb) - middle;
                count += 1.0;
                sum += l;
                squares += l * l;
                samples += sample.w;
            }
        }
    }
    if count < 2.0 {
        // Alone: as uncertain as the value is large.
        return Spread(0.0, middle * middle * samples);
    }
    let spread = max(squares - sum * sum / count, 0.0) / (count - 1.0);
    // The images hold means of several samples, one of which spreads more.
    return Spread(middle + sum / count, spread * samples / count);
}

const DRIFT_CHANCE = 4.0; // variances of the mean difference that are chance: once in twenty times there is more
const DRIFT_PIXELS = 4.0; // with fewer nothing is known
// Roughness up to which what is seen may be smaller than the innovation's tiles, and from which it is not.
const DRIFT_ROUGHNESS = vec2(1.0 / 6.0, 1.0 / 3.0);

// Sums over rows of pixels that go with the one in their middle, for the tile's columns, and for rows beyond it as far as looked: of
// how far samples differ from their histories, where both are. They lie where moments are summed later.
const ROWS = TILE + 2u * u32(AROUND_RADIUS);
const_assert ROWS * TILE <= TILE_PIXELS * QUADS;

fn sum_rows(tile: vec2<u32>, lane: u32) {
    for (var i = lane; i < ROWS * TILE; i += TILE_PIXELS) {
        let place = vec2<i32>(vec2(i % TILE, i / TILE)) - vec2(0, AROUND_RADIUS);
        rows[i] = sum_row(vec2<i32>(TILE * tile) + place);
    }
}

// Number of pixels; sums of weights, of weighted differences, and of their squares.
fn sum_row(middle: vec2<i32>) -> vec4<f32> {
    var sum = vec4(0.0);
    if !inside(middle, frame.current) {
        return sum;
    }
    let centre = unpack_surface(textureLoad(guide, middle, 0).xy);
    let along = elevation_along(frame.current, centre.normal);
    let own = elevation_of(along, vec2<f32>(middle), centre.depth);
    let may_drift = !is_miss(centre) && centre.roughness < DRIFT_ROUGHNESS.y;
    for (var x = -AROUND_RADIUS; x <= AROUND_RADIUS && may_drift; x++) {
        let texel = middle + vec2(x, 0);
        if !inside(texel, frame.current) {
            continue;
        }
        let sample = load_sample(vec2<u32>(texel));
        let old = load_reprojected(vec2<u32>(texel));
        let other = unpack_surface(textureLoad(guide, texel, 0).xy);
        let distance = elevation_of(along, vec2<f32>(texel), other.depth) - own;
        if sample.w > 0.0 && old.w > 0.0 && same_surface(centre, other, distance, NORMAL_COSINE) {
            let change = luminance(sample.rgb) - luminance(old.rgb);
            sum += vec4(1.0, sample.w * vec3(1.0, change, change * change));
        }
    }
    return sum;
}

struct Drift {
    square: f32,   // of how far the history is off in the mean, beyond chance
    variance: f32, // of one sample
}

// How far the history is off, by what samples about the pixel differ by from their histories, when what the innovation predicts is
// taken out: what moves in a mirror is smaller than its models can tell. About it: in rows whose middle goes with it.
fn find_drift(pixel: vec2<u32>, centre: Surface, predicted: f32) -> Drift {
    let share = saturate((DRIFT_ROUGHNESS.y - centre.roughness) / (DRIFT_ROUGHNESS.y - DRIFT_ROUGHNESS.x));
    let along = elevation_along(frame.current, centre.normal);
    let own = elevation_of(along, vec2<f32>(pixel), centre.depth);
    var sum = vec4(0.0);
    for (var y = -AROUND_RADIUS; y <= AROUND_RADIUS && share > 0.0; y++) {
        let middle = vec2<i32>(pixel) + vec2(0, y);
        let other = unpack_surface(textureLoad(guide, middle, 0).xy); // any outside of the frame, where rows hold nothing
        let distance = elevation_of(along, vec2<f32>(middle), other.depth) - own;
        if same_surface(centre, other, distance, NORMAL_COSINE) {
            sum += rows[(pixel.y % TILE + u32(y + AROUND_RADIUS)) * TILE + pixel.x % TILE];
        }
    }
    if sum.x < DRIFT_PIXELS {
        return Drift(0.0, 0.0);
    }
    let mean = sum.z / sum.y;
    let variance = max(sum.w - sum.z * mean, 0.0) / (sum.x - 1.0);
    let drift = mean - predicted;
    return Drift(share * max(drift * drift - DRIFT_CHANCE * variance / sum.y, 0.0), variance);
}
