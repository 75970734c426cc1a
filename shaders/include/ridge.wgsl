// Ridge regression from moments, solved by one workgroup of LANES invocations, which a pass says.
//
// The moments are about their means, so the constant is not part of the system and is not shrunk. Features are scaled to
// unit deviation first; slopes come back in the features' own units.
// The ridge is what keeps the system sound, and a prior: slopes beyond a change of 100 % per feature unit must be earned by
// samples, or a few pixels with features of their own would be fitted to their own noise.
// Source: Hoerl and Kennard, "Ridge Regression", Technometrics 1970; elimination above and below the pivot: Gauss and Jordan

const_assert FEATURES % 2u == 1u; // two rows at a time, and a last one
const COLUMN_LANES = 16u;
const ROW_STEP = LANES / COLUMN_LANES;
const_assert COLUMNS <= COLUMN_LANES && LANES % COLUMN_LANES == 0u;

var<workgroup> ridge_squares: array<vec4<f32>, SQUARE_QUADS>;       // in: sum w (z - mean z)(z - mean z)^T
var<workgroup> ridge_floors: array<f32, FEATURES>;                  // in: least deviation that counts
var<workgroup> ridge_priors: array<f32, FEATURES>;                  // in: ridge in the features' own units
var<workgroup> ridge_system: array<array<f32, COLUMNS>, FEATURES>;
var<workgroup> ridge_scales: array<f32, FEATURES>;
var<workgroup> ridge_slopes: array<array<f32, CHANNELS>, FEATURES>; // out

// Call from uniform control flow, after a barrier that follows the writes to the inputs above; `weight` is
// the total weight, above 0. Slopes are readable by all on return.
fn ridge_solve(weight: f32, lane: u32) {
    if lane < FEATURES {
        let deviation = sqrt(max(ridge_square(lane, lane), 0.0) / weight);
        ridge_scales[lane] = 1.0 / max(max(deviation, ridge_floors[lane]), 1e-20);
    }
    workgroupBarrier();
    // Each lane keeps to a column.
    let j = lane % COLUMN_LANES;
    let first = lane / COLUMN_LANES;
    if j < COLUMNS {
        let scale = select(1.0, ridge_scales[min(j, FEATURES - 1u)], j < FEATURES);
        for (var i = first; i <= min(j, FEATURES - 1u); i += ROW_STEP) {
            ridge_system[i][j] = ridge_square(i, j) * ridge_scales[i] * scale;
            if i == j {
                ridge_system[i][j] += RIDGE * weight + ridge_priors[i] * scale * scale;
            }
        }
    }
    workgroupBarrier();
    // Two rows at a time, which are final when their step begins; the others are freed of their columns by them alone, so one
    // barrier a step is enough. What lies below the diagonal is known by symmetry.
    for (var k = 0u; k + 2u < FEATURES; k += 2u) {
        if j >= k + 2u && j < COLUMNS {
            let right = pivot_inverse(k) * vec2(ridge_system[k][j], ridge_system[k + 1u][j]);
            for (var i = first; i <= min(j, FEATURES - 1u); i += ROW_STEP) {
                if i != k && i != k + 1u {
                    let left = vec2(ridge_entry(i, k), ridge_entry(i, k + 1u));
                    ridge_system[i][j] -= dot(left, right);
                }
            }
        }
        workgroupBarrier();
    }
    const LAST = FEATURES - 1u;
    for (var entry = lane; entry < FEATURES * CHANNELS; entry += LANES) {
        let i = entry / CHANNELS;
        let channel = entry % CHANNELS;
        var slope = ridge_system[LAST][FEATURES + channel] / ridge_system[LAST][LAST];
        if i < LAST {
            let k = i / 2u * 2u;
            let right = vec2(remainder(k, channel, slope), remainder(k + 1u, channel, slope));
            slope = (pivot_inverse(k) * right)[i - k];
        }
        ridge_slopes[i][channel] = slope * ridge_scales[i];
    }
    workgroupBarrier();
}

// Row i, column j >= i.
fn ridge_square(i: u32, j: u32) -> f32 {
    let entry = square_index(i, j);
    return ridge_squares[entry / 4u][entry % 4u];
}

// The upper triangle stands for both.
fn ridge_entry(i: u32, j: u32) -> f32 {
    return ridge_system[min(i, j)][max(i, j)];
}

// Inverse of the 2x2 block on the diagonal at row k.
fn pivot_inverse(k: u32) -> mat2x2<f32> {
    let a = ridge_system[k][k];
    let b = ridge_system[k][k + 1u];
    let d = ridge_system[k + 1u][k + 1u];
    return mat2x2(d, -b, -b, a) * (1.0 / (a * d - b * b));
}

// Right side of row k less what the last feature explains of it.
fn remainder(k: u32, channel: u32, last_slope: f32) -> f32 {
    return ridge_system[k][FEATURES + channel] - ridge_system[k][FEATURES - 1u] * last_slope;
}

fn luminance_slope(feature: u32) -> f32 {
    return dot(LUMINANCE, vec3(ridge_slopes[feature][0], ridge_slopes[feature][1], ridge_slopes[feature][2]));
}

// A third of a channel's row of the model (include/linear_model) through the columns' means, which a pass tells by
// `column_mean`.
fn model_part(channel: u32, part: u32) -> vec4<f32> {
    var row: vec4<f32>;
    for (var i = 0u; i < 4u; i++) {
        let at = 4u * part + i;
        if at == 0u {
            var value = column_mean(FEATURES + channel);
            for (var f = 0u; f < FEATURES; f++) {
                value -= ridge_slopes[f][channel] * column_mean(f);
            }
            row[i] = value;
        } else if at <= FEATURES {
            row[i] = ridge_slopes[at - 1u][channel];
        }
    }
    return row;
}
