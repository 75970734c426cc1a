// sample_rate: what a gain is worth in samples, so that the mean of all is the budget.
//
// Reads   sample_histogram: of gains (include/sampling).
// Writes  sample_histogram: the rate behind it
// Source  bisection

//!include frame sampling

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read_write> sample_histogram: array<u32>;

const HALVINGS = 32u;

var<workgroup> sums: array<f32, 64>;

@compute @workgroup_size(64)
fn sample_rate(@builtin(local_invocation_index) lane: u32) {
    // In octaves; beyond these the least gain takes all samples that a pixel may have, or the largest takes none.
    var bounds = vec2(-SAMPLE_OCTAVES.x - SAMPLE_OCTAVES.y - 16.0, -SAMPLE_OCTAVES.x + 16.0);
    for (var i = 0u; i < HALVINGS; i++) {
        let middle = 0.5 * (bounds.x + bounds.y);
        let is_much = excess_samples(exp2(middle), lane) > 0.0;
        bounds = select(vec2(middle, bounds.y), vec2(bounds.x, middle), is_much);
    }
    if lane == 0u {
        sample_histogram[SAMPLE_RATE] = bitcast<u32>(exp2(bounds.x));
    }
}

// Expected samples beyond the budget, over the frame.
fn excess_samples(rate: f32, lane: u32) -> f32 {
    var sum = 0.0;
    for (var bucket = lane; bucket < SAMPLE_BUCKETS; bucket += 64u) {
        sum += f32(sample_histogram[bucket]) * (expected_samples(bucket, rate) - frame.sample_budget);
    }
    sums[lane] = sum;
    workgroupBarrier();
    var total = 0.0;
    for (var i = 0u; i < 64u; i++) {
        total += sums[i];
    }
    workgroupBarrier();
    return total;
}
