// Weighted first and second moments of a tile's pixels, by a workgroup of 64: one pixel each.
//
// A pass binds `moments` and fills `columns`, `weights` and `noises` of its lane; weight 0 leaves a pixel out.
// Source: moments about each group's own mean, so that f32 holds: Chan, Golub and LeVeque, "Updating Formulae and a Pairwise
// Algorithm for Computing Sample Variances", 1979

const TILE_PIXELS = TILE * TILE;

var<workgroup> columns: array<array<f32, COLUMNS>, TILE_PIXELS>;
var<workgroup> weights: array<f32, TILE_PIXELS>;
var<workgroup> noises: array<vec3<f32>, TILE_PIXELS>; // for the tile's variance, found and expected
var<workgroup> tile_heads: array<f32, TILE_SQUARES>;

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

// Call from uniform control flow, after a barrier that follows each lane's writes.
fn sum_tile(tile: vec2<u32>, lane: u32) {
    if lane < TILE_SQUARES {
        tile_heads[lane] = tile_head(lane);
    }
    workgroupBarrier();
    // So that a square is a sum of plain products.
    let root = sqrt(weights[lane]);
    for (var i = 0u; i < COLUMNS; i++) {
        columns[lane][i] = root * (columns[lane][i] - tile_heads[TILE_MEAN + i]);
    }
    workgroupBarrier();
    let start = (tile.y * frame.tiles.x + tile.x) * TILE_STRIDE;
    if lane < TILE_SQUARES {
        moments[start + lane] = tile_heads[lane];
    }
    for (var entry = lane; entry < SQUARES; entry += TILE_PIXELS) {
        let ij = square_entry(entry);
        var sum = 0.0;
        for (var i = 0u; i < TILE_PIXELS; i++) {
            sum += columns[i][ij.x] * columns[i][ij.y];
        }
        moments[start + TILE_SQUARES + entry] = sum;
    }
}

fn tile_head(entry: u32) -> f32 {
    var weight = 0.0;
    var sum = 0.0;
    for (var i = 0u; i < TILE_PIXELS; i++) {
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
