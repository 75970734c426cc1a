// How radiance and the signal that is filtered belong together: radiance = signal * demodulator + emission.
//
// A pass binds albedo: that of the signal.
// Source: 0.9 albedo + 0.1: on dark surfaces what a highlight reflects must not be blown up; radiance stays linear in the
// inverse, with albedo E + S = (D - 0.1) / 0.9 E + S. Reflectance of a dielectric: Lagarde, "Adopting a physically based shading
// model", 2011: Schlick's formula, limited at grazing angles by roughness

const COMBINED_FLOOR = 0.1;
const ALBEDO_FLOOR = 0.02; // of a signal of one lobe: keeps black surfaces from blowing noise up
const DIELECTRIC_F0 = 0.04;

fn demodulator(albedo: vec3<f32>) -> vec3<f32> {
    let reflectance = max(select(vec3(1.0), albedo, all_finite(albedo)), vec3(0.0));
    if has(frame, FLAG_SPLIT) {
        return max(reflectance, vec3(ALBEDO_FLOOR));
    }
    return COMBINED_FLOOR + (1.0 - COMBINED_FLOOR) * reflectance;
}

// Of the signal that the pass works on.
fn demodulator_at(pixel: vec2<u32>, surface: Surface) -> vec3<f32> {
    if IS_SPECULAR && !has(frame, FLAG_SPECULAR_ALBEDO) {
        return vec3(max(dielectric_reflectance(pixel, surface), ALBEDO_FLOOR));
    }
    return demodulator(textureLoad(albedo, frame.origin + pixel, 0).rgb);
}

fn dielectric_reflectance(pixel: vec2<u32>, surface: Surface) -> f32 {
    let position = position_of(frame.current, vec2<f32>(pixel), surface.depth);
    let towards = towards_eye(frame.current, position);
    let grazing = pow(1.0 - saturate(dot(surface.normal, towards)), 5.0);
    return mix(DIELECTRIC_F0, max(1.0 - surface.roughness, DIELECTRIC_F0), grazing);
}

fn repair_emission(emission: vec3<f32>) -> vec3<f32> {
    return max(select(vec3(0.0), emission, all_finite(emission)), vec3(0.0));
}
