// sample_map: how many samples each pixel should get in the next frame, under an average.
//
// Reads   guide, history, error, sample_histogram; the caller's motion.
// Writes  samples: the caller's image
// Source  Moon et al. 2015, section 4.4; dither: Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018

//!include frame numbers surface motion error sampling sample_gain

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var guide: texture_2d<u32>;
@group(0) @binding(2) var motion: texture_2d<f32>;
@group(0) @binding(3) var history: texture_2d<f32>;
@group(0) @binding(4) var error: texture_2d<u32>;
@group(0) @binding(5) var<storage, read> sample_histogram: array<u32>;
@group(0) @binding(6) var samples: texture_storage_2d<r32uint, write>;

@compute @workgroup_size(8, 8)
fn sample_map(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let bucket = gain_bucket(id.xy);
    if bucket == NO_GAIN {
        // A path that ends where it begins; what it shows is passed through.
        textureStore(samples, frame.origin + id.xy, vec4(1u));
        return;
    }
    let expected = expected_samples(bucket, bitcast<f32>(sample_histogram[SAMPLE_RATE]));
    textureStore(samples, frame.origin + id.xy, vec4(u32(floor(expected + threshold(id.xy)))));
}

// In 0..1: even over neighbours, and over the frames of a pixel.
fn threshold(pixel: vec2<u32>) -> f32 {
    let place = vec2<f32>(pixel % vec2(4096u));
    return fract(dot(place, vec2(0.7548776662, 0.5698402910)) + f32(frame.index % 4096u) * 0.6180339887);
}
