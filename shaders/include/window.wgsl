// The tiles of a window about a centre, from the inside outwards, and their moments about one origin.
//
// A pass binds `moments` and says how many invocations work on a window (LANES).
// Source: merging moments about different means: Chan, Golub and LeVeque 1979

const_assert LANES >= MOST_TILES && LANES >= TILE_SQUARES && LANES >= SQUARE_QUADS;

const WINDOW_QUADS = 1u + MEAN_QUADS;

// Of each tile its weight, divided by variance, and its noises, times that; then means about the origin, times the root of that
// weight.
var<workgroup> window: array<array<vec4<f32>, WINDOW_QUADS>, MOST_TILES>;
var<workgroup> window_factors: array<f32, MOST_TILES>; // what their weights were multiplied by
var<workgroup> window_tiles: array<u32, MOST_TILES>;   // where they are in memory
var<workgroup> origin: array<vec4<f32>, MEAN_QUADS>;

// Call from uniform control flow. Tiles outside the frame stay, with weight 0, so that all windows have one shape. Returns the
// weight before it is divided by variance; `origin` is then the mean of the innermost tiles that have any.
fn load_window(centre: vec2<u32>, count: u32, lane: u32) -> f32 {
    var own: vec4<f32>;
    if lane < count {
        let tile = vec2<i32>(centre) + window_offset(lane);
        let inside = all(tile >= vec2(0)) && all(tile < vec2<i32>(frame.tiles));
        let start = select(0u, u32(tile.y) * frame.tiles.x + u32(tile.x), inside) * TILE_STRIDE;
        own = moments[start];
        own[TILE_WEIGHT] = select(0.0, own[TILE_WEIGHT], inside);
        window_tiles[lane] = start;
        window[lane][0] = own;
    }
    workgroupBarrier();
    var samples = 0.0;
    var variance = 0.0;
    for (var t = 0u; t < count; t++) {
        let head = window[t][0];
        samples += head[TILE_WEIGHT];
        variance += head[TILE_WEIGHT] * head[TILE_VARIANCE];
    }
    workgroupBarrier(); // all have read the weights that are now replaced
    if lane < count {
        // Inverse-variance weighting by tiles.
        let noise = own[TILE_VARIANCE] * samples / max(variance, 1e-30);
        let factor = select(0.0, variance_factor(noise), own[TILE_WEIGHT] > 0.0);
        let weight = factor * own[TILE_WEIGHT];
        window_factors[lane] = factor;
        window[lane][0] = weight * vec4(1.0, own.yzw);
    }
    workgroupBarrier();
    if lane < MEAN_QUADS {
        // Not the whole window's: next to something bright, small values about its mean would lose their digits.
        let near = min(9u, count);
        let end = select(count, near, window_weight(0u, near) > 0.0);
        var sum = vec4(0.0);
        for (var t = 0u; t < end; t++) {
            sum += window[t][0][TILE_WEIGHT] * moments[window_tiles[t] + 1u + lane];
        }
        origin[lane] = sum / max(window_weight(0u, end), 1e-30);
    }
    workgroupBarrier();
    for (var i = lane; i < count * MEAN_QUADS; i += LANES) {
        let tile = i / MEAN_QUADS;
        let quad = i % MEAN_QUADS;
        let mean = moments[window_tiles[tile] + 1u + quad];
        window[tile][1u + quad] = sqrt(window[tile][0][TILE_WEIGHT]) * (mean - origin[quad]);
    }
    workgroupBarrier();
    return samples;
}

fn origin_of(column: u32) -> f32 {
    return origin[column / 4u][column % 4u];
}

// Weight of some of the tiles.
fn window_weight(begin: u32, end: u32) -> f32 {
    var sum = 0.0;
    for (var t = begin; t < end; t++) {
        sum += window[t][0][TILE_WEIGHT];
    }
    return sum;
}

fn window_mean(tile: u32, column: u32) -> f32 {
    return window[tile][1u + column / 4u][column % 4u];
}

// Weighted sum of one of the tiles' entries (of the weight: the weight; of a mean: about the origin) over some of the tiles.
fn window_moment(entry: u32, begin: u32, end: u32) -> f32 {
    var sum = 0.0;
    for (var t = begin; t < end; t++) {
        sum += window[t][entry / 4u][entry % 4u] * select(1.0, sqrt(window[t][0][TILE_WEIGHT]), entry >= TILE_MEAN);
    }
    return sum;
}

// Squares about the origin: those of the tiles about their means, plus those of the means.
fn window_squares(quad: u32, places: SquareQuad, begin: u32, end: u32) -> vec4<f32> {
    var sum = vec4(0.0);
    for (var t = begin; t < end; t++) {
        var products: vec4<f32>;
        for (var i = 0u; i < 4u; i++) {
            products[i] = window_mean(t, places.rows[i]) * window_mean(t, places.columns[i]);
        }
        sum += window_factors[t] * moments[window_tiles[t] + 1u + MEAN_QUADS + quad] + products;
    }
    return sum;
}
