// Reads the caller's images and repairs them, once, at the border.
//
// A pass binds radiance, albedo, normal_roughness, roughness, depth, surface_id, emission and sample_count.
// Source: radiance = albedo E + emission at the first hit

const LARGEST_DEPTH = 1e12; // beyond it, sums of squared positions leave f32

fn read_surface(pixel: vec2<u32>) -> Surface {
    let texel = frame.origin + pixel;
    let shading = textureLoad(normal_roughness, texel, 0);
    var s: Surface;
    s.depth = view_depth_at(pixel);
    s.normal = decode_normal(shading.xyz);
    var rough = select(shading.w, 1.0, has(frame, FLAG_NORMAL_ALONE));
    if has(frame, FLAG_ROUGHNESS) {
        rough = textureLoad(roughness, texel, 0).x;
    }
    s.roughness = select(1.0, saturate(rough), is_finite(rough));
    if has(frame, FLAG_SURFACE_ID) {
        s.id = pcg(textureLoad(surface_id, texel, 0).x) % IDS;
    }
    if !has(frame, FLAG_SPLIT) {
        s.cue = 0.1 / luminance(demodulator(textureLoad(albedo, texel, 0).rgb));
    }
    return s;
}

// Linear view depth of what the caller gives, 0 at a miss.
fn view_depth_at(pixel: vec2<u32>) -> f32 {
    let stored = textureLoad(depth, frame.origin + pixel, 0).x;
    var found = stored;
    if DECODES {
        found = decode_depth(pixel, stored);
    }
    return select(0.0, found, is_finite(found) && found > 0.0 && found < min(frame.far, LARGEST_DEPTH));
}

fn decode_depth(pixel: vec2<u32>, stored: f32) -> f32 {
    if has(frame, FLAG_DEPTH_HARDWARE) {
        // What was cleared lies at the far end.
        let is_hit = select(1.0 - stored, stored, has(frame, FLAG_DEPTH_REVERSED)) > 0.0;
        let c = frame.unprojection;
        return select(0.0, (c.x + c.y * stored) / (c.z + c.w * stored), is_hit);
    }
    if has(frame, FLAG_DEPTH_DISTANCE) {
        return stored / ray_length(frame.current, position_of(frame.current, vec2<f32>(pixel), 1.0));
    }
    return stored;
}

// World-space unit normal of what the caller gives.
fn decode_normal(stored: vec3<f32>) -> vec3<f32> {
    if !DECODES {
        return repair_normal(stored);
    }
    var n = select(stored, 2.0 * stored - 1.0, has(frame, FLAG_NORMAL_UNSIGNED));
    if has(frame, FLAG_NORMAL_OCTAHEDRAL) {
        n = octahedral_decode(n.xy);
    }
    n = repair_normal(n);
    if has(frame, FLAG_NORMAL_VIEW) {
        n.z = select(n.z, -n.z, has(frame, FLAG_NORMAL_MIRRORED));
        n = (vec4(n, 0.0) * frame.current.view_from_world).xyz;
    }
    return n;
}

fn repair_normal(n: vec3<f32>) -> vec3<f32> {
    let length_squared = dot(n, n);
    if !is_finite(length_squared) || length_squared < 1e-8 {
        return vec3(0.0, 0.0, 1.0);
    }
    return n * inverseSqrt(length_squared);
}

// A pixel's sample of this frame.
struct Sample {
    signal: vec3<f32>, // demodulated radiance without emission
    count: f32,        // 0: none that can be used
}

fn read_sample(pixel: vec2<u32>, surface: Surface) -> Sample {
    let traced = textureLoad(radiance, frame.origin + pixel, 0).rgb;
    let count = samples_at(pixel);
    if is_miss(surface) || !all_finite(traced) || count == 0.0 {
        return Sample(vec3(0.0), 0.0);
    }
    var seen = max(traced, vec3(0.0));
    if has(frame, FLAG_EMISSION) && !IS_SPECULAR {
        seen = max(seen - repair_emission(textureLoad(emission, frame.origin + pixel, 0).rgb), vec3(0.0));
    }
    return Sample(seen / demodulator_at(pixel, surface), count);
}

// What a miss shows; the specular signal is black there.
fn read_miss(pixel: vec2<u32>) -> vec3<f32> {
    if IS_SPECULAR {
        return vec3(0.0);
    }
    let seen = textureLoad(radiance, frame.origin + pixel, 0).rgb;
    return clamp(select(vec3(0.0), seen, all_finite(seen)), vec3(0.0), vec3(HALF_MAX));
}
