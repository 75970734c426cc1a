// Does motion lead to where the previous camera saw the surface? What stood still moved as depth and the two cameras say: that is
// compared with motion as given, and under each suspicion about motion and cameras.
//
// A pass binds motion, previous_guide, previous_motion and suspects.

const MOTION_BACKWARDS = 0u;
const MOTION_BACKWARDS_X = 1u;
const MOTION_BACKWARDS_Y = 2u;
const MOTION_IN_UV = 3u;           // where the settings say pixels
const MOTION_IN_PIXELS = 4u;       // where the settings say UV
const MOTION_HALF = 5u;
const MOTION_DOUBLE = 6u;
const MOTION_NDC = 7u;             // doubled, and y up
const MOTION_JITTERED = 8u;        // holds previous minus current jitter
const MOTION_UNJITTERED = 9u;      // that was taken out, but was not in it
const CAMERA_LATE = 10u;
const CAMERA_INVERSE = 11u;
const CAMERA_TURNED = 12u;         // its rotation alone is transposed
const MOTION_MISSING = 13u;        // 0, though the camera moves
const MOTION_SUSPICIONS = 14u;

const LEAST_MOTION_PX = 0.25;      // that tells directions and scales
const STILL_PX = 1e-6;             // UV taken for pixels is more
const CHANGED_DEPTH = 0.01;        // of the depth
const LEAST_JITTER_PX = 0.1;
// By which the steps of a camera that moves smoothly differ: little, but motion in half precision is finer.
const LEAST_LATENESS_PX = 0.005;
const LEAST_LATENESS = 0.002;

// Rounding to half precision, and what renderers differ by in how they take differences.
fn tolerance_px(motion_px: vec2<f32>) -> f32 {
    return 0.03 + 0.005 * length(motion_px);
}

struct Moved {
    given: vec2<f32>,      // pixels
    predicted: vec2<f32>,
}

fn check_motion(pixel: vec2<u32>, surface: Surface, moved: vec2<f32>) {
    let size = frame.current.size;
    let at = vec2<f32>(pixel);
    let jitter = frame.current.jitter;
    let given = Moved(moved, predicted_px(frame.current, frame.previous, frame.eye_delta, at + jitter, surface.depth));
    if length(given.predicted) > LEAST_MOTION_PX {
        suspect_motion(MOTION_BACKWARDS, given, -moved);
        suspect_motion(MOTION_BACKWARDS_X, given, moved * vec2(-1.0, 1.0));
        suspect_motion(MOTION_BACKWARDS_Y, given, moved * vec2(1.0, -1.0));
        suspect_motion(MOTION_IN_UV, given, moved * size);
        suspect_motion(MOTION_IN_PIXELS, given, moved / size);
        suspect_motion(MOTION_HALF, given, moved * 2.0);
        suspect_motion(MOTION_DOUBLE, given, moved * 0.5);
        suspect_motion(MOTION_NDC, given, moved * vec2(0.5, -0.5));
    }
    if length(given.predicted) > LEAST_MOTION_PX && has_changed(pixel, surface) {
        vote(FIRST_MOTION, MOTION_MISSING, length(moved - given.predicted) < tolerance_px(given.predicted), length(moved) < STILL_PX);
    }
    let jittered = frame.previous.jitter / frame.previous.size * size - jitter;
    if length(jittered) > LEAST_JITTER_PX {
        suspect_motion(MOTION_JITTERED, given, moved + jittered);
        suspect_motion(MOTION_UNJITTERED, given, moved - jittered);
    }
    let inverse = predicted_px(suspects.inverse_current, suspects.inverse_previous, suspects.inverse_eye_delta, at + jitter, surface.depth);
    suspect(CAMERA_INVERSE, given, Moved(moved, inverse));
    let turned = predicted_px(suspects.turned_current, suspects.turned_previous, suspects.turned_eye_delta, at + jitter, surface.depth);
    suspect(CAMERA_TURNED, given, Moved(moved, turned));
}

// Whether a pixel shows something else than before: what moves with the camera, as a cockpit does, rightly has no motion.
fn has_changed(pixel: vec2<u32>, surface: Surface) -> bool {
    if any(frame.previous.size != frame.current.size) {
        return false;
    }
    let before = unpack_surface(textureLoad(previous_guide, pixel, 0).xy);
    return before.id != surface.id || abs(before.depth - surface.depth) > CHANGED_DEPTH * surface.depth;
}

// If the camera comes a frame late, then only now has the one come that the previous frame was seen with.
fn check_lateness(pixel: vec2<u32>) {
    let depth = unpack_surface(textureLoad(previous_guide, pixel, 0).xy).depth;
    let moved = bitcast<vec2<f32>>(textureLoad(previous_motion, pixel, 0).xy);
    if depth <= 0.0 || !is_finite(moved.x) || !is_finite(moved.y) {
        return;
    }
    let at = vec2<f32>(pixel) + frame.previous.jitter;
    let off = moved - predicted_px(frame.previous, suspects.before, suspects.before_eye_delta, at, depth);
    let late_off = moved - predicted_px(frame.current, frame.previous, frame.eye_delta, at, depth);
    let apart = length(off - late_off);
    // Also false where one is not finite.
    if apart > LEAST_LATENESS_PX + LEAST_LATENESS * length(moved) {
        vote(FIRST_MOTION, CAMERA_LATE, length(off) < 0.5 * apart, length(late_off) < 0.5 * apart);
    }
}

fn suspect_motion(suspicion: u32, given: Moved, meant: vec2<f32>) {
    suspect(suspicion, given, Moved(meant, given.predicted));
}

fn suspect(suspicion: u32, given: Moved, meant: Moved) {
    let off = given.given - given.predicted;
    let meant_off = meant.given - meant.predicted;
    let tolerance = tolerance_px(given.predicted);
    // Also false where one is not finite.
    if length(off - meant_off) > 4.0 * tolerance {
        vote(FIRST_MOTION, suspicion, length(off) < tolerance, length(meant_off) < tolerance_px(meant.predicted));
    }
}

// Previous minus current place of a point that stands still, in pixels, of where its sample lies.
fn predicted_px(current: View, previous: View, eye_delta: vec3<f32>, at: vec2<f32>, depth: f32) -> vec2<f32> {
    let size = current.size;
    let uv = (at + 0.5) / size;
    let before = project(previous, position_at(current, uv, depth) + eye_delta);
    // Behind the eye it was seen nowhere.
    let scale = select(1e9, 1.0, before.z > 0.0 || previous.perspective == 0.0);
    return (before.xy - uv) * size * scale;
}
