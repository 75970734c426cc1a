// One level of SVGF's edge-avoiding a-trous wavelet transform: section 4.3 and the edge-stopping function on
// luminance of section 4.4. Needs `color`, `state` and `surface`.

// Pixels between taps: 2^level (section 4.3).
override STEP: i32 = 1;
// The paper's value (section 4.4).
const SIGMA_LUMINANCE = 4.0;
// Against division by zero where nothing varies.
const LUMINANCE_EPSILON = 1e-6;

// B3 spline, by distance from the centre in taps.
fn spline(distance: i32) -> f32 {
    return select(select(1.0 / 16.0, 1.0 / 4.0, distance == 1), 3.0 / 8.0, distance == 0);
}

// The variance under a 3x3 Gaussian, because that of one pixel is itself noisy.
fn blurred_variance(pixel: vec2<i32>) -> f32 {
    var sum = 0.0;
    var total = 0.0;
    for (var y = -1; y <= 1; y++) {
        for (var x = -1; x <= 1; x++) {
            let tap = pixel + vec2(x, y);
            if inside(tap) {
                let variance = textureLoad(color, tap, 0).a;
                let weight = select(0.0, 1.0 / f32(1 << u32(abs(x) + abs(y))), variance >= 0.0);
                sum += weight * variance;
                total += weight;
            }
        }
    }
    return select(0.0, sum / total, total > 0.0);
}

// Filtered colour and its variance; for a surface without an estimate, that of its neighbours, where they have one.
fn filtered(pixel: vec2<i32>) -> vec4<f32> {
    let center = textureLoad(surface, pixel, 0).xy;
    let center_color = textureLoad(color, pixel, 0);
    if depth_of(center) == 0.0 {
        return center_color;
    }
    let has_estimate = center_color.a >= 0.0;
    let l = luminance(center_color.rgb);
    let deviations = 1.0 / (SIGMA_LUMINANCE * sqrt(blurred_variance(pixel)) + LUMINANCE_EPSILON);
    let normal = normal_of(center);
    let slope = slope_of(textureLoad(state, pixel, 0).xy);
    var sum = vec3(0.0);
    var variance = 0.0;
    var total = 0.0;
    for (var y = -2; y <= 2; y++) {
        for (var x = -2; x <= 2; x++) {
            let offset = STEP * vec2(x, y);
            let tap = pixel + offset;
            if !inside(tap) {
                continue;
            }
            let tap_color = textureLoad(color, tap, 0);
            if tap_color.a < 0.0 {
                continue;
            }
            var weight = spline(abs(x)) * spline(abs(y))
                * geometry_weight(center, normal, slope, textureLoad(surface, tap, 0).xy, vec2<f32>(offset));
            if has_estimate {
                weight *= exp(-abs(l - luminance(tap_color.rgb)) * deviations);
            }
            // Section 4.3: the weighted mean, and the variance of a weighted mean of independent values.
            sum += weight * tap_color.rgb;
            variance += weight * weight * tap_color.a;
            total += weight;
        }
    }
    if total <= 0.0 {
        return vec4(vec3(0.0), NO_ESTIMATE);
    }
    return vec4(sum / total, variance / (total * total));
}
