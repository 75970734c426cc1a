// A linear model in memory: a head of four numbers, then for each channel its value at features 0 and its slopes.
//
// A pass binds an array of vec4.

const MODEL_ROW = 3u; // vec4s: 1 and up to 11 features
const MODEL_STRIDE = 1u + CHANNELS * MODEL_ROW;

// 1, then features, then zeros.
alias Regressors = array<vec4<f32>, MODEL_ROW>;

fn surface_regressors(z: array<f32, SURFACE_FEATURES>, own: vec2<f32>) -> Regressors {
    return Regressors(vec4(1.0, z[0], z[1], z[2]), vec4(z[3], z[4], z[5], z[6]), vec4(z[7], z[8], own));
}
