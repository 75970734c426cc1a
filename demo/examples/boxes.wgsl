// Boxes under a lamp and the sky: their G-buffer, one noisy ray-traced effect (the lamp's soft shadow and what comes from the
// sky), and tonemapping.

struct Box { centre: vec3f, extent: vec3f, albedo: vec3f }

const BOXES = 6u;
/// The first is the floor; the last goes up and down.
const SCENE = array(
    Box(vec3f(0.0, -0.1, 0.0), vec3f(4.0, 0.1, 4.0), vec3f(0.7, 0.66, 0.6)),
    Box(vec3f(-1.3, 0.8, -0.6), vec3f(0.5, 0.8, 0.5), vec3f(0.65, 0.09, 0.05)),
    Box(vec3f(0.1, 0.45, 0.5), vec3f(0.45, 0.45, 0.45), vec3f(0.85, 0.5, 0.06)),
    Box(vec3f(1.5, 0.6, -0.9), vec3f(0.35, 0.6, 0.8), vec3f(0.06, 0.42, 0.36)),
    Box(vec3f(-0.2, 0.25, -1.9), vec3f(1.2, 0.25, 0.3), vec3f(0.12, 0.18, 0.6)),
    Box(vec3f(0.1, 1.5, 0.5), vec3f(0.2, 0.2, 0.2), vec3f(0.85, 0.85, 0.85)),
);

/// The centre of a box, at a time in frames.
fn centre(i: u32, time: f32) -> vec3f {
    let lift = select(0.0, 0.25 * sin(0.15 * time), i == BOXES - 1u);
    return SCENE[i].centre + vec3f(0.0, lift, 0.0);
}

struct Frame {
    view_from_world: mat4x4f,
    clip_from_world: mat4x4f,
    prev_clip_from_world: mat4x4f,
    world_from_clip: mat4x4f,
    eye: vec3f,
    seed: u32,
    size: vec2u,
    time: f32,
    samples: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;

// Raster: the G-buffer ---------------------------------------------------------------------------------------------------------

struct Corner {
    @builtin(position) clip: vec4f,
    @location(0) world: vec3f,
    @location(1) @interpolate(flat) normal: vec3f,
    @location(2) @interpolate(flat) instance: u32,
}

@vertex
fn cube(@builtin(vertex_index) vertex: u32, @builtin(instance_index) instance: u32) -> Corner {
    let side = vertex / 6u;
    let axis = side % 3u;
    let corner = array(0u, 1u, 2u, 2u, 1u, 3u)[vertex % 6u];
    var normal = vec3f(0.0);
    normal[axis] = f32(side / 3u) * 2.0 - 1.0;
    var point = normal;
    point[(axis + 1u) % 3u] = f32(corner % 2u) * 2.0 - 1.0;
    point[(axis + 2u) % 3u] = f32(corner / 2u) * 2.0 - 1.0;
    let world = centre(instance, frame.time) + SCENE[instance].extent * point;
    return Corner(frame.clip_from_world * vec4f(world, 1.0), world, normal, instance);
}

struct Surface {
    @location(0) albedo: vec4f,
    @location(1) normal_roughness: vec4f,
    @location(2) depth: f32,
    @location(3) motion: vec2f,
}

const ROUGHNESS = 1.0;

@fragment
fn gbuffer(corner: Corner) -> Surface {
    // Slabs on the floor, to see that texture stays sharp.
    let slab = select(1.0, 0.7, corner.instance == 0u && (i32(floor(corner.world.x) + floor(corner.world.z)) & 1) == 0);
    let depth = -(frame.view_from_world * vec4f(corner.world, 1.0)).z;
    let albedo = vec4f(SCENE[corner.instance].albedo * slab, 1.0);
    return Surface(albedo, vec4f(corner.normal, ROUGHNESS), depth, motion_uv(corner));
}

/// Where this point of the surface was in the previous frame, minus where it is.
fn motion_uv(corner: Corner) -> vec2f {
    let moved = centre(corner.instance, frame.time) - centre(corner.instance, max(frame.time - 1.0, 0.0));
    return uv_from_clip(frame.prev_clip_from_world * vec4f(corner.world - moved, 1.0))
        - uv_from_clip(frame.clip_from_world * vec4f(corner.world, 1.0));
}

fn uv_from_clip(clip: vec4f) -> vec2f {
    return 0.5 + vec2f(0.5, -0.5) * clip.xy / clip.w;
}

// Compute: the noisy effect ----------------------------------------------------------------------------------------------------

@group(0) @binding(1) var albedo_image: texture_2d<f32>;
@group(0) @binding(2) var normal_image: texture_2d<f32>;
@group(0) @binding(3) var depth_image: texture_2d<f32>;
@group(0) @binding(4) var radiance_image: texture_storage_2d<rgba16float, write>;

const LAMP = vec3f(-2.6, 4.4, 2.0);
const LAMP_RADIUS = 0.9;
const LAMP_POWER = vec3f(50.0, 42.0, 32.0);
const MISS = 1e12;

@compute @workgroup_size(8, 8)
fn trace(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if any(pixel >= frame.size) {
        return;
    }
    state = (frame.seed * frame.size.y + pixel.y) * frame.size.x + pixel.x;
    let uv = (vec2f(pixel) + 0.5) / vec2f(frame.size);
    let far = frame.world_from_clip * vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 1.0, 1.0);
    let ray = far.xyz / far.w - frame.eye;
    let depth = textureLoad(depth_image, pixel, 0).x;
    var radiance = sky(normalize(ray));
    if depth > 0.0 {
        let per_depth = -ray / (frame.view_from_world * vec4f(ray, 0.0)).z;
        let normal = textureLoad(normal_image, pixel, 0).xyz;
        let position = frame.eye + per_depth * depth + 1e-3 * normal;
        var light = vec3f(0.0);
        for (var i = 0u; i < frame.samples; i++) {
            light += lamp_light(position, normal) + sky_light(position, normal);
        }
        radiance = textureLoad(albedo_image, pixel, 0).rgb * light / f32(frame.samples);
    }
    textureStore(radiance_image, pixel, vec4f(radiance, 1.0));
}

/// One ray to a random point of the lamp.
fn lamp_light(position: vec3f, normal: vec3f) -> vec3f {
    let to_lamp = LAMP + LAMP_RADIUS * random_direction() - position;
    let distance = length(to_lamp);
    let facing = dot(normal, to_lamp) / distance;
    if facing <= 0.0 || first_hit(position, to_lamp / distance).distance < distance {
        return vec3f(0.0);
    }
    return LAMP_POWER * facing / (distance * distance);
}

/// One ray towards the sky; of boxes that it meets instead, a guess.
fn sky_light(position: vec3f, normal: vec3f) -> vec3f {
    let direction = normalize(normal + random_direction());
    let hit = first_hit(position, direction);
    if hit.distance < MISS {
        return 0.3 * SCENE[hit.instance].albedo;
    }
    return sky(direction);
}

fn sky(direction: vec3f) -> vec3f {
    return mix(vec3f(0.95, 0.82, 0.66), vec3f(0.1, 0.28, 0.75), smoothstep(-0.15, 0.25, direction.y));
}

struct Hit { distance: f32, instance: u32 }

fn first_hit(origin: vec3f, direction: vec3f) -> Hit {
    var hit = Hit(MISS, 0u);
    for (var i = 0u; i < BOXES; i++) {
        let middle = (centre(i, frame.time) - origin) / direction;
        let reach = SCENE[i].extent / abs(direction);
        let enters = middle - reach;
        let leaves = middle + reach;
        let enter = max(max(enters.x, enters.y), enters.z);
        let leave = min(min(leaves.x, leaves.y), leaves.z);
        if enter > 0.0 && enter <= leave && enter < hit.distance {
            hit = Hit(enter, i);
        }
    }
    return hit;
}

var<private> state: u32;

/// Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020: pcg.
fn random() -> f32 {
    state = state * 747796405u + 2891336453u;
    let word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return f32(((word >> 22u) ^ word) >> 8u) / 16777216.0;
}

fn random_direction() -> vec3f {
    let z = 2.0 * random() - 1.0;
    let angle = 6.2831853 * random();
    return vec3f(sqrt(1.0 - z * z) * vec2f(cos(angle), sin(angle)), z);
}

// Compute: the picture ---------------------------------------------------------------------------------------------------------

@group(0) @binding(1) var shown: texture_2d<f32>;
@group(0) @binding(2) var<storage, read_write> picture: array<u32>;

@compute @workgroup_size(8, 8)
fn tonemap(@builtin(global_invocation_id) id: vec3u) {
    if any(id.xy >= frame.size) {
        return;
    }
    let radiance = textureLoad(shown, id.xy, 0).rgb;
    picture[id.y * frame.size.x + id.x] = pack4x8unorm(vec4f(srgb(radiance / (1.0 + radiance)), 1.0));
}

fn srgb(linear: vec3f) -> vec3f {
    return select(1.055 * pow(linear, vec3f(1.0 / 2.4)) - 0.055, 12.92 * linear, linear <= vec3f(0.0031308));
}
