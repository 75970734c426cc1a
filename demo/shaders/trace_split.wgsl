// trace_split: as trace, and the same radiance split: what left the first hit through its specular lobe, and the rest.
//
// Reads:  the scene, the frame, hits, sample_count; listed and work (see plan): the pixels that get any
// Writes: radiance, rest, specular (means of the frame's samples), hit_distance
// Source: see path

const SPLIT: bool = true;

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
@group(2) @binding(5) var rest_out: texture_storage_2d<rgba32float, write>;
@group(2) @binding(6) var specular_out: texture_storage_2d<rgba32float, write>;
@group(2) @binding(7) var hit_distance_out: texture_storage_2d<r32float, write>;

@compute @workgroup_size(64)
fn trace_split(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let place = (group.y * WORK_COLUMNS + group.x) * TRACED_TOGETHER + lane;
    if place >= work[WORK_PIXELS] {
        return;
    }
    let start = start_at(place);
    var sum = Path(vec3f(0.0), vec3f(0.0), vec3f(0.0), 0.0);
    var inverse_distances = 0.0;
    var known = 0.0;
    for (var i = 0u; i < start.count; i++) {
        let path = trace_path(start.hit, start.direction);
        sum.radiance += path.radiance;
        sum.rest += path.rest;
        sum.specular += path.specular;
        if path.hit_distance > 0.0 {
            inverse_distances += 1.0 / path.hit_distance;
            known += 1.0;
        }
    }
    textureStore(radiance_out, start.pixel, vec4f(sum.radiance / f32(start.count), 1.0));
    textureStore(rest_out, start.pixel, vec4f(sum.rest / f32(start.count), 1.0));
    textureStore(specular_out, start.pixel, vec4f(sum.specular / f32(start.count), 1.0));
    // The mean of inverses, which the parallax of reflections goes by: the sky counts as far, and does not outweigh all else.
    textureStore(hit_distance_out, start.pixel, vec4f(known / max(inverse_distances, 1e-30)));
}
