// Weighted first and second moments of a tile's pixels, by a workgroup of 64: one pixel each.
//
// A pass binds `moments` and enters the row, `weights` and `noises` of its lane's pixel; weight 0 leaves one out.
// All products of columns about those of one of the pixels, with 1 as the first of them, are summed in blocks of 4x4, so that a
// lane uses what it loads four times.
// Source: Chan, Golub and LeVeque, "Updating Formulae and a Pairwise Algorithm for Computing Sample Variances", 1979

const TILE_PIXELS = TILE * TILE;
const QUADS = 4u;  // of columns: 1, then COLUMNS, then zeros
const BLOCKS = 10u; // pairs of quads
const_assert TILE_STRIDE <= TILE_PIXELS;
const SHARES = 6u; // of the pixels, summed apart by as many lanes a block
const BLOCK_QUADS = array(
    vec2(0u, 0u), vec2(0u, 1u), vec2(0u, 2u), vec2(0u, 3u), vec2(1u, 1u),
    vec2(1u, 2u), vec2(1u, 3u), vec2(2u, 2u), vec2(2u, 3u), vec2(3u, 3u),
);

alias Row = array<vec4<f32>, QUADS>;

const_assert COLUMNS < 4u * QUADS;

// 1, the features of the surface, and what follows them: own features, then colours.
fn row_of(z: array<f32, SURFACE_FEATURES>, first: vec3<f32>, last: vec2<f32>) -> Row {
    return Row(vec4(1.0, z[0], z[1], z[2]), vec4(z[3], z[4], z[5], z[6]), vec4(z[7], z[8], first.xy), vec4(first.z, last, 0.0));
}

var<private> own_row: Row; // of the lane's pixel
// Of the pixel that counts most: with a 64th of the weight or more it is within eight deviations of the means, so squares lose at
// most six of their 24 bits.
var<workgroup> reference: Row;
var<workgroup> heaviest: atomic<u32>; // that pixel
// By pixel; later sums by share, block and row. The pass's own until the barrier before `sum_tile`.
var<workgroup> rows: array<vec4<f32>, TILE_PIXELS * QUADS>;
var<workgroup> sums: array<vec4<f32>, BLOCKS * 4u + 1u>; // the rows of all blocks, then the noises
var<workgroup> weights: array<f32, TILE_PIXELS>;
var<workgroup> noises: array<vec3<f32>, TILE_PIXELS>; // for the tile's variance, found and expected

// Call from uniform control flow, before a barrier that precedes `sum_tile`.
fn leave_out(lane: u32) {
    weights[lane] = 0.0;
    noises[lane] = vec3(0.0);
    if lane == 0u {
        atomicStore(&heaviest, 0u);
    }
}

// Whether the tile goes without moments, to save time: then it is written that it has none. Every other one has them, like the
// black squares of a chessboard; all windows hold some of these.
fn skip_tile(tile: vec2<u32>, lane: u32) -> bool {
    let skips = has(frame, FLAG_SPARSE) && (tile.x + tile.y) % 2u != 0u;
    if skips && lane == 0u {
        moments[(tile.y * frame.tiles.x + tile.x) * TILE_STRIDE] = vec4(0.0);
    }
    return skips;
}

// Call from uniform control flow, after a barrier that follows each lane's writes.
fn sum_tile(tile: vec2<u32>, lane: u32) {
    let root = sqrt(weights[lane]);
    // By the bits of its weight; the last six tell the lane.
    let bits = bitcast<u32>(weights[lane]) / TILE_PIXELS * TILE_PIXELS;
    atomicMax(&heaviest, bits | lane);
    workgroupBarrier();
    if lane == atomicLoad(&heaviest) % TILE_PIXELS {
        reference = own_row;
    }
    workgroupBarrier();
    for (var quad = 0u; quad < QUADS; quad++) {
        rows[lane * QUADS + quad] = root * (own_row[quad] - reference[quad]);
    }
    rows[lane * QUADS].x = root;
    workgroupBarrier();
    sum_blocks(lane);

    if lane < TILE_STRIDE {
        moments[(tile.y * frame.tiles.x + tile.x) * TILE_STRIDE + lane] = tile_quad(lane);
    }
}

// What is written of a tile (layout: include/features).
fn tile_quad(quad: u32) -> vec4<f32> {
    let total = max(product(0u, 0u), 1e-30);
    if quad == 0u {
        return vec4(product(0u, 0u), sums[BLOCKS * 4u].xyz / total);
    }
    var values = vec4(0.0);
    for (var i = 0u; i < 4u; i++) {
        let entry = 4u * quad + i;
        if entry >= TILE_SQUARES && entry < TILE_SQUARES + SQUARES {
            let ij = square_entry(entry - TILE_SQUARES) + 1u;
            values[i] = product(ij.x, ij.y) - product(0u, ij.x) / total * product(0u, ij.y);
        } else if entry < TILE_MEAN + COLUMNS {
            let at = entry - TILE_MEAN + 1u;
            values[i] = reference[at / 4u][at % 4u] + product(0u, at) / total;
        }
    }
    return values;
}

// Leaves the rows of all blocks in `sums`.
fn sum_blocks(lane: u32) {
    var block = array(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    let share = lane / BLOCKS;
    if share < SHARES {
        let quads = BLOCK_QUADS[lane % BLOCKS];
        for (var i = share; i < TILE_PIXELS; i += SHARES) {
            let a = rows[i * QUADS + quads.x];
            let b = rows[i * QUADS + quads.y];
            block[0] += a.x * b;
            block[1] += a.y * b;
            block[2] += a.z * b;
            block[3] += a.w * b;
        }
    } else {
        for (var i = lane - SHARES * BLOCKS; i < TILE_PIXELS; i += TILE_PIXELS - SHARES * BLOCKS) {
            block[0] += vec4(weights[i] * noises[i], 0.0);
        }
    }
    workgroupBarrier(); // all have read the rows that are now replaced
    for (var row = 0u; row < 4u; row++) {
        rows[lane * 4u + row] = block[row];
    }
    workgroupBarrier();
    var whole = vec4(0.0);
    if lane < BLOCKS * 4u {
        for (var i = 0u; i < SHARES; i++) {
            whole += rows[i * BLOCKS * 4u + lane];
        }
    } else if lane == BLOCKS * 4u {
        for (var i = SHARES * BLOCKS; i < TILE_PIXELS; i++) {
            whole += rows[i * 4u];
        }
    }
    if lane <= BLOCKS * 4u {
        sums[lane] = whole;
    }
    workgroupBarrier();
}

// Sum over the pixels of column i times column j >= i; column 0 is 1.
fn product(i: u32, j: u32) -> f32 {
    let a = i / 4u;
    let block = a * QUADS - a * (a + 1u) / 2u + j / 4u;
    return sums[block * 4u + i % 4u][j % 4u];
}
