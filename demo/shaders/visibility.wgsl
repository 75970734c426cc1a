// visibility: what each pixel sees, and where that was a frame ago.
//
// Reads:  the scene, the frame
// Writes: hit (triangle, instance, weights; triangle -1 at a miss), depth, motion, surface_id
// Source: design, section 1 (the denoiser's inputs)

//!include scene
//!include images
//!include intersect
//!include camera

@group(2) @binding(0) var hit_out: texture_storage_2d<rgba32float, write>;
@group(2) @binding(1) var depth_out: texture_storage_2d<r32float, write>;
@group(2) @binding(2) var motion_out: texture_storage_2d<rgba16float, write>;
@group(2) @binding(3) var surface_id_out: texture_storage_2d<r32uint, write>;

@compute @workgroup_size(8, 8)
fn visibility(@builtin(global_invocation_id) id: vec3u) {
    let pixel = id.xy;
    if any(pixel >= frame.size) {
        return;
    }
    let position_px = sample_position_px(pixel);
    let direction = camera_direction(position_px);
    let hit = intersect(frame.eye.xyz, direction, FAR, false);
    if hit.distance >= FAR {
        let prev = prev_position_px(vec4f(direction, 0.0));
        let motion = select(vec2f(0.0), prev.xy - position_px, prev.z > 0.0);
        textureStore(hit_out, pixel, vec4f(-1.0, 0.0, 0.0, 0.0));
        // The bits of infinity, which WGSL cannot write as a number.
        textureStore(depth_out, pixel, vec4f(bitcast<f32>(INFINITY_BITS | (pixel.x >> 16u))));
        textureStore(motion_out, pixel, vec4f(motion, 0.0, 0.0));
        textureStore(surface_id_out, pixel, vec4u(0u));
        return;
    }
    let triangle = load_triangle(hit.triangle);
    let local = triangle.v0.xyz + triangle.e1.xyz * hit.weights.x + triangle.e2.xyz * hit.weights.y;
    let world = transform_point(world_from_object(hit.instance), local);
    let prev_world = transform_point(prev_world_from_object(hit.instance), local);
    let depth = -(frame.view_from_world * vec4f(world, 1.0)).z;
    let prev = prev_position_px(vec4f(prev_world, 1.0));
    // A point that was behind the camera has no place in the previous image.
    let motion = select(vec2f(1e4), prev.xy - position_px, prev.z > 0.0);
    textureStore(hit_out, pixel, vec4f(f32(hit.triangle), f32(hit.instance), hit.weights));
    textureStore(depth_out, pixel, vec4f(depth));
    textureStore(motion_out, pixel, vec4f(motion, prev.z - depth, 0.0));
    let base = load_frame(hit.instance * INSTANCE_TEXELS + 9u).y;
    textureStore(surface_id_out, pixel, vec4u(u32(triangle.e1.w + base)));
}
