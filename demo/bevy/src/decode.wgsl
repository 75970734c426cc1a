// Bevy's deferred G-buffer as quell reads it. One texel of the G-buffer is four words (`bevy_pbr`'s `deferred/functions.wesl`, not
// WebGL's): base colour of gamma 2.2 and perceptual roughness as unorm8, emission as RGB9E5, properties that are not needed here, and
// the world normal, octahedral in 12 bits each, with flags above.

struct Frame {
    // z and w rows of the projection, columns z and w: clip.z = x * z + y, clip.w = z * z + w.
    depth_rows: vec4f,
    origin: vec2u,
    size: vec2u,
    // What emission is multiplied by; 0 where the radiance has none.
    emission_scale: f32,
    // Whether the radiance was multiplied by the base colour.
    has_albedo: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var gbuffer: texture_2d<u32>;
@group(0) @binding(2) var depth_buffer: texture_depth_2d;
@group(0) @binding(3) var albedo: texture_storage_2d<rgba8unorm, write>;
@group(0) @binding(4) var normal_roughness: texture_storage_2d<rgba16float, write>;
@group(0) @binding(5) var depth: texture_storage_2d<r32float, write>;
@group(0) @binding(6) var emission: texture_storage_2d<rgba16float, write>;

const MISS = 0.0;

@compute @workgroup_size(8, 8)
fn decode(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = frame.origin + id.xy;
    let texel = textureLoad(gbuffer, pixel, 0);
    let base_roughness = unpack4x8unorm(texel.r);
    let base = select(vec3f(1), pow(base_roughness.rgb, vec3f(2.2)), frame.has_albedo != 0);
    textureStore(albedo, pixel, vec4f(base, 1));
    textureStore(normal_roughness, pixel, vec4f(normal_of(texel.a), base_roughness.a));
    textureStore(emission, pixel, vec4f(frame.emission_scale * unpack_rgb9e5(texel.g), 1));
    // What was drawn forward left depth but no G-buffer: it has no noise, and passes through as a miss does. Bevy clears to 0, 0, 0, 1.
    let is_deferred = any(texel.rgb != vec3u(0));
    textureStore(depth, pixel, vec4f(select(MISS, view_depth(textureLoad(depth_buffer, pixel, 0)), is_deferred)));
}

// Distance from the eye's plane. Nothing was drawn where reverse-Z is 0.
fn view_depth(stored: f32) -> f32 {
    let rows = frame.depth_rows;
    let z = (stored * rows.w - rows.y) / (rows.x - stored * rows.z);
    return select(-z, MISS, stored == 0);
}

// Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors", JCGT 2014.
fn normal_of(word: u32) -> vec3f {
    let e = vec2f(vec2u(word, word >> 12) & vec2u(0xfff)) / 4095 * 2 - 1;
    let z = 1 - abs(e.x) - abs(e.y);
    let fold = max(-z, 0.0);
    return normalize(vec3f(e - select(vec2f(-fold), vec2f(fold), e >= vec2f(0)), z));
}

// Nine bits each, with one exponent of bias 15 (EXT_texture_shared_exponent).
fn unpack_rgb9e5(word: u32) -> vec3f {
    let mantissas = vec3f(vec3u(word, word >> 9, word >> 18) & vec3u(0x1ff));
    return mantissas * exp2(f32(word >> 27) - 24);
}
