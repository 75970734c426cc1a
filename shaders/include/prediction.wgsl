// What the models say of a pixel: the mean of what those say whose windows hold it, weighted by a tent that ends at the window's
// border, and by how well they fit.
//
// A pass binds models and windows.
// Source: Moon et al. 2015, section 4.3: overlapping predictions are averaged

// Models that reach a tile have their centres among 5x5 tiles, a bit for each.
const REACH_SIDE = 2u * WIDEST_REACH + 1u;
const REACH_SLOTS = REACH_SIDE * REACH_SIDE;

// The bit of a slot if the model that is centred there reaches the tile.
fn reaching_bit(own: vec2<i32>, slot: u32) -> u32 {
    let tile = slot_tile(own, slot);
    if slot >= REACH_SLOTS || any(tile < vec2(0)) || any(tile >= vec2<i32>(frame.tiles)) {
        return 0u;
    }
    let size = window_at(tile);
    // From the middle of a tile to the nearest pixel of another.
    let gap = max(f32(TILE) * vec2<f32>(abs(tile - own)) - 0.5 * f32(TILE) + 0.5, vec2(0.0));
    return select(0u, 1u << slot, size > 0u && tent(gap, size) > 0.0);
}

fn slot_tile(own: vec2<i32>, slot: u32) -> vec2<i32> {
    return own - i32(WIDEST_REACH) + vec2<i32>(vec2(slot % REACH_SIDE, slot / REACH_SIDE));
}

fn window_at(tile: vec2<i32>) -> u32 {
    return stored_window(windows[u32(tile.y) * frame.tiles.x + u32(tile.x)]);
}

fn predict(pixel: vec2<u32>, surface: Surface, reaching: u32) -> Prediction {
    let position = position_of(frame.current, vec2<f32>(pixel), surface.depth);
    let z = surface_regressors(surface_features(surface, position), vec2<f32>(pixel));
    let own = vec2<i32>(pixel / TILE);
    var sum = vec4(0.0);
    var noises = vec2(0.0); // gain, relative noise
    for (var bits = reaching; bits != 0u; bits &= bits - 1u) {
        let tile = slot_tile(own, firstTrailingBit(bits));
        let start = (u32(tile.y) * frame.tiles.x + u32(tile.x)) * MODEL_STRIDE;
        let middle = (vec2<f32>(tile) + 0.5) * f32(TILE);
        let head = models[start];
        let weight = tent(vec2<f32>(pixel) + 0.5 - middle, window_at(tile)) * head[HEAD_TRUST];
        if weight > 0.0 {
            sum += weight * vec4(evaluate(start, z), 1.0);
            noises += weight * vec2(head[HEAD_NOISE_GAIN], head[HEAD_RELATIVE_NOISE]);
        }
    }
    if sum.w <= 0.0 {
        return NO_PREDICTION;
    }
    return Prediction(clamp(sum.rgb / sum.w, vec3(0.0), vec3(HALF_MAX)), noises.x / sum.w, noises.y / sum.w);
}

fn evaluate(start: u32, z: Regressors) -> vec3<f32> {
    var value: vec3<f32>;
    for (var c = 0u; c < CHANNELS; c++) {
        let row = start + 1u + c * MODEL_ROW;
        value[c] = dot(models[row], z[0]) + dot(models[row + 1u], z[1]) + dot(models[row + 2u], z[2]);
    }
    return value;
}
