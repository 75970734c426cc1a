// What radiance is divided by before filtering and multiplied with after it.

const ALBEDO_FLOOR = 0.02; // keeps black surfaces from blowing noise up

fn demodulator(albedo: vec3<f32>) -> vec3<f32> {
    return max(select(vec3(1.0), albedo, all_finite(albedo)), vec3(ALBEDO_FLOOR));
}
