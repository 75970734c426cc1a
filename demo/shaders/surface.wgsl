// surface: the look of what each pixel sees.
//
// Reads:  the scene, the frame, hits
// Writes: albedo, normal_roughness, emission
// Source: design, section 1 (the denoiser's inputs)

//!include scene
//!include images
//!include intersect
//!include camera
//!include surface
//!include primary

@group(2) @binding(1) var albedo_out: texture_storage_2d<rgba16float, write>;
@group(2) @binding(2) var normal_roughness_out: texture_storage_2d<rgba16float, write>;
@group(2) @binding(3) var emission_out: texture_storage_2d<rgba16float, write>;

@compute @workgroup_size(8, 8)
fn surface(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if any(pixel >= frame.size) {
        return;
    }
    let direction = camera_direction(sample_position_px(pixel));
    let hit = primary_hit(pixel, direction);
    if hit.distance >= FAR {
        textureStore(albedo_out, pixel, vec4f(1.0));
        textureStore(normal_roughness_out, pixel, vec4f(0.0));
        textureStore(emission_out, pixel, vec4f(0.0));
        return;
    }
    let seen = load_surface(hit, direction, hit.distance * frame.light_choice.w);
    let albedo = diffuse_color(seen) + seen.metallic * specular_color(seen);
    textureStore(albedo_out, pixel, vec4f(albedo, 1.0));
    textureStore(normal_roughness_out, pixel, vec4f(seen.normal, seen.roughness));
    textureStore(emission_out, pixel, vec4f(seen.emission, 1.0));
}
