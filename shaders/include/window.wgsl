// The tiles of a window about a centre, from the inside outwards, and their moments about one origin.
//
// A pass binds `moments`.
// Source: merging moments about different means: Chan, Golub and LeVeque 1979

// Heads of the tiles, with weights by variance, and means about the origin times the root of the weight.
var<workgroup> window: array<array<f32, TILE_SQUARES>, MOST_TILES>;
var<workgroup> window_tiles: array<u32, MOST_TILES>;   // where their squares are
var<workgroup> window_factors: array<f32, MOST_TILES>; // what their weights were multiplied by
var<workgroup> origin: array<f32, COLUMNS>;

// Call from uniform control flow. Tiles outside the frame stay, with weight 0, so that all windows have one shape. Returns the
// weight before it is divided by variance; `origin` is then the mean of the innermost tiles that have any.
fn load_window(centre: vec2<u32>, count: u32, lane: u32) -> f32 {
    if lane < count {
        let tile = vec2<i32>(centre) + window_offset(lane);
        let inside = all(tile >= vec2(0)) && all(tile < vec2<i32>(frame.tiles));
        window_tiles[lane] = select(0u, u32(tile.y) * frame.tiles.x + u32(tile.x), inside) * TILE_STRIDE;
        window_factors[lane] = select(0.0, 1.0, inside);
    }
    workgroupBarrier();
    for (var i = lane; i < count * TILE_SQUARES; i += 64u) {
        let tile = i / TILE_SQUARES;
        let entry = i % TILE_SQUARES;
        window[tile][entry] = window_factors[tile] * moments[window_tiles[tile] + entry];
    }
    workgroupBarrier();
    let samples = window_sum(TILE_WEIGHT, 0u, count);
    let variance = window_sum(TILE_VARIANCE, 0u, count) / max(samples, 1e-30);
    workgroupBarrier(); // all have read the weights that are now replaced
    if lane < count {
        // Inverse-variance weighting by tiles.
        let noise = window[lane][TILE_VARIANCE] / max(variance, 1e-30);
        let factor = select(0.0, variance_factor(noise), window[lane][TILE_WEIGHT] > 0.0);
        window_factors[lane] = factor;
        window[lane][TILE_WEIGHT] *= factor;
    }
    workgroupBarrier();
    if lane < COLUMNS {
        // Not the whole window's: next to something bright, small values about its mean would lose their digits.
        let near = min(9u, count);
        let end = select(count, near, window_sum(TILE_WEIGHT, 0u, near) > 0.0);
        let weight = window_sum(TILE_WEIGHT, 0u, end);
        origin[lane] = window_sum(TILE_MEAN + lane, 0u, end) / max(weight, 1e-30);
    }
    workgroupBarrier();
    for (var i = lane; i < count * COLUMNS; i += 64u) {
        let tile = i / COLUMNS;
        let column = i % COLUMNS;
        let mean = window[tile][TILE_MEAN + column];
        window[tile][TILE_MEAN + column] = sqrt(window[tile][TILE_WEIGHT]) * (mean - origin[column]);
    }
    workgroupBarrier();
    return samples;
}

// Weighted sum of one of the tiles' entries (of the weight: the weight) over some of the tiles.
fn window_sum(entry: u32, begin: u32, end: u32) -> f32 {
    var sum = 0.0;
    for (var t = begin; t < end; t++) {
        sum += window[t][TILE_WEIGHT] * select(window[t][entry], 1.0, entry == TILE_WEIGHT);
    }
    return sum;
}

// As `window_sum` once the means are about the origin.
fn window_moment(entry: u32, begin: u32, end: u32) -> f32 {
    if entry < TILE_MEAN {
        return window_sum(entry, begin, end);
    }
    var sum = 0.0;
    for (var t = begin; t < end; t++) {
        sum += sqrt(window[t][TILE_WEIGHT]) * window[t][entry];
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
