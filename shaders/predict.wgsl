// predict: every pixel from the models whose windows hold it, weighted by a tent that ends at the window's border, and by how
// well they fit.
//
// Reads   guide, history, noise, models, windows.
// Writes  prediction: predicted demodulated radiance; in w the standard error of the temporal mean, < 0 without samples
// Source  Moon et al. 2015, section 4.3: overlapping predictions are averaged

//!include frame numbers noise surface features models

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var guide: texture_2d<u32>;
@group(0) @binding(2) var history: texture_2d<f32>;
@group(0) @binding(3) var noise: texture_2d<f32>;
@group(0) @binding(4) var<storage, read> models: array<f32>;
@group(0) @binding(5) var<storage, read> windows: array<u32>;
@group(0) @binding(6) var prediction: texture_storage_2d<rgba16float, write>;

// A workgroup has 2x2 tiles; models that reach them have their centres among 8x8 tiles, one for each lane to look at.
const SIDE = 2u * WIDEST_WINDOW + 2u;

var<workgroup> radii: array<u32, SIDE * SIDE>;
var<workgroup> reaching: array<atomic<u32>, 2>; // a bit per tile

@compute @workgroup_size(8, 8)
fn predict(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let corner = vec2<i32>(group.xy * 2u) - i32(WIDEST_WINDOW);
    look_at_tile(corner + vec2<i32>(vec2(lane % SIDE, lane / SIDE)), vec2<i32>(group.xy * 2u), lane);
    workgroupBarrier();
    if any(id.xy >= frame.size) {
        return;
    }
    let surface = unpack_surface(textureLoad(guide, id.xy, 0));
    if is_miss(surface) {
        textureStore(prediction, id.xy, vec4(0.0));
        return;
    }
    let mean = textureLoad(history, id.xy, 0);
    let z = features(id.xy, surface);
    var sum = vec4(0.0);
    var noises = vec2(0.0); // gain, relative noise
    for (var word = 0u; word < 2u; word++) {
        var bits = atomicLoad(&reaching[word]);
        while bits != 0u {
            let slot = 32u * word + firstTrailingBit(bits);
            bits &= bits - 1u;
            let tile = corner + vec2<i32>(vec2(slot % SIDE, slot / SIDE));
            let start = (u32(tile.y) * frame.tiles.x + u32(tile.x)) * MODEL_STRIDE;
            let middle = (vec2<f32>(tile) + 0.5) * f32(TILE);
            let weight = tent(vec2<f32>(id.xy) + 0.5 - middle, radii[slot]) * models[start + MODEL_TRUST];
            if weight > 0.0 {
                sum += weight * vec4(evaluate(start, z), 1.0);
                noises += weight
                    * vec2(models[start + MODEL_NOISE_GAIN], models[start + MODEL_RELATIVE_NOISE]);
            }
        }
    }
    // Without any sample near, the temporal mean is all there is.
    var predicted = mean.rgb;
    if sum.w > 0.0 {
        predicted = clamp(sum.rgb / sum.w, vec3(0.0), vec3(HALF_MAX));
    }
    var standard_error = -1.0;
    if mean.w > 0.0 && sum.w > 0.0 {
        // With a prior sample, as noisy as the window's are: few samples that all were dark are no certainty.
        let l = luminance(predicted);
        let prior = noises.y / sum.w * l * l;
        let own = noises.x / sum.w * unpack_noise(textureLoad(noise, id.xy, 0)).variance;
        standard_error = sqrt((own * mean.w + prior) / (mean.w + 1.0) / mean.w);
    }
    textureStore(prediction, id.xy, vec4(predicted, min(standard_error, HALF_MAX)));
}

// Notes whether the model of a tile reaches the workgroup's own tiles, the first of which is `own`.
fn look_at_tile(tile: vec2<i32>, own: vec2<i32>, slot: u32) {
    if any(tile < vec2(0)) || any(tile >= vec2<i32>(frame.tiles)) {
        return;
    }
    let index = u32(tile.y) * frame.tiles.x + u32(tile.x);
    let radius = windows[index];
    let reach = vec2(i32(radius));
    if radius > 0u && all(tile + reach >= own) && all(tile - reach <= own + 1) && models[index * MODEL_STRIDE] > 0.0 {
        radii[slot] = radius;
        atomicOr(&reaching[slot / 32u], 1u << (slot % 32u));
    }
}

fn features(pixel: vec2<u32>, surface: Surface) -> array<f32, FEATURES> {
    let own = surface_features(surface, position_of(frame, frame.current, vec2<f32>(pixel), surface.depth));
    var z: array<f32, FEATURES>;
    for (var i = 0u; i < SURFACE_FEATURES; i++) {
        z[i] = own[i];
    }
    z[SURFACE_FEATURES] = f32(pixel.x);
    z[SURFACE_FEATURES + 1u] = f32(pixel.y);
    return z;
}

fn evaluate(start: u32, z: array<f32, FEATURES>) -> vec3<f32> {
    var value = model_vector(start + MODEL_MEAN + FEATURES);
    for (var i = 0u; i < FEATURES; i++) {
        value += (z[i] - models[start + MODEL_MEAN + i]) * model_vector(start + MODEL_SLOPE + i * CHANNELS);
    }
    return value;
}

fn model_vector(at: u32) -> vec3<f32> {
    return vec3(models[at], models[at + 1u], models[at + 2u]);
}
