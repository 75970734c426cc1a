// moments: weighted first and second moments of features and temporal means, per tile of 4x4 pixels.
//
// Reads   guide, history, noise.
// Writes  tile_means, tile_squares_low, tile_squares_high (layout: include/features)
// Source  moments about each group's own mean, so that f32 holds: Chan, Golub and LeVeque, "Updating Formulae and a Pairwise
//         Algorithm for Computing Sample Variances", 1979

//!include frame numbers surface features

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var guide: texture_2d<u32>;
@group(0) @binding(2) var history: texture_2d<f32>;
@group(0) @binding(3) var noise: texture_2d<f32>;
@group(0) @binding(4) var<storage, read_write> tile_means: array<f32>;
@group(0) @binding(5) var<storage, read_write> tile_squares_low: array<f32>;
@group(0) @binding(6) var<storage, read_write> tile_squares_high: array<f32>;

const TILE_PIXELS = TILE * TILE;
const GROUP_TILES = 4u; // 2x2 tiles a workgroup

var<workgroup> columns: array<array<f32, COLUMNS>, 64>; // by tile, then pixel of the tile
var<workgroup> weights: array<f32, 64>;
var<workgroup> noises: array<vec2<f32>, 64>;
var<workgroup> means: array<array<f32, TILE_STRIDE>, GROUP_TILES>;

@compute @workgroup_size(8, 8)
fn moments(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let local_tile = lane / TILE_PIXELS;
    let member = lane % TILE_PIXELS;
    let tile = group.xy * 2u + vec2(local_tile & 1u, local_tile >> 1u);
    load_pixel(tile * TILE + vec2(member % TILE, member / TILE), lane);
    workgroupBarrier();

    let first = local_tile * TILE_PIXELS;
    for (var entry = member; entry < TILE_STRIDE; entry += TILE_PIXELS) {
        means[local_tile][entry] = mean_entry(entry, first);
    }
    workgroupBarrier();

    if any(tile >= frame.tiles) {
        return;
    }
    let index = tile.y * frame.tiles.x + tile.x;
    for (var entry = member; entry < TILE_STRIDE; entry += TILE_PIXELS) {
        tile_means[index * TILE_STRIDE + entry] = means[local_tile][entry];
    }
    for (var entry = member; entry < SQUARES; entry += TILE_PIXELS) {
        let value = square(entry, local_tile, first);
        if entry < HALF_SQUARES {
            tile_squares_low[index * HALF_SQUARES + entry] = value;
        } else {
            tile_squares_high[index * HALF_SQUARES + entry - HALF_SQUARES] = value;
        }
    }
}

// A pixel outside the frame, without a surface or without samples enters with weight 0.
fn load_pixel(pixel: vec2<u32>, lane: u32) {
    weights[lane] = 0.0;
    noises[lane] = vec2(0.0);
    for (var i = 0u; i < COLUMNS; i++) {
        columns[lane][i] = 0.0;
    }
    if any(pixel >= frame.size) {
        return;
    }
    let surface = unpack_surface(textureLoad(guide, pixel, 0));
    let mean = textureLoad(history, pixel, 0);
    if is_miss(surface) || mean.w <= 0.0 {
        return;
    }
    let z = features(pixel, surface, position_of(frame, frame.current, vec2<f32>(pixel), surface.depth));
    for (var i = 0u; i < FEATURES; i++) {
        columns[lane][i] = z[i];
    }
    columns[lane][FEATURES] = mean.r;
    columns[lane][FEATURES + 1u] = mean.g;
    columns[lane][FEATURES + 2u] = mean.b;
    // The mean of n samples has n times the certainty of one; how noisy one is here is judged per tile, in `fit`: a
    // weight from a pixel's own samples would favour those that happen to be dark.
    weights[lane] = mean.w;
    noises[lane] = textureLoad(noise, pixel, 0).xy;
}

fn mean_entry(entry: u32, first: u32) -> f32 {
    var weight = 0.0;
    var sum = 0.0;
    for (var i = first; i < first + TILE_PIXELS; i++) {
        weight += weights[i];
        sum += weights[i] * value_of(entry, i);
    }
    if entry == TILE_WEIGHT {
        return weight;
    }
    return select(0.0, sum / weight, weight > 0.0);
}

fn value_of(entry: u32, i: u32) -> f32 {
    switch entry {
        case TILE_WEIGHT: {
            return 1.0;
        }
        case TILE_VARIANCE: {
            return noises[i].x;
        }
        case TILE_FOUND: {
            return noises[i].y * noises[i].y;
        }
        case TILE_EXPECTED: {
            return noises[i].x / max(weights[i], 1e-3);
        }
        default: {
            return columns[i][entry - TILE_MEAN];
        }
    }
}

fn square(entry: u32, local_tile: u32, first: u32) -> f32 {
    let ij = square_entry(entry);
    let mean_i = means[local_tile][TILE_MEAN + ij.x];
    let mean_j = means[local_tile][TILE_MEAN + ij.y];
    var sum = 0.0;
    for (var i = first; i < first + TILE_PIXELS; i++) {
        sum += weights[i] * (columns[i][ij.x] - mean_i) * (columns[i][ij.y] - mean_j);
    }
    return sum;
}
