// sample_gains: counts what further samples are worth. `sample_map` then shares them out.
//
// Reads   guide, history, error; the caller's motion.
// Writes  sample_histogram: of gains (include/sampling)
// Source  Moon et al. 2015, section 4.4

//!include frame numbers surface motion error sampling sample_gain

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var guide: texture_2d<u32>;
@group(0) @binding(2) var motion: texture_2d<f32>;
@group(0) @binding(3) var history: texture_2d<f32>;
@group(0) @binding(4) var error: texture_2d<u32>;
@group(0) @binding(5) var<storage, read_write> sample_histogram: array<atomic<u32>>;

// Of the workgroup's pixels first: neighbours share buckets.
var<workgroup> counts: array<atomic<u32>, SAMPLE_BUCKETS>;

@compute @workgroup_size(8, 8)
fn sample_gains(@builtin(global_invocation_id) id: vec3<u32>, @builtin(local_invocation_index) lane: u32) {
    for (var bucket = lane; bucket < SAMPLE_BUCKETS; bucket += 64u) {
        atomicStore(&counts[bucket], 0u);
    }
    workgroupBarrier();
    if all(id.xy < frame.size) {
        let bucket = gain_bucket(id.xy);
        if bucket != NO_GAIN {
            atomicAdd(&counts[bucket], 1u);
        }
    }
    workgroupBarrier();
    for (var bucket = lane; bucket < SAMPLE_BUCKETS; bucket += 64u) {
        let count = atomicLoad(&counts[bucket]);
        if count > 0u {
            atomicAdd(&sample_histogram[bucket], count);
        }
    }
}
