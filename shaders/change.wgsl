// change: moments of features and of what this frame's samples differ by from the history, per region of 8x8 pixels.
//
// Reads   signal, guide; reprojected history and noise.
// Writes  tile_means, tile_squares_low, tile_squares_high, of regions (layout: include/features)
// Source  design of the innovation: the Kalman filter's term for what a measurement adds; sums: include/tile_moments

//!include frame numbers noise surface features innovations tile_moments

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var signal: texture_2d<f32>;
@group(0) @binding(2) var guide: texture_2d<u32>;
@group(0) @binding(3) var reprojected: texture_2d<f32>;
@group(0) @binding(4) var reprojected_noise: texture_2d<f32>;
@group(0) @binding(5) var<storage, read_write> tile_means: array<f32>;
@group(0) @binding(6) var<storage, read_write> tile_squares_low: array<f32>;
@group(0) @binding(7) var<storage, read_write> tile_squares_high: array<f32>;

const MOMENT_TILE = REGION;

@compute @workgroup_size(8, 8)
fn change(@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    load_pixel(lane_pixel(group.xy, lane), lane);
    sum_tiles(group.xy, lane, frame.regions);
}

// A pixel without samples or without history enters with weight 0.
fn load_pixel(pixel: vec2<u32>, lane: u32) {
    leave_out(lane);
    if any(pixel >= frame.size) {
        return;
    }
    let sample = textureLoad(signal, pixel, 0);
    let old = textureLoad(reprojected, pixel, 0);
    let surface = unpack_surface(textureLoad(guide, pixel, 0));
    if is_miss(surface) || sample.w <= 0.0 || old.w <= 0.0 {
        return;
    }
    write_surface(pixel, surface, lane);
    columns[lane][FEATURES] = sample.r - old.r;
    columns[lane][FEATURES + 1u] = sample.g - old.g;
    columns[lane][FEATURES + 2u] = sample.b - old.b;
    weights[lane] = sample.w;
    let own = unpack_noise(textureLoad(reprojected_noise, pixel, 0));
    noises[lane] = vec3(own.variance, luminance(old.rgb), old.w);
}
