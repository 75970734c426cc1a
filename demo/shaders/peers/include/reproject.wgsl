// Where a pixel's surface was in the previous frame, and which pixels of that frame show it. Needs `prev_surface`.

// History whose depth differs by more than this part of the expected depth shows another surface.
const DEPTH_TOLERANCE = 0.05;
// Cosine between normals of one surface in consecutive frames, at least.
const NORMAL_COSINE = 0.9;
// Bilinear taps that pass must hold this much of the weight together.
const MIN_WEIGHT = 0.01;

// View depth of the pixel's surface in the previous frame.
fn expected_depth(pixel: vec2<u32>, depth: f32, motion_z: f32) -> f32 {
    let ndc = ndc_of(pixel);
    let static_depth =
        depth * dot(frame.prev_depth_per_depth.xyz, ndc) + dot(frame.prev_depth_constant.xyz, ndc);
    return select(static_depth, depth + motion_z, frame.has_motion_z != 0u);
}

// Whether a pixel of the previous frame shows this surface, then at depth `expected`.
fn showed(tap: vec2<i32>, surface: Surface, expected: f32) -> bool {
    if !inside(tap) {
        return false;
    }
    let packed = textureLoad(prev_surface, tap, 0).xy;
    return is_sampled(packed) && id_of(packed) == surface.id
        && abs(depth_of(packed) - expected) <= DEPTH_TOLERANCE * abs(expected)
        && dot(normal_of(packed), surface.normal) >= NORMAL_COSINE;
}

// Where the pixel's centre was, in pixels; far outside where the motion is unusable or history is dropped.
fn prev_position(pixel: vec2<u32>, motion: vec3<f32>) -> vec2<f32> {
    let position = vec2<f32>(pixel) + 0.5 + motion.xy;
    // Far outside, a conversion to integers would not be defined.
    let usable = frame.restart == 0u && all_finite(motion)
        && all(position > vec2(-1.0)) && all(position < vec2<f32>(frame.size) + 1.0);
    return select(vec2(-8.0), position, usable);
}

// Bilinear taps at `position` over the pixels that showed the surface.
fn taps_at(position: vec2<f32>, surface: Surface, expected: f32) -> Taps {
    let corner = position - 0.5;
    let t = fract(corner);
    var taps = Taps(vec2<i32>(floor(corner)), vec4(1.0 - t, t).xzxz * vec4(1.0 - t, t).yyww);
    for (var i = 0; i < 4; i++) {
        if taps.weights[i] > 0.0 && !showed(taps.base + tap_offset(i), surface, expected) {
            taps.weights[i] = 0.0;
        }
    }
    let total = dot(taps.weights, vec4(1.0));
    taps.weights *= select(0.0, 1.0 / total, total >= MIN_WEIGHT);
    return taps;
}
