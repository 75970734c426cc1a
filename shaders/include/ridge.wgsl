// Ridge regression from moments, solved by one workgroup of RIDGE_LANES invocations.
//
// The moments are about their means, so the constant is not part of the system and is not shrunk. Features are scaled to
// unit deviation first; slopes come back in the features' own units.
// The ridge is what keeps the system sound, and a prior: slopes beyond a change of 100 % per feature unit must be earned by
// samples, or a few pixels with features of their own would be fitted to their own noise.
// Source: Hoerl and Kennard, "Ridge Regression", Technometrics 1970; elimination of a symmetric matrix as L D L^T.

const RIDGE_LANES = 64u;

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
    // Row k is final when step k begins; the rows below it are updated from it alone, so one barrier a step is enough.
    for (var k = 0u; k + 1u < FEATURES; k++) {
        let side = COLUMNS - 1u - k;
        for (var entry = lane; entry < (FEATURES - 1u - k) * side; entry += RIDGE_LANES) {
            let i = k + 1u + entry / side;
            let j = k + 1u + entry % side;
            if j >= i {
                ridge_system[i][j] -= ridge_system[k][i] / ridge_system[k][k] * ridge_system[k][j];
            }
        }
        workgroupBarrier();
    }
    if lane < CHANNELS {
        for (var step = 0u; step < FEATURES; step++) {
            let k = FEATURES - 1u - step;
            var value = ridge_system[k][FEATURES + lane];
            for (var j = k + 1u; j < FEATURES; j++) {
                // Slopes found so far are already in plain units.
                value -= ridge_system[k][j] * ridge_slopes[j][lane] / ridge_scales[j];
            }
            ridge_slopes[k][lane] = value / ridge_system[k][k] * ridge_scales[k];
        }
    }
    workgroupBarrier();
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
