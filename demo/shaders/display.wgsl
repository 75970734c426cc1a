// display: shows one image, or two side by side on one split screen, in the viewport's rectangle.
//
// Reads:  two images of one size, scene-linear radiance or colours that are shown as they are.
// Writes: the window. Values that are not finite are shown in magenta.
// Source: x / (1 + x) is Reinhard et al., "Photographic Tone Reproduction for Digital Images" (SIGGRAPH 2002),
//         equation 3; the transfer function is IEC 61966-2-1 (sRGB).

struct Params {
    // Size of the images, in pixels.
    size: vec2<f32>,
    // Window pixels per image pixel.
    scale: f32,
    // Part of the width that shows the left image; above 1 for the left image alone.
    split: f32,
    exposure: f32,
    // Non-zero: the values are radiance. Zero: colours in 0 to 1.
    tonemap: u32,
    // Non-zero: the window's format does not encode sRGB itself.
    encode_srgb: u32,
    // Width of the line between the two images, as a part of the width.
    line_width: f32,
}

@group(0) @binding(0) var<uniform> params: Params;
@group(0) @binding(1) var left: texture_2d<f32>;
@group(0) @binding(2) var right: texture_2d<f32>;

struct Vertex {
    @builtin(position) position: vec4<f32>,
    @location(0) uv: vec2<f32>,
}

@vertex
fn vertex(@builtin(vertex_index) index: u32) -> Vertex {
    // One triangle over the whole viewport.
    let uv = vec2(f32((index << 1u) & 2u), f32(index & 2u));
    return Vertex(vec4(uv * vec2(2.0, -2.0) + vec2(-1.0, 1.0), 0.0, 1.0), uv);
}

// Tests the exponent's bits: compilers may assume that floats are never NaN.
fn is_finite(v: vec3<f32>) -> bool {
    return all((bitcast<vec3<u32>>(v) & vec3(0x7f800000u)) != vec3(0x7f800000u));
}

fn srgb_from_linear(x: vec3<f32>) -> vec3<f32> {
    let curve = 1.055 * pow(max(x, vec3(1e-8)), vec3(1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * x, x <= vec3(0.0031308));
}

fn shown(value: vec3<f32>) -> vec3<f32> {
    if !is_finite(value) {
        return vec3(1.0, 0.0, 1.0);
    }
    var x = max(value, vec3(0.0));
    if params.tonemap != 0u {
        x *= params.exposure;
        x = x / (1.0 + x);
    }
    x = min(x, vec3(1.0));
    if params.encode_srgb != 0u {
        return srgb_from_linear(x);
    }
    return x;
}

fn load(on_left: bool, pixel: vec2<i32>) -> vec3<f32> {
    let at = clamp(pixel, vec2(0), vec2<i32>(params.size) - 1);
    if on_left {
        return shown(textureLoad(left, at, 0).rgb);
    }
    return shown(textureLoad(right, at, 0).rgb);
}

@fragment
fn fragment(in: Vertex) -> @location(0) vec4<f32> {
    if params.split <= 1.0 && abs(in.uv.x - params.split) < 0.5 * params.line_width {
        return vec4(1.0);
    }
    let on_left = in.uv.x < params.split;
    let position = in.uv * params.size - 0.5;
    let base = floor(position);
    // Pixels stay sharp squares when enlarged; only their borders, one window pixel wide, are blended.
    let t = clamp((position - base - 0.5) * max(params.scale, 1.0) + 0.5, vec2(0.0), vec2(1.0));
    let corner = vec2<i32>(base);
    let top = mix(load(on_left, corner), load(on_left, corner + vec2(1, 0)), t.x);
    let bottom = mix(load(on_left, corner + vec2(0, 1)), load(on_left, corner + vec2(1, 1)), t.x);
    return vec4(mix(top, bottom, t.y), 1.0);
}
