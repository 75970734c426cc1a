// What every pass of the tracer reads: the scene in textures, and the frame.
//
// Scene data lies in Rgba32Float textures, `SCENE_WIDTH` (frame data: `FRAME_WIDTH`) texels a row, because CPU
// drivers load texels many times faster than storage buffers. Integers are stored as floats, exact to 2^24.

const SCENE_WIDTH_LOG2: u32 = 12u;
const FRAME_WIDTH_LOG2: u32 = 8u;

// Texels of one record.
const INSTANCE_TEXELS: u32 = 10u;
const MATERIAL_TEXELS: u32 = 13u;
const PUNCTUAL_TEXELS: u32 = 4u;
const TRIANGLE_TEXELS: u32 = 3u;
const CORNER_TEXELS: u32 = 6u;

const PI: f32 = 3.14159265;
const INFINITY_BITS: u32 = 0x7f800000u;
// Far enough to be no hit, and finite, which shader compilers may assume every float to be.
const FAR: f32 = 1e30;

struct Frame {
    size: vec2u,
    // First texels in frame data.
    material_frame_offset: u32,
    punctual_offset: u32,
    light_offset: u32,
    instance_count: u32,
    punctual_count: u32,
    light_count: u32,
    // Samples per pixel, in the mean.
    spp: f32,
    max_bounces: u32,
    // 0 MIS, 1 lights only, 2 BSDF only.
    strategy: u32,
    frame_index: u32,
    seed: u32,
    // 0 uniform, 1 every other pixel in turn, 2 as asked for.
    sampling: u32,
    jitter_px: vec2f,
    pad_0: u32,
    pad_1: u32,
    pad_2: u32,
    // Smallest size of a position that the ray offset assumes.
    offset_floor: f32,
    view_from_world: mat4x4f,
    prev_view_from_world: mat4x4f,
    // x and y scale, x and y offset of the projection (per unit of -z).
    projection: vec4f,
    prev_projection: vec4f,
    // World position; w is the length by which ray origins leave a surface, per unit of the position's size.
    eye: vec4f,
    // Unit vector to the sun; w is 1 - cos(angular radius).
    sun_direction: vec4f,
    // Radiance of the disc; w is 1 / its solid angle, 0 without a sun.
    sun_radiance: vec4f,
    sky_zenith: vec4f,
    sky_horizon: vec4f,
    sky_ground: vec4f,
    // Probability of choosing an emissive triangle, the sun, a punctual light; w is the angle of a pixel.
    light_choice: vec4f,
}

// The work of a frame: arguments of an indirect dispatch, then the number of listed pixels.
const WORK_COLUMNS: u32 = 64u; // workgroups in x
const WORK_PIXELS: u32 = 3u;
const TRACED_TOGETHER: u32 = 64u; // pixels by a workgroup

@group(0) @binding(0) var nodes: texture_2d<f32>;
@group(0) @binding(1) var triangles: texture_2d<f32>;
@group(0) @binding(2) var corners: texture_2d<f32>;
@group(0) @binding(3) var materials: texture_2d<f32>;
@group(0) @binding(4) var color_images: texture_2d_array<f32>;
@group(0) @binding(5) var data_images: texture_2d_array<f32>;
@group(0) @binding(6) var image_sampler: sampler;
@group(0) @binding(7) var frame_data: texture_2d<f32>;
@group(1) @binding(0) var<uniform> frame: Frame;

fn scene_texel(index: u32) -> vec2u {
    return vec2u(index & ((1u << SCENE_WIDTH_LOG2) - 1u), index >> SCENE_WIDTH_LOG2);
}

fn load_frame(index: u32) -> vec4f {
    return textureLoad(frame_data, vec2u(index & ((1u << FRAME_WIDTH_LOG2) - 1u), index >> FRAME_WIDTH_LOG2), 0);
}

// Rows of a 3x4 matrix.
struct Affine {
    x: vec4f,
    y: vec4f,
    z: vec4f,
}

fn load_affine(index: u32) -> Affine {
    return Affine(load_frame(index), load_frame(index + 1u), load_frame(index + 2u));
}

fn transform_point(m: Affine, p: vec3f) -> vec3f {
    let h = vec4f(p, 1.0);
    return vec3f(dot(m.x, h), dot(m.y, h), dot(m.z, h));
}

fn transform_vector(m: Affine, v: vec3f) -> vec3f {
    return vec3f(dot(m.x.xyz, v), dot(m.y.xyz, v), dot(m.z.xyz, v));
}

// Normals go by the transposed inverse.
fn transform_normal(inverse: Affine, n: vec3f) -> vec3f {
    return inverse.x.xyz * n.x + inverse.y.xyz * n.y + inverse.z.xyz * n.z;
}

fn object_from_world(instance: u32) -> Affine {
    return load_affine(instance * INSTANCE_TEXELS);
}

fn world_from_object(instance: u32) -> Affine {
    return load_affine(instance * INSTANCE_TEXELS + 3u);
}

fn prev_world_from_object(instance: u32) -> Affine {
    return load_affine(instance * INSTANCE_TEXELS + 6u);
}

// Vertex 0 and two edges in object space; w: material (-1 - material with an alpha mask), surface, handedness of the tangent.
struct Triangle {
    v0: vec4f,
    e1: vec4f,
    e2: vec4f,
}

fn load_triangle(index: u32) -> Triangle {
    let first = index * TRIANGLE_TEXELS;
    return Triangle(
        textureLoad(triangles, scene_texel(first), 0),
        textureLoad(triangles, scene_texel(first + 1u), 0),
        textureLoad(triangles, scene_texel(first + 2u), 0),
    );
}

fn triangle_material(v0_w: f32) -> u32 {
    return u32(select(v0_w, -1.0 - v0_w, v0_w < 0.0));
}

fn load_corner(triangle: u32, texel: u32) -> vec4f {
    return textureLoad(corners, scene_texel(triangle * CORNER_TEXELS + texel), 0);
}

// Normals (texels 0 to 2, u in w) and tangents (3 to 5, v in w) of the corners.
fn triangle_uvs(triangle: u32) -> mat3x2f {
    return mat3x2f(
        vec2f(load_corner(triangle, 0u).w, load_corner(triangle, 3u).w),
        vec2f(load_corner(triangle, 1u).w, load_corner(triangle, 4u).w),
        vec2f(load_corner(triangle, 2u).w, load_corner(triangle, 5u).w),
    );
}
