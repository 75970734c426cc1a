// The tiles of a window about a centre, from the inside outwards, and their moments about one origin.
//
// A pass binds `moments` and says how many invocations work on a window (LANES).
// Source: merging moments about different means: Chan, Golub and LeVeque 1979

const_assert LANES >= MOST_TILES && LANES >= TILE_SQUARES;

// Heads of the tiles, with means about the origin times the root of the weight. Their weights, divided by variance, lie apart.
var<workgroup> window: array<array<f32, TILE_SQUARES>, MOST_TILES>;
var<workgroup> window_weights: array<f32, MOST_TILES>;
var<workgroup> window_factors: array<f32, MOST_TILES>; // what their weights were multiplied by
var<workgroup> window_tiles: array<u32, MOST_TILES>;   // where they are in memory
var<workgroup> origin: array<f32, COLUMNS>;

// Call from uniform control flow. Tiles outside the frame stay, with weight 0, so that all windows have one shape. Returns the
// weight before it is divided by variance; `origin` is then the mean of the innermost tiles that have any.
fn load_window(centre: vec2<u32>, count: u32, lane: u32) -> f32 {
    if lane < count {
        let tile = vec2<i32>(centre) + window_offset(lane);
        let inside = all(tile >= vec2(0)) && all(tile < vec2<i32>(frame.tiles));
        let start = select(0u, u32(tile.y) * frame.tiles.x + u32(tile.x), inside) * TILE_STRIDE;
        window_tiles[lane] = start;
        window[lane][TILE_WEIGHT] = select(0.0, moments[start + TILE_WEIGHT], inside);
        window[lane][TILE_VARIANCE] = moments[start + TILE_VARIANCE];
    }
    workgroupBarrier();
    var samples = 0.0;
    var variance = 0.0;
    for (var t = 0u; t < count; t++) {
        samples += window[t][TILE_WEIGHT];
        variance += window[t][TILE_WEIGHT] * window[t][TILE_VARIANCE];
    }
    if lane < count {
        // Inverse-variance weighting by tiles.
        let weight = window[lane][TILE_WEIGHT];
        let noise = window[lane][TILE_VARIANCE] * samples / max(variance, 1e-30);
        let factor = select(0.0, variance_factor(noise), weight > 0.0);
        window_factors[lane] = factor;
        window_weights[lane] = factor * weight;
    }
    workgroupBarrier();
    if lane < COLUMNS {
        // Not the whole window's: next to something bright, small values about its mean would lose their digits.
        let near = min(9u, count);
        let end = select(count, near, window_weight(0u, near) > 0.0);
        var sum = 0.0;
        for (var t = 0u; t < end; t++) {
            sum += window_weights[t] * moments[window_tiles[t] + TILE_MEAN + lane];
        }
        origin[lane] = sum / max(window_weight(0u, end), 1e-30);
    }
    workgroupBarrier();
    for (var i = lane; i < count * TILE_SQUARES; i += LANES) {
        let tile = i / TILE_SQUARES;
        let entry = i % TILE_SQUARES;
        var value = moments[window_tiles[tile] + entry];
        if entry >= TILE_MEAN {
            value = sqrt(window_weights[tile]) * (value - origin[entry - TILE_MEAN]);
        }
        window[tile][entry] = value;
    }
    workgroupBarrier();
    return samples;
}

// Weight of some of the tiles.
fn window_weight(begin: u32, end: u32) -> f32 {
    var sum = 0.0;
    for (var t = begin; t < end; t++) {
        sum += window_weights[t];
    }
    return sum;
}

// Weighted sum of one of the tiles' entries (of the weight: the weight; of a mean: about the origin) over some of the tiles.
fn window_moment(entry: u32, begin: u32, end: u32) -> f32 {
    var sum = 0.0;
    for (var t = begin; t < end; t++) {
        let weight = window_weights[t];
        let factor = select(weight, sqrt(weight), entry >= TILE_MEAN);
        sum += factor * select(window[t][entry], 1.0, entry == TILE_WEIGHT);
    }
    return sum;
}

// Squares about the origin: those of the tiles about their means, plus those of the means.
fn window_square(entry: u32, begin: u32, end: u32) -> f32 {
    let ij = square_entry(entry) + TILE_MEAN;
    var sum = 0.0;
    for (var t = begin; t < end; t++) {
        sum += window_factors[t] * moments[window_tiles[t] + TILE_SQUARES + entry] + window[t][ij.x] * window[t][ij.y];
    }
    return sum;
}
