// What every pass of a peer knows of the frame, and which input values count.

struct Frame {
    size: vec2<u32>,
    // Non-zero: no history.
    restart: u32,
    // Non-zero: motion.z holds previous minus current view depth.
    has_motion_z: u32,
    // A static point at view depth d and NDC position p was at depth
    // d * (per_depth.xy . p + per_depth.z) + (constant.xy . p + constant.z) in the previous frame.
    prev_depth_per_depth: vec4<f32>,
    prev_depth_constant: vec4<f32>,
    far: f32,
    // At least 1.
    max_history: f32,
    pad: vec2<u32>,
}

@group(0) @binding(0) var<uniform> frame: Frame;

const HALF_MAX = 65504.0;

// Tests the exponent's bits: compilers may assume that floats are never NaN.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

fn all_finite(v: vec3<f32>) -> bool {
    return all((bitcast<vec3<u32>>(v) & vec3(0x7f800000u)) != vec3(0x7f800000u));
}

// Radiance that a half-precision image can hold; what is not finite becomes black.
fn sanitise(v: vec3<f32>) -> vec3<f32> {
    let finite = (bitcast<vec3<u32>>(v) & vec3(0x7f800000u)) != vec3(0x7f800000u);
    return select(vec3(0.0), clamp(v, vec3(0.0), vec3(HALF_MAX)), finite);
}

fn is_miss(depth: f32) -> bool {
    return !is_finite(depth) || depth <= 0.0 || depth >= frame.far;
}

fn inside(pixel: vec2<i32>) -> bool {
    return all(pixel >= vec2(0)) && all(pixel < vec2<i32>(frame.size));
}

// Normalised device coordinates of a pixel's centre, and 1.
fn ndc_of(pixel: vec2<u32>) -> vec3<f32> {
    return vec3((vec2<f32>(pixel) + 0.5) / vec2<f32>(frame.size) * vec2(2.0, -2.0) + vec2(-1.0, 1.0), 1.0);
}
