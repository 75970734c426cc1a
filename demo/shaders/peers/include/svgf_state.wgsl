// SVGF's state of a pixel in 8 bytes: mean and standard deviation of the samples' luminance over time in x; the slope
// of depth (12 bits an axis) and the history's length (8 bits) in y.

// In the place of a variance: the pixel is a miss, or has no sample yet.
const NO_ESTIMATE = -1.0;

// Section 4.2: variance = second moment - first moment squared.
fn variance_of(moments: vec2<f32>) -> f32 {
    return max(moments.y - moments.x * moments.x, 0.0);
}

// Half precision keeps mean and deviation well, but not their difference as moments.
fn pack_state(moments: vec2<f32>, slope: vec2<f32>, length: u32) -> vec2<u32> {
    let deviation = min(sqrt(variance_of(moments)), 65504.0);
    // The upper 12 bits of a half: sign, exponent, 6 bits of fraction.
    let halves = pack2x16float(clamp(slope, vec2(-65504.0), vec2(65504.0)));
    let steps = ((halves >> 4u) & 0xfffu) | ((halves >> 8u) & 0xfff000u);
    return vec2(pack2x16float(vec2(moments.x, deviation)), steps | (length << 24u));
}

// First and second moment of luminance.
fn moments_of(state: vec2<u32>) -> vec2<f32> {
    let m = unpack2x16float(state.x);
    return vec2(m.x, m.y * m.y + m.x * m.x);
}

// Change of depth per pixel to the right and down, as parts of the depth.
fn slope_of(state: vec2<u32>) -> vec2<f32> {
    return unpack2x16float(((state.y & 0xfffu) << 4u) | ((state.y & 0xfff000u) << 8u));
}

fn length_of(state: vec2<u32>) -> u32 {
    return state.y >> 24u;
}
