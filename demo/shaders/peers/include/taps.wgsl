// Pixels of the previous frame that a pixel's history is in.

// The 2x2 pixels from `base` on, row by row, with weights that add up to 1; all 0 where there is no history.
struct Taps {
    base: vec2<i32>,
    weights: vec4<f32>,
}

fn tap_offset(i: i32) -> vec2<i32> {
    return vec2(i & 1, i >> 1);
}

fn has_history(taps: Taps) -> bool {
    return any(taps.weights > vec4(0.0));
}

// What the taps hold of an image, weighted.
fn fetch(image: texture_2d<f32>, taps: Taps) -> vec4<f32> {
    var sum = vec4(0.0);
    for (var i = 0; i < 4; i++) {
        if taps.weights[i] > 0.0 {
            sum += taps.weights[i] * textureLoad(image, taps.base + tap_offset(i), 0);
        }
    }
    return sum;
}
