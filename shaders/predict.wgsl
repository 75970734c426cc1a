// predict: every pixel from the models whose windows hold it, weighted by a tent that ends at the window's border, and by how
// well they fit.
//
// Reads   guide, models, windows.
// Writes  prediction: predicted demodulated radiance, and what is known of its noise (layout: include/models)
// Source  Moon et al. 2015, section 4.3: overlapping predictions are averaged

//!include frame numbers surface features linear_model windows models

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var guide: texture_2d<u32>;
@group(0) @binding(2) var<storage, read> models: array<vec4<f32>>;
@group(0) @binding(3) var<storage, read> windows: array<u32>;
@group(0) @binding(4) var prediction: texture_storage_2d<rg32uint, write>;

const OWN_FEATURES = MODEL_OWN_FEATURES;

// Models that reach a workgroup's own tile have their centres among 5x5 tiles, one for each lane to look at.
const SIDE = 2u * WIDEST_REACH + 1u;

var<workgroup> chosen: array<u32, SIDE * SIDE>;
var<workgroup> reaching: atomic<u32>; // a bit per tile

@compute @workgroup_size(8, 8)
fn predict(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) own: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let corner = vec2<i32>(own.xy) - i32(WIDEST_REACH);
    if lane == 0u {
        atomicStore(&reaching, 0u);
    }
    workgroupBarrier();
    if lane < SIDE * SIDE {
        look_at_tile(corner + vec2<i32>(vec2(lane % SIDE, lane / SIDE)), vec2<i32>(own.xy), lane);
    }
    workgroupBarrier();
    if any(id.xy >= frame.size) {
        return;
    }
    let surface = unpack_surface(textureLoad(guide, id.xy, 0).xy);
    var predicted = Prediction(vec3(0.0), 0.0, -1.0);
    if !is_miss(surface) {
        predicted = average(id.xy, surface, corner);
    }
    textureStore(prediction, id.xy, vec4(pack_prediction(predicted), 0u, 0u));
}

fn average(pixel: vec2<u32>, surface: Surface, corner: vec2<i32>) -> Prediction {
    let position = position_of(frame.current, vec2<f32>(pixel), surface.depth);
    let z = surface_regressors(surface_features(surface, position), vec2<f32>(pixel));
    var sum = vec4(0.0);
    var noises = vec2(0.0); // gain, relative noise
    var bits = atomicLoad(&reaching);
    while bits != 0u {
        let slot = firstTrailingBit(bits);
        bits &= bits - 1u;
        let tile = corner + vec2<i32>(vec2(slot % SIDE, slot / SIDE));
        let start = (u32(tile.y) * frame.tiles.x + u32(tile.x)) * MODEL_STRIDE;
        let middle = (vec2<f32>(tile) + 0.5) * f32(TILE);
        let head = models[start];
        let weight = tent(vec2<f32>(pixel) + 0.5 - middle, chosen[slot]) * head[HEAD_TRUST];
        if weight > 0.0 {
            sum += weight * vec4(evaluate(start, z), 1.0);
            noises += weight * vec2(head[HEAD_NOISE_GAIN], head[HEAD_RELATIVE_NOISE]);
        }
    }
    if sum.w <= 0.0 {
        return Prediction(vec3(0.0), 0.0, -1.0);
    }
    return Prediction(clamp(sum.rgb / sum.w, vec3(0.0), vec3(HALF_MAX)), noises.x / sum.w, noises.y / sum.w);
}

// Notes whether the model of a tile reaches the workgroup's own.
fn look_at_tile(tile: vec2<i32>, own: vec2<i32>, slot: u32) {
    if any(tile < vec2(0)) || any(tile >= vec2<i32>(frame.tiles)) {
        return;
    }
    let index = u32(tile.y) * frame.tiles.x + u32(tile.x);
    let size = stored_window(windows[index]);
    // From the middle of a tile to the nearest pixel of another.
    let gap = max(f32(TILE) * vec2<f32>(abs(tile - own)) - 0.5 * f32(TILE) + 0.5, vec2(0.0));
    if size > 0u && tent(gap, size) > 0.0 {
        chosen[slot] = size;
        atomicOr(&reaching, 1u << slot);
    }
}

fn evaluate(start: u32, z: Regressors) -> vec3<f32> {
    var value: vec3<f32>;
    for (var c = 0u; c < CHANNELS; c++) {
        let row = start + 1u + c * MODEL_ROW;
        value[c] = dot(models[row], z[0]) + dot(models[row + 1u], z[1]) + dot(models[row + 2u], z[2]);
    }
    return value;
}
