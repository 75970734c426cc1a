// What every pass knows about the frame. Rust mirror: `FrameUniforms` (layout compared by a test).

// A camera whose world axes are kept but whose origin is the eye: positions stay small, so f32 holds in large worlds.
struct View {
    view_from_world: mat4x4<f32>, // rotation only
    scale: vec2<f32>,             // clip_from_view [0][0], [1][1]
    shift: vec2<f32>,             // clip_from_view column z, x and y: an off-centre frustum
    offset: vec2<f32>,            // clip_from_view column w, x and y: an off-centre orthographic view
    jitter: vec2<f32>,            // pixels; where samples lie relative to pixel centres
    perspective: f32,             // 1 perspective, 0 orthographic
    pad_0: f32,
    size: vec2<f32>,              // pixels of the view's frame
}

// What hardly changes comes first: Mesa's CPU driver compiles a shader anew when the first words of its uniforms change.
struct Frame {
    size: vec2<u32>,        // pixels
    tiles: vec2<u32>,       // of TILE x TILE pixels
    motion_scale: vec2<f32>,// from the caller's motion to UV, towards the previous frame
    max_history: f32,
    flags: u32,
    index: u32,             // frames since creation, for dithering and alternation
    debug_view: u32,
    least_window: u32,      // the smallest and the largest window that a model may choose, in order of size from 1
    widest_window: u32,
    firefly_limit: f32,     // standard errors of a neighbourhood's mean that one sample may move it by
    far: f32,
    sample_budget: f32,     // mean samples per pixel that the sample map may ask for
    dark_level: f32,        // luminance below which errors count absolutely
    origin: vec2<u32>,      // where the frame begins in the caller's images, pixels
    motion_offset: vec2<f32>, // UV; takes jitter out of the caller's motion
    unprojection: vec4<f32>,// view depth = (x + y d) / (z + w d) of a depth buffer's d
    levels: array<Level, LEVELS>,
    eye_delta: vec3<f32>,   // eye now minus eye of the previous frame, world units
    model_limit: u32,       // models that may be fitted, where FLAG_LIMITED is set; changes while a time is kept
    current: View,
    previous: View,
}

// A level of the placement of centres, coarse to fine.
struct Level {
    stride: u32,  // tiles between its centres; 0 leaves the level out
    covered: u32, // coverage at which a tile needs no further model
    pad_0: u32,
    pad_1: u32,
}

const FLAG_HISTORY = 1u;        // the previous frame's images are valid
const FLAG_SURFACE_ID = 2u;     // the optional inputs that came
const FLAG_EMISSION = 4u;
const FLAG_SAMPLE_COUNT = 8u;
const FLAG_MOTION_DEPTH = 16u;  // motion.z holds the change of depth
const FLAG_MIX = 32u;           // mix the prediction with the temporal mean
const FLAG_RING_ERROR = 64u;    // windows by the ring error, not by Mallows' Cp
const FLAG_INNOVATION = 128u;   // relight the history
const FLAG_DEBUG = 256u;        // a debug view shows inner images
const FLAG_ERROR = 512u;        // somebody asks for the output's expected error
const FLAG_LIMITED = 1024u;     // no more than model_limit models are fitted
const FLAG_SPLIT = 2048u;       // the radiance that left through the specular lobe is a signal of its own
const FLAG_SPECULAR_ALBEDO = 4096u;
const FLAG_HIT_DISTANCE = 8192u;
const FLAG_ROUGHNESS = 16384u;
const FLAG_DEPTH_HARDWARE = 32768u;     // the caller's conventions
const FLAG_DEPTH_REVERSED = 65536u;
const FLAG_DEPTH_DISTANCE = 131072u;
const FLAG_MOTION_FROM_PREVIOUS = 262144u;
const FLAG_NORMAL_UNSIGNED = 524288u;
const FLAG_NORMAL_OCTAHEDRAL = 1048576u;
const FLAG_NORMAL_VIEW = 2097152u;
const FLAG_NORMAL_MIRRORED = 4194304u;  // along z
const FLAG_NORMAL_ALONE = 8388608u;     // without roughness in w
const FLAG_BILINEAR = 16777216u;        // what saves time: history is resampled bilinearly everywhere,
const FLAG_SPARSE = 33554432u;          // and only some tiles have moments (include/tile_moments)

// Whether the pass works on the radiance that left the first hit through the specular lobe. Compiled apart, so that it costs
// nothing where there is one signal.
override IS_SPECULAR = false;
// Whether the caller's depth and normals are written down otherwise than quell's. Compiled apart as well.
override DECODES = false;
// Whether the signal is one, and hit distances tell what is seen in surfaces. Compiled apart as well.
override HAS_REFLECTIONS = false;

const LEVELS = 3u;
const TILE = 8u; // pixels on a side; the unit of which windows are made

fn has(frame: Frame, flag: u32) -> bool {
    return (frame.flags & flag) != 0u;
}

fn inside(pixel: vec2<i32>, view: View) -> bool {
    return all(pixel >= vec2(0)) && all(pixel < vec2<i32>(view.size));
}

// Eye-relative world position of the point at `uv` (origin top left) and linear view depth.
fn position_at(view: View, uv: vec2<f32>, depth: f32) -> vec3<f32> {
    let ndc = vec2(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y);
    let w = mix(1.0, depth, view.perspective);
    let xy = (ndc * w + view.shift * depth - view.offset) / view.scale;
    return (vec4(xy, -depth, 0.0) * view.view_from_world).xyz;
}

// The point seen by the sample of a pixel (centres at integers).
fn position_of(view: View, pixel: vec2<f32>, depth: f32) -> vec3<f32> {
    return position_at(view, (pixel + 0.5 + view.jitter) / view.size, depth);
}

// How far along a normal the points are that a view's pixels see: dot(normal, position_of(view, pixel, depth)), for many pixels
// without their positions. It is linear in the depth and, at one depth, in the pixel.
struct Elevation {
    slope: vec2<f32>, // per pixel
    first: f32,       // of pixel 0, 0
    along: f32,       // per depth
    rest: f32,
    perspective: f32,
}

fn elevation_along(view: View, normal: vec3<f32>) -> Elevation {
    let n = (view.view_from_world * vec4(normal, 0.0)).xyz;
    let across = n.xy / view.scale;
    let step = vec2(2.0, -2.0) / view.size;
    let first = vec2(-1.0, 1.0) + step * (0.5 + view.jitter);
    let along = dot(across, view.shift) - n.z;
    return Elevation(across * step, dot(across, first), along, -dot(across, view.offset), view.perspective);
}

fn elevation_of(e: Elevation, pixel: vec2<f32>, depth: f32) -> f32 {
    return (dot(e.slope, pixel) + e.first) * mix(1.0, depth, e.perspective) + e.along * depth + e.rest;
}

// UV of an eye-relative world position, and its view depth in z.
fn project(view: View, position: vec3<f32>) -> vec3<f32> {
    let p = (view.view_from_world * vec4(position, 0.0)).xyz;
    let w = mix(1.0, -p.z, view.perspective);
    let ndc = (view.scale * p.xy + view.shift * p.z + view.offset) / w;
    return vec3(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y, -p.z);
}

// Unit vector from an eye-relative position towards the eye.
fn towards_eye(view: View, position: vec3<f32>) -> vec3<f32> {
    let parallel = (vec4(0.0, 0.0, 1.0, 0.0) * view.view_from_world).xyz;
    return select(parallel, -position / max(length(position), 1e-20), view.perspective > 0.0);
}

// Length of the view ray to an eye-relative position.
fn ray_length(view: View, position: vec3<f32>) -> f32 {
    let parallel = -(view.view_from_world * vec4(position, 0.0)).z;
    return select(parallel, length(position), view.perspective > 0.0);
}

const LUMINANCE = vec3(0.2126, 0.7152, 0.0722); // ITU-R BT.709

fn luminance(colour: vec3<f32>) -> f32 {
    return dot(colour, LUMINANCE);
}
