// Weighted first and second moments of a tile's pixels, by a workgroup of 64: one pixel each.
//
// A pass says MOMENT_TILE (pixels on a side, 4 or 8), binds tile_means and both halves of the squares, and fills
// `columns`, `weights` and `noises` of its lane; weight 0 leaves a pixel out.
// Source: moments about each group's own mean, so that f32 holds: Chan, Golub and LeVeque, "Updating Formulae and a Pairwise
// Algorithm for Computing Sample Variances", 1979

const TILE_PIXELS = MOMENT_TILE * MOMENT_TILE;
const GROUP_SIDE = 8u / MOMENT_TILE; // tiles

var<workgroup> columns: array<array<f32, COLUMNS>, 64>; // by tile, then pixel of the tile
var<workgroup> weights: array<f32, 64>;
var<workgroup> noises: array<vec3<f32>, 64>;            // for the tile's variance, found and expected
var<workgroup> means: array<array<f32, TILE_STRIDE>, GROUP_SIDE * GROUP_SIDE>;

fn lane_tile(group: vec2<u32>, lane: u32) -> vec2<u32> {
    let local = lane / TILE_PIXELS;
    return group * GROUP_SIDE + vec2(local % GROUP_SIDE, local / GROUP_SIDE);
}

fn lane_pixel(group: vec2<u32>, lane: u32) -> vec2<u32> {
    let member = lane % TILE_PIXELS;
    return lane_tile(group, lane) * MOMENT_TILE + vec2(member % MOMENT_TILE, member / MOMENT_TILE);
}

fn leave_out(lane: u32) {
    weights[lane] = 0.0;
    noises[lane] = vec3(0.0);
    for (var i = 0u; i < COLUMNS; i++) {
        columns[lane][i] = 0.0;
    }
}

fn write_surface(pixel: vec2<u32>, surface: Surface, lane: u32) {
    let z = surface_features(surface, position_of(frame, frame.current, vec2<f32>(pixel), surface.depth));
    for (var i = 0u; i < SURFACE_FEATURES; i++) {
        columns[lane][i] = z[i];
    }
}

// Call from uniform control flow, after each lane wrote its pixel; `tiles` cover the frame.
fn sum_tiles(group: vec2<u32>, lane: u32, tiles: vec2<u32>) {
    workgroupBarrier();
    let local_tile = lane / TILE_PIXELS;
    let member = lane % TILE_PIXELS;
    let first = local_tile * TILE_PIXELS;
    for (var entry = member; entry < TILE_STRIDE; entry += TILE_PIXELS) {
        means[local_tile][entry] = mean_entry(entry, first);
    }
    workgroupBarrier();
    let tile = lane_tile(group, lane);
    if any(tile >= tiles) {
        return;
    }
    let index = tile.y * tiles.x + tile.x;
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
    if entry >= TILE_MEAN {
        return columns[i][entry - TILE_MEAN];
    }
    return noises[i][max(entry, TILE_VARIANCE) - TILE_VARIANCE];
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
