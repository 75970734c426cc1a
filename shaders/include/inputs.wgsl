// Reads the caller's images and repairs them, once, at the border.
//
// A pass binds radiance, albedo, normal_roughness, depth, surface_id, emission and sample_count.
// Source: radiance = albedo E + emission at the first hit

const LARGEST_DEPTH = 1e12; // beyond it, sums of squared positions leave f32

fn read_surface(pixel: vec2<u32>) -> Surface {
    let d = textureLoad(depth, pixel, 0).x;
    let hit = is_finite(d) && d > 0.0 && d < min(frame.far, LARGEST_DEPTH);
    let shading = textureLoad(normal_roughness, pixel, 0);
    var s: Surface;
    s.depth = select(0.0, d, hit);
    s.normal = repair_normal(shading.xyz);
    s.roughness = select(1.0, saturate(shading.w), is_finite(shading.w));
    if has(frame, FLAG_SURFACE_ID) {
        s.id = pcg(textureLoad(surface_id, pixel, 0).x) % IDS;
    }
    if !has(frame, FLAG_SPLIT) {
        s.cue = 0.1 / luminance(demodulator(textureLoad(albedo, pixel, 0).rgb));
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

// A pixel's sample of this frame.
struct Sample {
    signal: vec3<f32>, // demodulated radiance without emission
    count: f32,        // 0: none that can be used
}

fn read_sample(pixel: vec2<u32>, surface: Surface) -> Sample {
    let traced = textureLoad(radiance, pixel, 0).rgb;
    let count = samples_at(pixel);
    if is_miss(surface) || !all_finite(traced) || count == 0.0 {
        return Sample(vec3(0.0), 0.0);
    }
    var seen = max(traced, vec3(0.0));
    if has(frame, FLAG_EMISSION) && !IS_SPECULAR {
        seen = max(seen - repair_emission(textureLoad(emission, pixel, 0).rgb), vec3(0.0));
    }
    return Sample(seen / demodulator_at(pixel, surface), count);
}

// What a miss shows; the specular signal is black there.
fn read_miss(pixel: vec2<u32>) -> vec3<f32> {
    if IS_SPECULAR {
        return vec3(0.0);
    }
    let seen = textureLoad(radiance, pixel, 0).rgb;
    return clamp(select(vec3(0.0), seen, all_finite(seen)), vec3(0.0), vec3(HALF_MAX));
}
