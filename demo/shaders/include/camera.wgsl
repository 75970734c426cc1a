// The camera of the frame and of the one before it. Both are perspective.

// Unit direction through a position in pixels.
fn camera_direction(position_px: vec2f) -> vec3f {
    let ndc = (position_px / vec2f(frame.size) * 2.0 - 1.0) * vec2f(1.0, -1.0);
    let view = vec3f((ndc + frame.projection.zw) / frame.projection.xy, -1.0);
    return normalize((vec4f(view, 0.0) * frame.view_from_world).xyz);
}

// Where this frame's sample of a pixel lies.
fn sample_position_px(pixel: vec2u) -> vec2f {
    return vec2f(pixel) + 0.5 + frame.jitter_px;
}

// A position (w 1) or direction (w 0) in the previous image, in pixels; z is its view depth.
fn prev_position_px(world: vec4f) -> vec3f {
    let view = frame.prev_view_from_world * world;
    let ndc = view.xy * frame.prev_projection.xy / -view.z - frame.prev_projection.zw;
    return vec3f((ndc * vec2f(0.5, -0.5) + 0.5) * vec2f(frame.size), -view.z);
}
