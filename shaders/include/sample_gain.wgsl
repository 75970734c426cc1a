// What a further sample of a pixel is worth, in the next frame.
//
// A pass binds guide, motion, history and error.

const NO_GAIN = 0xffffffffu; // a miss

// Bucket of the gain of a pixel of the next frame. The camera is taken to move on as it did.
fn gain_bucket(pixel: vec2<u32>) -> u32 {
    let moved = motion_at(pixel).xy * frame.current.size;
    var place = vec2<f32>(pixel);
    if is_finite(moved.x) && is_finite(moved.y) {
        place += clamp(round(moved), vec2(-1e4), vec2(1e4));
    }
    let seen = clamp(place, vec2(0.0), vec2<f32>(frame.size - 1u));
    let source = vec2<u32>(seen);
    if is_miss(unpack_surface(textureLoad(guide, source, 0).xy)) {
        return NO_GAIN;
    }
    // What comes into view was never sampled.
    var count = 0.0;
    if all(seen == place) {
        count = textureLoad(history, source, 0).w;
    }
    let expected = unpack_error(textureLoad(error, source, 0).x);
    // The root of what another sample takes off the squared error: errors are seen by their deviation, and the squares of
    // expected ones, which are noisy, would send most samples after a few of them.
    return bucket_of(sqrt(relative_square(expected) / (count + 1.0)));
}

fn relative_square(e: OutputError) -> f32 {
    return e.deviation * e.deviation / (e.luminance * e.luminance + frame.dark_level * frame.dark_level);
}
