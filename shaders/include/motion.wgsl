// The caller's motion: where the surface of a pixel was.
//
// A pass binds motion.

// UV from here to there in xy; in z, where it came with the motion, the view depth there minus that here.
fn motion_at(pixel: vec2<u32>) -> vec3<f32> {
    let stored = textureLoad(motion, frame.origin + pixel, 0);
    let nearer = select(stored.z, -stored.z, has(frame, FLAG_MOTION_FROM_PREVIOUS));
    return vec3(stored.xy * frame.motion_scale + frame.motion_offset, nearer);
}
