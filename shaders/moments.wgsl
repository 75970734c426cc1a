// moments: weighted first and second moments of features and temporal means, per tile of 4x4 pixels.
//
// Reads   guide, history, noise.
// Writes  tile_means, tile_squares_low, tile_squares_high (layout: include/features)
// Source  Moon et al. 2015, section 4: what a linear fit needs to know of its pixels; sums: include/tile_moments

//!include frame numbers noise surface features tile_moments

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var guide: texture_2d<u32>;
@group(0) @binding(2) var history: texture_2d<f32>;
@group(0) @binding(3) var noise: texture_2d<f32>;
@group(0) @binding(4) var<storage, read_write> tile_means: array<f32>;
@group(0) @binding(5) var<storage, read_write> tile_squares_low: array<f32>;
@group(0) @binding(6) var<storage, read_write> tile_squares_high: array<f32>;

const MOMENT_TILE = TILE;
const OWN_FEATURES = 2u; // pixel position

@compute @workgroup_size(8, 8)
fn moments(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    load_pixel(lane_pixel(group.xy, lane), lane);
    sum_tiles(group.xy, lane, frame.tiles);
}

// A pixel outside the frame, without a surface or without samples enters with weight 0.
fn load_pixel(pixel: vec2<u32>, lane: u32) {
    leave_out(lane);
    if any(pixel >= frame.size) {
        return;
    }
    let surface = unpack_surface(textureLoad(guide, pixel, 0));
    let mean = textureLoad(history, pixel, 0);
    if is_miss(surface) || mean.w <= 0.0 {
        return;
    }
    write_surface(pixel, surface, lane);
    columns[lane][SURFACE_FEATURES] = f32(pixel.x);
    columns[lane][SURFACE_FEATURES + 1u] = f32(pixel.y);
    columns[lane][FEATURES] = mean.r;
    columns[lane][FEATURES + 1u] = mean.g;
    columns[lane][FEATURES + 2u] = mean.b;
    // The mean of n samples has n times the certainty of one; how noisy one is here is judged per tile, in `fit`: a
    // weight from a pixel's own samples would favour those that happen to be dark.
    weights[lane] = mean.w;
    let own = unpack_noise(textureLoad(noise, pixel, 0));
    noises[lane] = vec3(own.variance, found_variance(own.deviations), own.variance / max(mean.w, 1e-3));
}
