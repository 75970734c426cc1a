// How radiance and the signal that is filtered belong together: radiance = signal * demodulator + emission, as in the
// denoiser, so that no method has an advantage by it.

const COMBINED_FLOOR = 0.1; // keeps what dark surfaces reflect from being blown up

fn demodulator(albedo: vec3<f32>) -> vec3<f32> {
    let reflectance = max(select(vec3(1.0), albedo, all_finite(albedo)), vec3(0.0));
    return COMBINED_FLOOR + (1.0 - COMBINED_FLOOR) * reflectance;
}

fn demodulated(radiance: vec3<f32>, albedo: vec3<f32>, emission: vec3<f32>) -> vec3<f32> {
    return sanitise((sanitise(radiance) - sanitise(emission)) / demodulator(albedo));
}

fn remodulated(signal: vec3<f32>, albedo: vec3<f32>, emission: vec3<f32>) -> vec3<f32> {
    return sanitise(signal * demodulator(albedo) + sanitise(emission));
}

// Rec. 709.
fn luminance(color: vec3<f32>) -> f32 {
    return dot(color, vec3(0.2126, 0.7152, 0.0722));
}
