// trace: radiance that arrives at each pixel, by path tracing.
//
// Reads:  the scene, the frame, hits, sample_count; listed and work (see plan): the pixels that get any
// Writes: radiance (mean of the frame's samples)
// Source: see path

const SPLIT: bool = false;

//!include scene
//!include images
//!include random
//!include intersect
//!include camera
//!include surface
//!include bsdf
//!include lights
//!include primary
//!include path

@group(2) @binding(1) var radiance_out: texture_storage_2d<rgba32float, write>;
@group(2) @binding(2) var sample_count: texture_2d<u32>;
@group(2) @binding(3) var<storage, read> listed: array<u32>;
@group(2) @binding(4) var<storage, read> work: array<u32>;

@compute @workgroup_size(64)
fn trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let place = (group.y * WORK_COLUMNS + group.x) * TRACED_TOGETHER + lane;
    if place >= work[WORK_PIXELS] {
        return;
    }
    let start = start_at(place);
    var sum = vec3f(0.0);
    for (var i = 0u; i < start.count; i++) {
        sum += trace_path(start.hit, start.direction).radiance;
    }
    textureStore(radiance_out, start.pixel, vec4f(sum / f32(start.count), 1.0));
}
