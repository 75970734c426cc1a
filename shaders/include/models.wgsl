// The sparse linear models: how they lie in memory, and the grid of their centres. A model belongs to the tile that is its
// centre; a tile's entry in `windows` is the radius of its model's window in tiles, 0 for no model.

const MODEL_OWN_FEATURES = 2u; // pixel position
const OWN_FEATURES = MODEL_OWN_FEATURES;

// A model in memory: weight, noise gain (found over expected variance of the temporal means), relative noise (variance of
// one sample over the squared mean), trust (1 where the model fits, less where it does not), predicted squared error, means
// of the columns (its origin and its value there), slopes per feature and channel.
const MODEL_WEIGHT = 0u;
const MODEL_NOISE_GAIN = 1u;
const MODEL_RELATIVE_NOISE = 2u;
const MODEL_TRUST = 3u;
const MODEL_ERROR = 4u;
const MODEL_MEAN = 5u;
const MODEL_SLOPE = MODEL_MEAN + COLUMNS;
const MODEL_STRIDE = MODEL_SLOPE + FEATURES * CHANNELS;

const WIDEST_WINDOW = 3u; // tiles on each side of the centre

// Half a window's width in pixels.
fn window_reach(radius: u32) -> f32 {
    return (f32(radius) + 0.5) * f32(TILE);
}

// Weight of a model at `offset` pixels from the middle of its centre tile: falls to 0 at its window's border.
fn tent(offset: vec2<f32>, radius: u32) -> f32 {
    let sides = max(1.0 - abs(offset) / window_reach(radius), vec2(0.0));
    return sides.x * sides.y;
}

// A level's work: the arguments of an indirect dispatch, then the number of centres.
const LEVEL_COLUMNS = 64u; // workgroups in x
const LEVEL_WORDS = 4u;
const LEVEL_ROWS = 1u;
const LEVEL_COUNT = 3u;

// Coverage of a tile is the sum of the tents of all models at its middle, in this unit.
const COVERAGE_ONE = 256u;
