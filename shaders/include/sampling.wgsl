// What further samples are worth, and how the gains of a frame are counted.
//
// Source: the share of an image's samples goes by what another sample takes off the relative squared error: Moon et al. 2015,
// section 4.4

// Gains are kept as buckets of their logarithm, so that their sum is known from a histogram.
const SAMPLE_BUCKETS = 512u;
const SAMPLE_OCTAVES = vec2(-40.0, 64.0); // the least, and how many

const SAMPLE_RATE = SAMPLE_BUCKETS; // the word after the histogram: samples per gain

const EVEN_SHARE = 0.25; // of all samples goes to all pixels alike, or what changes where nothing was wrong goes unnoticed
// Of a pixel in a frame. A pixel of thin geometry, new in every frame, would take any number; the others would pay.
const MOST_TIMES = 4.0; // the budget
const MOST_AT_LEAST = 2.0;

fn bucket_of(gain: f32) -> u32 {
    let place = (log2(max(gain, 1e-30)) - SAMPLE_OCTAVES.x) / SAMPLE_OCTAVES.y * f32(SAMPLE_BUCKETS);
    return u32(clamp(place, 0.0, f32(SAMPLE_BUCKETS) - 1.0));
}

fn gain_of(bucket: u32) -> f32 {
    return exp2((f32(bucket) + 0.5) / f32(SAMPLE_BUCKETS) * SAMPLE_OCTAVES.y + SAMPLE_OCTAVES.x);
}

// Samples of a pixel, of which the mean is wanted, when a gain is worth `rate`.
fn expected_samples(bucket: u32, rate: f32) -> f32 {
    let budget = frame.sample_budget;
    return min(EVEN_SHARE * budget + rate * gain_of(bucket), max(MOST_TIMES * budget, MOST_AT_LEAST));
}
