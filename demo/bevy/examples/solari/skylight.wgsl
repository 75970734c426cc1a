// The light of the sky on what the camera sees, shadowed by what else it sees: rays march through the depth buffer. One to many
// samples a pixel, so noisy; what is hidden casts no shadow, so wrong, but the same for all numbers of samples.

struct Frame {
    clip_from_world: mat4x4f,
    world_from_clip: mat4x4f,
    size: vec2u,
    samples: u32,
    seed: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var gbuffer: texture_2d<u32>;
@group(0) @binding(2) var depth_buffer: texture_depth_2d;
@group(0) @binding(3) var light: texture_storage_2d<rgba16float, write>;

const STEPS = 24u;
const REACH = 2.5;
// How thick things are taken to be, in metres.
const THICKNESS = 0.5;
const OFFSET = 0.01;

@compute @workgroup_size(8, 8)
fn skylight(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    let depth = textureLoad(depth_buffer, id.xy, 0);
    var sum = vec3f(0);
    if depth > 0 {
        let position = world_at((vec2f(id.xy) + 0.5) / vec2f(frame.size), depth);
        let normal = normal_of(textureLoad(gbuffer, id.xy, 0).a);
        var rng = hash(id.x + frame.size.x * (id.y + frame.size.y * frame.seed));
        for (var i = 0u; i < frame.samples; i++) {
            let direction = cosine_direction(normal, vec2f(random(&rng), random(&rng)));
            sum += sky(direction) * f32(is_open(position + OFFSET * normal, direction, random(&rng)));
        }
    }
    textureStore(light, id.xy, vec4f(sum / f32(frame.samples), 1));
}

fn sky(direction: vec3f) -> vec3f {
    let blue = mix(vec3f(0.25, 0.2, 0.15), vec3f(0.5, 0.75, 1.1), smoothstep(-0.2, 0.6, direction.y));
    let sun = smoothstep(0.9, 0.97, dot(direction, normalize(vec3f(-0.5, 1, 0.75))));
    return blue + 6 * sun * vec3f(1, 0.85, 0.6);
}

fn is_open(origin: vec3f, direction: vec3f, jitter: f32) -> bool {
    for (var i = 0u; i < STEPS; i++) {
        // Short steps near the surface, where contact shadows are.
        let t = (f32(i) + jitter) / f32(STEPS);
        let point = origin + REACH * t * t * direction;
        let clip = frame.clip_from_world * vec4f(point, 1);
        let uv = clip.xy / clip.w * vec2f(0.5, -0.5) + 0.5;
        if clip.w <= 0 || any(uv < vec2f(0)) || any(uv >= vec2f(1)) {
            return true;
        }
        let stored = textureLoad(depth_buffer, vec2u(uv * vec2f(frame.size)), 0);
        // For a perspective with infinite far plane, w is view depth.
        let seen = frame.clip_from_world * vec4f(world_at(uv, stored), 1);
        let behind = clip.w - seen.w;
        if stored > 0 && behind > 0.02 * t && behind < THICKNESS {
            return false;
        }
    }
    return true;
}

fn world_at(uv: vec2f, depth: f32) -> vec3f {
    let world = frame.world_from_clip * vec4f(uv * vec2f(2, -2) + vec2f(-1, 1), depth, 1);
    return world.xyz / world.w;
}

fn normal_of(word: u32) -> vec3f {
    let e = vec2f(vec2u(word, word >> 12) & vec2u(0xfff)) / 4095 * 2 - 1;
    let z = 1 - abs(e.x) - abs(e.y);
    let fold = max(-z, 0.0);
    return normalize(vec3f(e - select(vec2f(-fold), vec2f(fold), e >= vec2f(0)), z));
}

fn cosine_direction(normal: vec3f, u: vec2f) -> vec3f {
    let z = 1 - 2 * u.x;
    let phi = 6.2831853 * u.y;
    let ball = vec3f(sqrt(max(1 - z * z, 0.0)) * vec2f(cos(phi), sin(phi)), z);
    return normalize(normal * 1.0001 + ball);
}

// PCG (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020).
fn hash(value: u32) -> u32 {
    let state = value * 747796405 + 2891336453;
    let word = ((state >> ((state >> 28) + 4)) ^ state) * 277803737;
    return (word >> 22) ^ word;
}

fn random(rng: ptr<function, u32>) -> f32 {
    *rng = hash(*rng);
    return f32(*rng >> 8) / 16777216;
}
