// plan: how many samples each pixel gets, and which pixels get any.
//
// Reads:  the frame, hits, sample_map (samples that were asked for)
// Writes: sample_count; radiance, black, where nothing will be traced; listed and work: the pixels that are to be traced, and how
//         many workgroups that takes
// Source: dither: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018

//!include scene

@group(2) @binding(0) var hits: texture_2d<f32>;
@group(2) @binding(1) var sample_map: texture_2d<u32>;
@group(2) @binding(2) var radiance_out: texture_storage_2d<rgba32float, write>;
@group(2) @binding(3) var sample_count_out: texture_storage_2d<r32uint, write>;
@group(2) @binding(4) var<storage, read_write> listed: array<u32>;
@group(2) @binding(5) var<storage, read_write> work: array<atomic<u32>>;

const CHECKERBOARD: u32 = 1u;
const MAP: u32 = 2u;

var<workgroup> wanting: atomic<u32>;
var<workgroup> first: u32;

@compute @workgroup_size(8, 8)
fn plan(@builtin(global_invocation_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let pixel = id.xy;
    let is_inside = all(pixel < frame.size);
    var count = 0u;
    if is_inside {
        count = samples_of(pixel);
        textureStore(sample_count_out, pixel, vec4u(count));
        if count == 0u {
            textureStore(radiance_out, pixel, vec4f(0.0, 0.0, 0.0, 1.0));
        }
    }
    // Neighbours stay together in the list: their paths are alike.
    var place = 0u;
    if count > 0u {
        place = atomicAdd(&wanting, 1u);
    }
    workgroupBarrier();
    if lane == 0u {
        reserve(atomicLoad(&wanting));
    }
    workgroupBarrier();
    if count > 0u {
        listed[first + place] = pixel.x | (pixel.y << 16u);
    }
}

fn samples_of(pixel: vec2u) -> u32 {
    // A path that misses ends where it begins, and the sky is not denoised.
    let least = select(0u, 1u, textureLoad(hits, pixel, 0).x < 0.0);
    var wanted = 0u;
    switch frame.sampling {
        case MAP: {
            wanted = textureLoad(sample_map, pixel, 0).x;
        }
        case CHECKERBOARD: {
            let is_turn = ((pixel.x + pixel.y + frame.frame_index) & 1u) == 0u;
            wanted = select(0u, dithered(2.0 * frame.spp, pixel / 2u), is_turn);
        }
        default: {
            wanted = dithered(frame.spp, pixel);
        }
    }
    return max(wanted, least);
}

// A whole number that is `value` in the mean, over neighbours and over frames.
fn dithered(value: f32, pixel: vec2u) -> u32 {
    let place = vec2f(pixel % vec2u(4096u));
    let threshold = dot(place, vec2f(0.7548776662, 0.5698402910)) + f32(frame.frame_index % 4096u) * 0.6180339887;
    return u32(floor(value + fract(threshold)));
}

// Makes room in the list for a workgroup's pixels.
fn reserve(count: u32) {
    first = atomicAdd(&work[WORK_PIXELS], count);
    let groups = (first + count + TRACED_TOGETHER - 1u) / TRACED_TOGETHER;
    atomicMax(&work[1], (groups + WORK_COLUMNS - 1u) / WORK_COLUMNS);
    atomicStore(&work[0], WORK_COLUMNS);
    atomicStore(&work[2], 1u);
}
