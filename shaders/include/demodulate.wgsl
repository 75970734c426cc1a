// How radiance and the signal that is filtered belong together: radiance = signal * demodulator + emission.

// What a dark surface reflects through its specular lobe must not be blown up. Radiance stays linear in the inverse: with
// D = 0.1 + 0.9 albedo, albedo E + S is (D - 0.1) / 0.9 E + S.
const ALBEDO_FLOOR = 0.1;

fn demodulator(albedo: vec3<f32>) -> vec3<f32> {
    let reflectance = max(select(vec3(1.0), albedo, all_finite(albedo)), vec3(0.0));
    return ALBEDO_FLOOR + (1.0 - ALBEDO_FLOOR) * reflectance;
}

fn repair_emission(emission: vec3<f32>) -> vec3<f32> {
    return max(select(vec3(0.0), emission, all_finite(emission)), vec3(0.0));
}
