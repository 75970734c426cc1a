// lobes: what the specular lobe reflects towards the camera, and what the split images hold where nothing is traced.
//
// Reads:  the scene, the frame, hits
// Writes: specular_albedo, 1 at a miss; rest and specular, black; hit_distance, 0 for unknown
// Source: points: Hammersley's; radical inverse: Dammertz, holger.dammertz.org/stuff/notes_HammersleyOnHemisphere.html

//!include scene
//!include images
//!include random
//!include intersect
//!include camera
//!include surface
//!include bsdf
//!include primary

@group(2) @binding(1) var specular_albedo_out: texture_storage_2d<rgba16float, write>;
@group(2) @binding(2) var rest_out: texture_storage_2d<rgba32float, write>;
@group(2) @binding(3) var specular_out: texture_storage_2d<rgba32float, write>;
@group(2) @binding(4) var hit_distance_out: texture_storage_2d<r32float, write>;

// Directions that the lobe is integrated over. Drawn by visible normals they hardly differ in weight: few are enough.
const POINTS: u32 = 32u;

@compute @workgroup_size(8, 8)
fn lobes(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if any(pixel >= frame.size) {
        return;
    }
    textureStore(rest_out, pixel, vec4f(0.0, 0.0, 0.0, 1.0));
    textureStore(specular_out, pixel, vec4f(0.0, 0.0, 0.0, 1.0));
    textureStore(hit_distance_out, pixel, vec4f(0.0));
    let direction = camera_direction(sample_position_px(pixel));
    let hit = primary_hit(pixel, direction);
    var albedo = vec3f(1.0);
    if hit.distance < FAR {
        let seen = load_surface(hit, direction, hit.distance * frame.light_choice.w);
        albedo = specular_albedo(seen, -direction * basis(seen.normal));
    }
    textureStore(specular_albedo_out, pixel, vec4f(albedo, 1.0));
}

// Integrated with the tracer's own lobe, so that it is what the tracer converges to under even light.
fn specular_albedo(seen: Surface, out: vec3f) -> vec3f {
    var bsdf = make_bsdf(seen, out.z);
    if bsdf.choose_specular == 0.0 {
        return vec3f(0.0);
    }
    // The density of this lobe alone.
    bsdf.choose_specular = 1.0;
    var sum = vec3f(0.0);
    for (var i = 0u; i < POINTS; i++) {
        let u = vec2f((f32(i) + 0.5) / f32(POINTS), f32(reverseBits(i)) * 0x1p-32);
        let reflected = evaluate_bsdf(bsdf, out, sample_specular(bsdf, out, u));
        sum += reflected.specular / max(reflected.pdf, 1e-20);
    }
    return sum / f32(POINTS);
}
