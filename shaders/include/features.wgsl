// The features that the linear models predict from, and how their moments and models are laid out. This is the one table.
//
// Source: Moon et al., "Adaptive Rendering with Linear Predictions", SIGGRAPH 2015, section 4, with 1/albedo added: after
// demodulation radiance = albedo E + S becomes E + S / albedo, linear in 1/albedo.

const SURFACE_FEATURES = 9u;
// A pass that fits models says how many features of its own (OWN_FEATURES) follow those of the surface.
const FEATURES = SURFACE_FEATURES + OWN_FEATURES; // without the constant
const CHANNELS = 3u;
const COLUMNS = FEATURES + CHANNELS;
const SQUARES = COLUMNS * (COLUMNS + 1u) / 2u; // upper triangle, row by row

//  0..2  world normal
//  3..5  world position relative to the eye; of the specular signal, of what is reflected
//  6     1/albedo; of the specular signal, how near what it reflects is
//  7     surface id, hashed: where a window holds two surfaces, each gets a level of its own
//  8     roughness
fn surface_features(s: Surface, position: vec3<f32>) -> array<f32, SURFACE_FEATURES> {
    var seen = position;
    var cue = s.cue;
    if IS_SPECULAR {
        // What a mirror shows is as smooth as what is reflected; a rough lobe takes in too much for that.
        let eye = towards_eye(frame.current, position);
        let farther = select(0.0, 1.0 / max(s.cue, LEAST_CUE) - 1.0, s.cue > 0.0);
        let hit_distance = ray_length(frame.current, position) * farther;
        let mirrored = saturate(1.0 - s.roughness / MIRROR_ROUGHNESS);
        seen += mirrored * hit_distance * reflect(-eye, s.normal);
        cue *= mirrored;
    }
    return array(
        s.normal.x, s.normal.y, s.normal.z,
        seen.x, seen.y, seen.z,
        cue,
        f32(s.id) * (2.0 / f32(IDS - 1u)) - 1.0,
        s.roughness,
    );
}

const MIRROR_ROUGHNESS = 0.2;
const LEAST_CUE = 0.0625; // beyond it, the code's steps would be steps of the position

// The least standard deviation over a window that still counts as variation, per feature. `depth` is the window's.
fn feature_floor(feature: u32, depth: f32) -> f32 {
    return select(0.05, 0.02 * depth, feature >= 3u && feature <= 5u);
}

// The change of a feature over which colour may be expected to change by as much as it is.
fn feature_unit(feature: u32, depth: f32) -> f32 {
    if feature >= 3u && feature <= 5u {
        return 0.1 * depth;
    }
    return select(1.0, 0.1, feature == 7u); // nine in ten pairs of hashed ids differ by more
}

// Place of row i, column j >= i in the triangle.
fn square_index(i: u32, j: u32) -> u32 {
    return i * COLUMNS - i * (i + 1u) / 2u + j;
}

// Row and column of a place in the triangle.
fn square_entry(index: u32) -> vec2<u32> {
    // Counted from the end, row k holds k + 1 entries. The half keeps the root off the integers, where rounding matters.
    let from_end = SQUARES - 1u - index;
    let k = u32((sqrt(8.0 * f32(from_end) + 1.5) - 1.0) * 0.5);
    let row = COLUMNS - 1u - k;
    return vec2(row, COLUMNS - 1u - (from_end - k * (k + 1u) / 2u));
}

// Rows and columns of four places in the triangle, one after the other; beyond its end its last one.
struct SquareQuad {
    rows: vec4<u32>,
    columns: vec4<u32>,
}

fn square_quad(quad: u32) -> SquareQuad {
    var found: SquareQuad;
    for (var i = 0u; i < 4u; i++) {
        let ij = square_entry(min(4u * quad + i, SQUARES - 1u));
        found.rows[i] = ij.x;
        found.columns[i] = ij.y;
    }
    return found;
}

// A tile in memory, as vec4s: weight, pooled variance of one sample, the mean's variance as found by bootstrap, samples in the temporal
// mean; then means of the columns; then squares about those means. What is left of a vec4 is 0.
const TILE_WEIGHT = 0u;
const TILE_VARIANCE = 1u;
const TILE_FOUND = 2u;
const TILE_EXPECTED = 3u;
const TILE_MEAN = 4u;
const MEAN_QUADS = (COLUMNS + 3u) / 4u;
const TILE_SQUARES = TILE_MEAN + 4u * MEAN_QUADS;
const SQUARE_QUADS = (SQUARES + 3u) / 4u;
const TILE_STRIDE = 1u + MEAN_QUADS + SQUARE_QUADS; // vec4s

// How much more a noiseless part may count than the average one: a variance from few samples may be 0 by luck.
const VARIANCE_FLOOR = 0.1;

// What the weight of a part, whose variance is `noise` times that of the whole, is multiplied by: inverse variance, bounded.
fn variance_factor(noise: f32) -> f32 {
    return (1.0 + VARIANCE_FLOOR) / (noise + VARIANCE_FLOOR);
}
