// accumulate: plain temporal accumulation, the simplest peer of the denoiser. Each pixel's radiance is averaged
// with its history, found along the motion vector; there is no spatial filter.
//
// Reads:  the G-buffer of this frame; mean, count and features of the previous frame.
// Writes: mean radiance and count; packed features; the output.
// Source: exponential and cumulative averaging with reprojection as in Yang, Liu and Salvi, "A Survey of Temporal
//         Antialiasing Techniques" (Computer Graphics Forum 2020), without colour clamping.

struct Params {
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
    max_history: f32,
    pad: vec2<u32>,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var normal_roughness: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var motion: texture_2d<f32>;
@group(0) @binding(5) var surface_id: texture_2d<u32>;
@group(0) @binding(6) var sample_count: texture_2d<u32>;
@group(0) @binding(7) var prev_mean: texture_2d<f32>;
@group(0) @binding(8) var prev_features: texture_2d<u32>;
@group(0) @binding(9) var out_mean: texture_storage_2d<rgba32float, write>;
@group(0) @binding(10) var out_features: texture_storage_2d<rgba32uint, write>;
@group(0) @binding(11) var output: texture_storage_2d<rgba16float, write>;

const WORKGROUP = 8u;
// History whose depth differs by more than this part of the expected depth shows another surface.
const DEPTH_TOLERANCE = 0.05;
// Cosine between normals of one surface in consecutive frames, at least.
const NORMAL_COSINE = 0.9;
// Bilinear taps that pass must hold this much of the weight together.
const MIN_WEIGHT = 0.01;
const HALF_MAX = 65504.0;

// Tests the exponent's bits: compilers may assume that floats are never NaN.
fn is_finite(x: f32) -> bool {
    return (bitcast<u32>(x) & 0x7f800000u) != 0x7f800000u;
}

fn sanitise(x: f32) -> f32 {
    return select(0.0, clamp(x, 0.0, HALF_MAX), is_finite(x));
}

fn is_miss(d: f32) -> bool {
    return !is_finite(d) || d <= 0.0 || d >= params.far;
}

// Octahedral map of a unit vector into the square.
fn pack_normal(n: vec3<f32>) -> u32 {
    let p = n.xy / max(abs(n.x) + abs(n.y) + abs(n.z), 1e-6);
    let folded = (1.0 - abs(p.yx)) * select(vec2(-1.0), vec2(1.0), p >= vec2(0.0));
    return pack2x16snorm(select(folded, p, n.z >= 0.0));
}

fn unpack_normal(packed: u32) -> vec3<f32> {
    let p = unpack2x16snorm(packed);
    let z = 1.0 - abs(p.x) - abs(p.y);
    let folded = (1.0 - abs(p.yx)) * select(vec2(-1.0), vec2(1.0), p >= vec2(0.0));
    return normalize(vec3(select(folded, p, z >= 0.0), z));
}

struct History {
    mean: vec3<f32>,
    count: f32,
}

// Bilinear history at `position` (in pixels) over the taps that show the same surface.
fn history_at(position: vec2<f32>, expected_depth: f32, normal: vec3<f32>, id: u32) -> History {
    var history = History(vec3(0.0), 0.0);
    let corner = position - 0.5;
    // Far outside, the conversion to integers below would not be defined.
    if any(corner <= vec2(-1.0)) || any(corner >= vec2<f32>(params.size)) {
        return history;
    }
    let base = vec2<i32>(floor(corner));
    let t = fract(corner);
    var total = 0.0;
    for (var i = 0; i < 4; i++) {
        let offset = vec2(i & 1, i >> 1);
        let tap = base + offset;
        if any(tap < vec2(0)) || any(tap >= vec2<i32>(params.size)) {
            continue;
        }
        let features = textureLoad(prev_features, tap, 0);
        let prev_depth = bitcast<f32>(features.x);
        let same = features.w != 0u && features.z == id
            && abs(prev_depth - expected_depth) <= DEPTH_TOLERANCE * abs(expected_depth)
            && dot(unpack_normal(features.y), normal) >= NORMAL_COSINE;
        if !same {
            continue;
        }
        let weights = select(1.0 - t, t, offset == vec2(1));
        let weight = weights.x * weights.y;
        let texel = textureLoad(prev_mean, tap, 0);
        history.mean += weight * texel.rgb;
        history.count += weight * texel.a;
        total += weight;
    }
    if total < MIN_WEIGHT {
        return History(vec3(0.0), 0.0);
    }
    return History(history.mean / total, history.count / total);
}

@compute @workgroup_size(WORKGROUP, WORKGROUP)
fn accumulate(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= params.size) {
        return;
    }
    let pixel = id.xy;
    let raw = textureLoad(radiance, pixel, 0).rgb;
    let current = vec3(sanitise(raw.r), sanitise(raw.g), sanitise(raw.b));
    let d = textureLoad(depth, pixel, 0).r;
    if is_miss(d) {
        textureStore(out_mean, pixel, vec4(current, 0.0));
        textureStore(out_features, pixel, vec4(0u));
        textureStore(output, pixel, vec4(current, 1.0));
        return;
    }
    let n = textureLoad(normal_roughness, pixel, 0).xyz;
    let normal = select(vec3(0.0, 0.0, 1.0), normalize(n), dot(n, n) > 1e-12);
    let surface = textureLoad(surface_id, pixel, 0).r;
    let position = vec2<f32>(pixel) + 0.5;

    var history = History(vec3(0.0), 0.0);
    let m = textureLoad(motion, pixel, 0).xyz;
    if params.restart == 0u && is_finite(m.x) && is_finite(m.y) && is_finite(m.z) {
        let ndc = vec3(position / vec2<f32>(params.size) * vec2(2.0, -2.0) + vec2(-1.0, 1.0), 1.0);
        let static_depth =
            d * dot(params.prev_depth_per_depth.xyz, ndc) + dot(params.prev_depth_constant.xyz, ndc);
        let expected = select(static_depth, d + m.z, params.has_motion_z != 0u);
        history = history_at(position + m.xy, expected, normal, surface);
    }

    var mean = history.mean;
    var count = history.count;
    if textureLoad(sample_count, pixel, 0).r > 0u {
        count = min(count, params.max_history - 1.0) + 1.0;
        mean += (current - mean) / count;
    }
    textureStore(out_mean, pixel, vec4(mean, count));
    // The last component tells a surface with history from misses, cleared texels and pixels never traced.
    let valid = select(0u, 1u, count > 0.0);
    textureStore(out_features, pixel, vec4(bitcast<u32>(d), pack_normal(normal), surface, valid));
    textureStore(output, pixel, vec4(mean, 1.0));
}
