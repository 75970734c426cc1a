// The sparse linear models: how they lie in memory, and the grid of their centres. A model belongs to the tile that is its
// centre; a tile's entry in `windows` is its model's window, 1 to 3 (include/windows), 0 for no model, and in the bits above
// how many frames ago it was fitted.

const MODEL_OWN_FEATURES = 2u; // pixel position

// The head of a model (include/linear_model): trust (1 where it fits, less where it does not, above 0); noise
// gain (found over expected variance of the temporal means); relative noise (variance of one sample over the squared mean);
// predicted squared error.
const HEAD_TRUST = 0u;
const HEAD_NOISE_GAIN = 1u;
const HEAD_RELATIVE_NOISE = 2u;
const HEAD_ERROR = 3u;

// A level's work: the arguments of an indirect dispatch, then the number of centres.
const LEVEL_COLUMNS = 64u; // workgroups in x
const LEVEL_WORDS = 4u;
const LEVEL_ROWS = 1u;
const LEVEL_COUNT = 3u;

// Models that were kept from earlier frames, counted after the levels.
const KEPT_COUNT = LEVELS * LEVEL_WORDS;

// Coverage of a tile is the sum of the tents of all models at its middle, in this unit.
const COVERAGE_ONE = 256u;

const WINDOW_BITS = 2u; // of a tile's entry in `windows`

fn stored_window(entry: u32) -> u32 {
    return entry & ((1u << WINDOW_BITS) - 1u);
}

// `kept` holds, per tile, the entry that `windows` had in the frame before; under a budget 0 where its model holds no longer,
// and in the bits above the bucket of the gain that another model is expected to bring, 0 where the tile needs none.
const KEPT_BITS = 16u;
const BUCKETS = 1024u; // of each level in `histogram`, by rising gain

// Centre of the coarsest level in whose cell a tile is. Under a budget the last cells' are moved into the frame, so that
// their windows reach all tiles.
fn coarsest_centre(frame: Frame, tile: vec2<u32>) -> vec2<u32> {
    let stride = frame.levels[0].stride;
    return min(tile / stride * stride + stride / 2u, frame.tiles - 1u);
}

// What the models say of a pixel.
struct Prediction {
    signal: vec3<f32>,   // demodulated radiance
    noise_gain: f32,     // found over expected variance of the temporal mean, 0..1
    relative_noise: f32, // variance of one sample over its squared mean; < 0 where no model reaches
}

const NO_PREDICTION = Prediction(vec3(0.0), 0.0, -1.0);

fn is_known(p: Prediction) -> bool {
    return p.relative_noise >= 0.0;
}

const RELATIVE_NOISE_OCTAVES = vec2(-15.0, 26.0); // the least, and how many

// In two words: the signal in half precision, the gain in 8 bits, the relative noise, logarithmic, in 8.
fn pack_prediction(p: Prediction) -> vec2<u32> {
    let octave = log2(max(p.relative_noise, 1e-30)) - RELATIVE_NOISE_OCTAVES.x;
    let code = u32(clamp(octave / RELATIVE_NOISE_OCTAVES.y, 0.0, 1.0) * 254.0 + 1.5);
    let noises = u32(saturate(p.noise_gain) * 255.0 + 0.5) | (select(0u, code, is_known(p)) << 8u);
    return vec2(pack2x16float(p.signal.rg), (pack2x16float(vec2(p.signal.b, 0.0)) & 0xffffu) | (noises << 16u));
}

fn unpack_prediction(words: vec2<u32>) -> Prediction {
    let noises = words.y >> 16u;
    let octave = f32((noises >> 8u) - 1u) / 254.0 * RELATIVE_NOISE_OCTAVES.y + RELATIVE_NOISE_OCTAVES.x;
    return Prediction(
        vec3(unpack2x16float(words.x), unpack2x16float(words.y).x),
        f32(noises & 255u) / 255.0,
        select(-1.0, exp2(octave), noises >= 256u),
    );
}

// Standard error of a temporal mean of `count` samples of which one varies by `variance`. With a prior sample, as noisy as the
// models' windows are: few samples that all were dark are no certainty.
fn standard_error(p: Prediction, variance: f32, count: f32) -> f32 {
    let l = luminance(p.signal);
    return sqrt((p.noise_gain * variance * count + p.relative_noise * l * l) / (count + 1.0) / count);
}
