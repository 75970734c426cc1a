// prepare: repairs the inputs once, at the border, and packs them for all later passes.
//
// Reads   the caller's images.
// Writes  signal: demodulated radiance without emission, samples in w (0: no usable sample at this pixel)
//         guide: the surface, packed
// Source  design of the signal: radiance = albedo E + emission at the first hit

//!include frame numbers surface demodulate

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var albedo: texture_2d<f32>;
@group(0) @binding(3) var normal_roughness: texture_2d<f32>;
@group(0) @binding(4) var depth: texture_2d<f32>;
@group(0) @binding(5) var surface_id: texture_2d<u32>;
@group(0) @binding(6) var emission: texture_2d<f32>;
@group(0) @binding(7) var sample_count: texture_2d<u32>;
@group(0) @binding(8) var signal: texture_storage_2d<rgba16float, write>;
@group(0) @binding(9) var guide: texture_storage_2d<rgba32uint, write>;

const LARGEST_DEPTH = 1e12; // beyond it, sums of squared positions leave f32

@compute @workgroup_size(8, 8)
fn prepare(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let surface = read_surface(id.xy);
    textureStore(guide, id.xy, pack_surface(surface));
    textureStore(signal, id.xy, read_signal(id.xy, surface));
}

fn read_surface(pixel: vec2<u32>) -> Surface {
    let d = textureLoad(depth, pixel, 0).x;
    let hit = is_finite(d) && d > 0.0 && d < min(frame.far, LARGEST_DEPTH);
    let shading = textureLoad(normal_roughness, pixel, 0);
    let reflectance = demodulator(textureLoad(albedo, pixel, 0).rgb);
    var s: Surface;
    s.depth = select(0.0, d, hit);
    s.normal = repair_normal(shading.xyz);
    s.inverse_albedo = 0.1 / luminance(reflectance);
    s.roughness = select(1.0, saturate(shading.w), is_finite(shading.w));
    if has(frame, FLAG_SURFACE_ID) {
        s.id = textureLoad(surface_id, pixel, 0).x;
    }
    return s;
}

fn repair_normal(n: vec3<f32>) -> vec3<f32> {
    let length_squared = dot(n, n);
    if !is_finite(length_squared) || length_squared < 1e-8 {
        return vec3(0.0, 0.0, 1.0);
    }
    return n * inverseSqrt(length_squared);
}

fn read_signal(pixel: vec2<u32>, surface: Surface) -> vec4<f32> {
    let traced = textureLoad(radiance, pixel, 0).rgb;
    var samples = 1.0;
    if has(frame, FLAG_SAMPLE_COUNT) {
        samples = f32(textureLoad(sample_count, pixel, 0).x);
    }
    if is_miss(surface) || !all_finite(traced) || samples == 0.0 {
        return vec4(0.0);
    }
    var seen = max(traced, vec3(0.0));
    if has(frame, FLAG_EMISSION) {
        seen = max(seen - repair_emission(textureLoad(emission, pixel, 0).rgb), vec3(0.0));
    }
    return vec4(min(seen / demodulator(textureLoad(albedo, pixel, 0).rgb), vec3(HALF_MAX)), min(samples, 1024.0));
}
