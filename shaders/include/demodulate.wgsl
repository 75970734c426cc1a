// How radiance and the signal that is filtered belong together: radiance = signal * demodulator + emission.

const ALBEDO_FLOOR = 0.02; // keeps black surfaces from blowing noise up

fn demodulator(albedo: vec3<f32>) -> vec3<f32> {
    return max(select(vec3(1.0), albedo, all_finite(albedo)), vec3(ALBEDO_FLOOR));
}

fn repair_emission(emission: vec3<f32>) -> vec3<f32> {
    return max(select(vec3(0.0), emission, all_finite(emission)), vec3(0.0));
}
