// Ridge regression from moments, solved by one workgroup of RIDGE_LANES invocations.
//
// The moments are about their means, so the constant is not part of the system and is not shrunk. Features are scaled to
// unit deviation first; slopes come back in the features' own units.
// The ridge is what keeps the system sound, and a prior: slopes beyond a change of 100 % per feature unit must be earned by
// samples, or a few pixels with features of their own would be fitted to their own noise.
// Source: Hoerl and Kennard, "Ridge Regression", Technometrics 1970; elimination of a symmetric matrix as L D L^T.

const RIDGE_LANES = 64u;
const_assert FEATURES % 2u == 1u; // two rows at a time, and a last one

var<workgroup> ridge_squares: array<f32, SQUARES>;                  // in: sum w (z - mean z)(z - mean z)^T
var<workgroup> ridge_floors: array<f32, FEATURES>;                  // in: least deviation that counts
var<workgroup> ridge_priors: array<f32, FEATURES>;                  // in: ridge in the features' own units
var<workgroup> ridge_system: array<array<f32, COLUMNS>, FEATURES>;
var<workgroup> ridge_scales: array<f32, FEATURES>;
var<workgroup> ridge_slopes: array<array<f32, CHANNELS>, FEATURES>; // out

// Call from uniform control flow, after a barrier that follows the writes to the inputs above; `weight` is
// the total weight, above 0. Slopes are readable by all on return.
fn ridge_solve(weight: f32, lane: u32) {
    if lane < FEATURES {
        let deviation = sqrt(max(ridge_squares[square_index(lane, lane)], 0.0) / weight);
        ridge_scales[lane] = 1.0 / max(max(deviation, ridge_floors[lane]), 1e-20);
    }
    workgroupBarrier();
    for (var entry = lane; entry < FEATURES * COLUMNS; entry += RIDGE_LANES) {
        let i = entry / COLUMNS;
        let j = entry % COLUMNS;
        if j < i {
            continue;
        }
        var value = ridge_squares[square_index(i, j)] * ridge_scales[i];
        if j < FEATURES {
            value *= ridge_scales[j];
        }
        if i == j {
            value += RIDGE * weight + ridge_priors[i] * ridge_scales[i] * ridge_scales[i];
        }
        ridge_system[i][j] = value;
    }
    workgroupBarrier();
    // Two rows at a time, which are final when their step begins; the rows below are updated from them alone, so one barrier
    // a step is enough.
    for (var k = 0u; k + 2u < FEATURES; k += 2u) {
        let inverse = pivot_inverse(k);
        let side = COLUMNS - 2u - k;
        for (var entry = lane; entry < (FEATURES - 2u - k) * side; entry += RIDGE_LANES) {
            let i = k + 2u + entry / side;
            let j = k + 2u + entry % side;
            if j >= i {
                let left = vec2(ridge_system[k][i], ridge_system[k + 1u][i]);
                let right = vec2(ridge_system[k][j], ridge_system[k + 1u][j]);
                ridge_system[i][j] -= dot(left, inverse * right);
            }
        }
        workgroupBarrier();
    }
    if lane < CHANNELS {
        let last = FEATURES - 1u;
        ridge_slopes[last][lane] = remainder(last, last + 1u, lane) / ridge_system[last][last] * ridge_scales[last];
        for (var step = 2u; step < FEATURES; step += 2u) {
            let k = last - step;
            let slopes = pivot_inverse(k) * vec2(remainder(k, k + 2u, lane), remainder(k + 1u, k + 2u, lane));
            ridge_slopes[k][lane] = slopes.x * ridge_scales[k];
            ridge_slopes[k + 1u][lane] = slopes.y * ridge_scales[k + 1u];
        }
    }
    workgroupBarrier();
}

// Inverse of the 2x2 block on the diagonal at row k.
fn pivot_inverse(k: u32) -> mat2x2<f32> {
    let a = ridge_system[k][k];
    let b = ridge_system[k][k + 1u];
    let d = ridge_system[k + 1u][k + 1u];
    return mat2x2(d, -b, -b, a) * (1.0 / (a * d - b * b));
}

// Right side of row k less what the slopes from `begin` on, which are found and in plain units, explain of it.
fn remainder(k: u32, begin: u32, channel: u32) -> f32 {
    var value = ridge_system[k][FEATURES + channel];
    for (var j = begin; j < FEATURES; j++) {
        value -= ridge_system[k][j] * ridge_slopes[j][channel] / ridge_scales[j];
    }
    return value;
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
