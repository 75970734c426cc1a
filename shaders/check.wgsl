// check: counts how well a frame's inputs agree with each other, as given and under suspicions of what may be wrong with them.
//
// Reads   the caller's images; what it kept of the previous frame; the cameras as they might be meant.
// Writes  guide: the surface (layout: include/surface); kept_motion: pixels, as bits of floats
//         statistics: counters (include/tally)
// Source  votes: of all pixels in which an explanation differs from what was given, how many each explains

//!include frame numbers noise surface signal demodulate inputs motion check_geometry check_motion check_light check_reflection tally

// Cameras as they might be meant.
struct Suspects {
    inverse_current: View,       // world from view was given
    inverse_previous: View,
    turned_current: View,        // the rotation is transposed
    turned_previous: View,
    before: View,                // of the frame before the previous one
    inverse_eye_delta: vec3<f32>,
    is_before_known: u32,
    turned_eye_delta: vec3<f32>,
    pad_0: u32,
    before_eye_delta: vec3<f32>,
    pad_1: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var albedo: texture_2d<f32>;
@group(0) @binding(3) var normal_roughness: texture_2d<f32>;
@group(0) @binding(4) var roughness: texture_2d<f32>;
@group(0) @binding(5) var depth: texture_2d<f32>;
@group(0) @binding(6) var motion: texture_2d<f32>;
@group(0) @binding(7) var surface_id: texture_2d<u32>;
@group(0) @binding(8) var emission: texture_2d<f32>;
@group(0) @binding(9) var sample_count: texture_2d<u32>;
@group(0) @binding(10) var hit_distance: texture_2d<f32>;
@group(0) @binding(11) var previous_guide: texture_2d<u32>;
@group(0) @binding(12) var previous_motion: texture_2d<u32>;
@group(0) @binding(13) var guide: texture_storage_2d<rg32uint, write>;
@group(0) @binding(14) var kept_motion: texture_storage_2d<rg32uint, write>;
@group(0) @binding(15) var<uniform> suspects: Suspects;
@group(0) @binding(16) var<storage, read_write> statistics: array<atomic<u32>>;

const TILE_CENTRE = 27u; // the lane whose surface is the tile's

@compute @workgroup_size(8, 8)
fn check(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    let is_inside = all(id.xy < frame.size);
    var surface: Surface;
    if is_inside {
        surface = read_surface(id.xy);
        keep(id.xy, surface);
    }
    clear_tallies(lane);
    lit[lane] = vec3(0.0);
    if lane == TILE_CENTRE {
        tile_surface = surface;
    }
    workgroupBarrier();
    if is_inside {
        check_geometry(id.xy, surface);
    }
    if is_inside && is_miss(surface) {
        let value = stored_depth(id.xy);
        tally(FIRST_LIGHT + PIXELS, true);
        tally(FIRST_LIGHT + DEPTH_NEGATIVE, is_finite(value) && value < 0.0);
    } else if is_inside {
        check_light(id.xy, surface);
        enter_lit(id.xy, lane, surface);
        if has(frame, FLAG_HIT_DISTANCE) {
            check_reflection(id.xy, surface);
        }
        let moved = moved_px(id.xy);
        if has(frame, FLAG_HISTORY) && is_finite(moved.x) && is_finite(moved.y) {
            check_motion(id.xy, surface, moved);
            check_ids(id.xy, surface, moved);
        }
    }
    if is_inside && suspects.is_before_known != 0u {
        check_lateness(id.xy);
    }
    workgroupBarrier();
    if lane == 0u {
        check_slopes();
    }
    workgroupBarrier();
    leave_tallies(lane);
}

fn moved_px(pixel: vec2<u32>) -> vec2<f32> {
    return motion_at(pixel).xy * frame.current.size;
}

fn keep(pixel: vec2<u32>, surface: Surface) {
    textureStore(guide, pixel, vec4(pack_surface(surface), 0u, 0u));
    textureStore(kept_motion, pixel, vec4(bitcast<vec2<u32>>(moved_px(pixel)), 0u, 0u));
}
