// bmfr_fit: fits the accumulated signal of each block by its features, and predicts it.
//
// Reads:  the accumulated signal; normal and depth of this frame.
// Writes: the fitted signal.
// Source: Koskela et al., "Blockwise Multi-Order Feature Regression for Real-Time Path-Tracing Reconstruction"
//         (TOG 2019), the regression itself: blocks of 32x32 pixels that shift from frame to frame, features of first and
//         second order, Householder QR, and noise in the features against rank deficiency.
//
// One workgroup per block. A thread holds four rows of the block's matrix in registers. The triangle that they are
// reduced to, in workgroup memory, begins as the regularisation: noise of variance s^2 in n rows of a feature adds
// n s^2 to its square sum, in expectation, and so does one more row with sqrt(n) s for it. This is the paper's noise
// without its randomness.

//!include frame
//!include bmfr_rows

struct Blocks {
    // Position relative to the camera, along world axes: (depth * per_depth + constant) * (ndc.x, ndc.y, 1).
    position_per_depth: mat3x3<f32>,
    position_constant: mat3x3<f32>,
    // Of the first block, in pixels; at most 0.
    origin: vec2<i32>,
    pad: vec2<u32>,
}

@group(0) @binding(1) var<uniform> blocks: Blocks;
@group(0) @binding(2) var mean: texture_2d<f32>;
@group(0) @binding(3) var normal_roughness: texture_2d<f32>;
@group(0) @binding(4) var depth: texture_2d<f32>;
@group(0) @binding(5) var out_fitted: texture_storage_2d<rgba16float, write>;

const BLOCK = 32;
const THREADS = 256u;
// Pixels of a block per thread.
const ROWS = 4;
// Variance of the noise that the paper's implementation adds to the features: uniform in +-0.01.
const NOISE_VARIANCE = 0.01 * 0.01 / 3.0;
// Positions of a block that differ by less than this part of their size are one, to rounding.
const FLAT = 1e-6;
// Threads that sum up one column, each its share of the threads' values.
const PARTS = 16u;
const SHARE = THREADS / PARTS;

var<workgroup> scratch: array<f32, THREADS * COLUMNS>;
var<workgroup> partial: array<f32, PARTS * COLUMNS>;
// What each column loses of a row per pivot in the current reflection.
var<workgroup> factors: array<f32, COLUMNS>;
// The upper triangle, and the right-hand sides next to it.
var<workgroup> triangle: array<f32, FEATURES * COLUMNS>;
// Per channel.
var<workgroup> coefficients: array<f32, 3u * FEATURES>;

fn pixel_of(block: vec2<u32>, thread: u32, row: i32) -> vec2<i32> {
    let i = i32(thread) + row * i32(THREADS);
    return blocks.origin + BLOCK * vec2<i32>(block) + vec2(i % BLOCK, i / BLOCK);
}

// Puts a thread's row where the columns are summed up.
fn put(thread: u32, row: Row) {
    let at = thread * COLUMNS;
    for (var i = 0u; i < 4u; i++) {
        scratch[at + i] = row.a[i];
        scratch[at + 4u + i] = row.b[i];
        scratch[at + 8u + i] = row.c[i];
    }
    scratch[at + 12u] = row.d;
}

struct Range {
    low: vec3<f32>,
    high: vec3<f32>,
}

// The range of positions over the whole block, from those of its threads.
fn range_of_block(thread: u32, own: Range) -> Range {
    put(thread, Row(vec4(own.low, 0.0), vec4(own.high, 0.0), vec4(0.0), 0.0));
    workgroupBarrier();
    var range = own;
    if thread < PARTS {
        for (var i = thread * SHARE; i < (thread + 1u) * SHARE; i++) {
            let at = i * COLUMNS;
            range.low = min(range.low, vec3(scratch[at], scratch[at + 1u], scratch[at + 2u]));
            range.high = max(range.high, vec3(scratch[at + 4u], scratch[at + 5u], scratch[at + 6u]));
        }
        for (var c = 0u; c < 3u; c++) {
            partial[thread * COLUMNS + c] = range.low[c];
            partial[thread * COLUMNS + 4u + c] = range.high[c];
        }
    }
    workgroupBarrier();
    for (var part = 0u; part < PARTS; part++) {
        let at = part * COLUMNS;
        range.low = min(range.low, vec3(partial[at], partial[at + 1u], partial[at + 2u]));
        range.high = max(range.high, vec3(partial[at + 4u], partial[at + 5u], partial[at + 6u]));
    }
    workgroupBarrier();
    return range;
}

// The paper's features are scaled to -1 to 1 within the block. Squares are taken of scaled positions: with the
// constant and linear features they span what squares of world positions span, and keep their digits far from the
// origin.
fn scaled(position: vec3<f32>, range: Range) -> vec3<f32> {
    let extent = range.high - range.low;
    let flat = extent <= FLAT * max(abs(range.low), abs(range.high));
    return select((2.0 * position - range.low - range.high) / extent, vec3(0.0), flat);
}

// One Householder reflection: turns column k of the triangle's row k and of all the block's rows into row k alone
// (Golub and Van Loan, "Matrix Computations", section 5.1, for a triangle on top of more rows). `dots` are this
// thread's products of column k with all columns.
fn reflect_triangle(thread: u32, k: u32, dots: Row) {
    put(thread, dots);
    workgroupBarrier();
    if thread < PARTS * COLUMNS {
        let column = thread % COLUMNS;
        let part = thread / COLUMNS;
        var sum = 0.0;
        for (var i = part * SHARE; i < (part + 1u) * SHARE; i++) {
            sum += scratch[i * COLUMNS + column];
        }
        partial[part * COLUMNS + column] = sum;
    }
    workgroupBarrier();
    var reduced = 0.0;
    if thread < COLUMNS {
        var product = 0.0;
        var square = 0.0;
        for (var part = 0u; part < PARTS; part++) {
            product += partial[part * COLUMNS + thread];
            square += partial[part * COLUMNS + k];
        }
        let top = triangle[k * COLUMNS + k];
        let right = triangle[k * COLUMNS + thread];
        let length = sqrt(top * top + square);
        let v = top + select(-length, length, top >= 0.0);
        let norm = v * v + square;
        let factor = select(0.0, 2.0 * (v * right + product) / norm, norm > 0.0);
        factors[thread] = factor;
        reduced = right - factor * v;
        // The first column is all ones, so that its square is the number of rows.
        if k == 0u && thread > 0u && thread < FEATURES {
            triangle[thread * COLUMNS + thread] = sqrt(square * NOISE_VARIANCE);
        }
    }
    workgroupBarrier();
    if thread < COLUMNS {
        triangle[k * COLUMNS + thread] = reduced;
    }
}

fn factor_row() -> Row {
    return Row(
        vec4(factors[0], factors[1], factors[2], factors[3]),
        vec4(factors[4], factors[5], factors[6], factors[7]),
        vec4(factors[8], factors[9], factors[10], factors[11]),
        factors[12],
    );
}

// Back substitution for one channel.
fn solve(channel: u32) {
    for (var left = FEATURES; left > 0u; left--) {
        let k = left - 1u;
        var rest = triangle[k * COLUMNS + FEATURES + channel];
        for (var j = left; j < FEATURES; j++) {
            rest -= triangle[k * COLUMNS + j] * coefficients[channel * FEATURES + j];
        }
        let diagonal = triangle[k * COLUMNS + k];
        // Zero where the block has no rows.
        coefficients[channel * FEATURES + k] = select(0.0, rest / diagonal, diagonal != 0.0);
    }
}

fn predicted(features: Row, channel: u32) -> f32 {
    var sum = 0.0;
    for (var k = 0u; k < FEATURES; k++) {
        sum += entry(features, k) * coefficients[channel * FEATURES + k];
    }
    return clamp(sum, 0.0, HALF_MAX);
}

@compute @workgroup_size(THREADS)
fn bmfr_fit(@builtin(workgroup_id) block: vec3<u32>, @builtin(local_invocation_index) thread: u32) {
    var normals: array<vec3<f32>, ROWS>;
    var positions: array<vec3<f32>, ROWS>;
    // Bit i: row i is a surface.
    var surfaces = 0u;
    var range = Range(vec3(3e38), vec3(-3e38));
    for (var i = 0; i < ROWS; i++) {
        let pixel = pixel_of(block.xy, thread, i);
        if inside(pixel) {
            let d = textureLoad(depth, pixel, 0).r;
            if !is_miss(d) {
                let ndc = ndc_of(vec2<u32>(pixel));
                let normal = textureLoad(normal_roughness, pixel, 0).xyz;
                normals[i] = select(vec3(0.0), normal, all_finite(normal));
                positions[i] = d * (blocks.position_per_depth * ndc) + blocks.position_constant * ndc;
                surfaces |= 1u << u32(i);
                range = Range(min(range.low, positions[i]), max(range.high, positions[i]));
            }
        }
    }
    range = range_of_block(thread, range);

    var rows: array<Row, ROWS>;
    for (var i = 0; i < ROWS; i++) {
        positions[i] = scaled(positions[i], range);
        if (surfaces & (1u << u32(i))) != 0u {
            let signal = textureLoad(mean, pixel_of(block.xy, thread, i), 0);
            // Pixels without a sample are predicted, not fitted to.
            if signal.a > 0.0 {
                rows[i] = row_of(normals[i], positions[i], signal.rgb);
            }
        }
    }
    if thread < COLUMNS {
        for (var k = 0u; k < FEATURES; k++) {
            triangle[k * COLUMNS + thread] = 0.0;
        }
    }
    for (var k = 0u; k < FEATURES; k++) {
        var dots = Row(vec4(0.0), vec4(0.0), vec4(0.0), 0.0);
        for (var i = 0; i < ROWS; i++) {
            dots = add_scaled(dots, entry(rows[i], k), rows[i]);
        }
        reflect_triangle(thread, k, dots);
        let reflection = factor_row();
        for (var i = 0; i < ROWS; i++) {
            rows[i] = add_scaled(rows[i], -entry(rows[i], k), reflection);
        }
    }
    workgroupBarrier();
    if thread < 3u {
        solve(thread);
    }
    workgroupBarrier();
    for (var i = 0; i < ROWS; i++) {
        if (surfaces & (1u << u32(i))) != 0u {
            let features = row_of(normals[i], positions[i], vec3(0.0));
            let fitted = vec3(predicted(features, 0u), predicted(features, 1u), predicted(features, 2u));
            textureStore(out_fitted, pixel_of(block.xy, thread, i), vec4(fitted, 1.0));
        }
    }
}
