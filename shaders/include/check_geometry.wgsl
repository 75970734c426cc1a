// Do normals and depth belong together? On flat parts the normal that follows from the depth of the neighbours is compared with
// the normal given: as they are, and under each suspicion about normals, depth and camera. No frame before is needed.
//
// A pass binds normal_roughness, depth and suspects.

const NORMAL_VIEW_SPACE = 0u;      // where world space was said
const NORMAL_WORLD_SPACE = 1u;     // where view space was said
const NORMAL_MIRRORED = 2u;        // in view space, along z
const NORMAL_INVERTED = 3u;
const NORMAL_UNSIGNED = 4u;        // where signed numbers were said
const NORMAL_SIGNED = 5u;
const DEPTH_HARDWARE = 6u;         // under the camera's own projection
const DEPTH_INVERSE = 7u;          // 1 / depth: reversed, without a far plane
const DEPTH_INVERSE_FAR = 8u;      // 1 - 1 / depth: not reversed, the far plane far away
const DEPTH_REVERSED = 9u;         // 1 - depth / far
const DEPTH_ALONG_RAY = 10u;
const DEPTH_LINEAR = 11u;          // where something else was said
const NORMAL_CAMERA_TURNED = 12u;  // the camera's rotation is transposed
const GEOMETRY_SUSPICIONS = 13u;
const FIRST_DEPTH = DEPTH_HARDWARE;
const DEPTHS = 6u;

const FLAT_COSINE = 0.999;      // of the normals of neighbours on a flat part
const AGREES_COSINE = 0.9945;   // 6 degrees: flat parts of curved things, coarse normals
const DIFFERS_COSINE = 0.97;    // 14 degrees: one normal cannot agree with both

// Depths of a pixel and its neighbours: right, left, down, up.
struct Patch {
    centre: vec2<f32>,
    depth: f32,
    depths: vec4<f32>,
}

fn check_geometry(pixel: vec2<u32>, surface: Surface) {
    let raw = textureLoad(normal_roughness, frame.origin + pixel, 0).xyz;
    let is_octahedral = has(frame, FLAG_NORMAL_OCTAHEDRAL);
    let has_normal = all_finite(raw) && (is_octahedral || dot(raw, raw) > 1e-4);
    if !has_normal || !has_depth(pixel, surface) || any(pixel == vec2(0u)) || any(pixel + 1u >= frame.size) {
        return;
    }
    var given = Patch(vec2<f32>(pixel), surface.depth, vec4(0.0));
    var stored = Patch(vec2<f32>(pixel), stored_depth(pixel), vec4(0.0));
    for (var i = 0; i < 4; i++) {
        let at = vec2<u32>(vec2<i32>(pixel) + neighbour_step(i));
        let other = read_surface(at);
        if !has_depth(at, other) || other.id != surface.id || dot(other.normal, surface.normal) < FLAT_COSINE {
            return;
        }
        given.depths[i] = other.depth;
        stored.depths[i] = stored_depth(at);
    }
    let n = surface.normal;
    let in_view = patch_normal(given);
    let g = world_from_view(in_view);
    let holds = dot(n, g) > AGREES_COSINE && is_possible(given);
    if is_possible(given) {
        if has(frame, FLAG_NORMAL_VIEW) {
            suspect_normal(NORMAL_WORLD_SPACE, n, view_from_world(n), g, holds);
        } else {
            suspect_normal(NORMAL_VIEW_SPACE, n, world_from_view(n), g, holds);
        }
        let stored_view = select(n, view_from_world(n), has(frame, FLAG_NORMAL_VIEW));
        suspect_normal(NORMAL_MIRRORED, n, world_from_view(stored_view * vec3(1.0, 1.0, -1.0)), g, holds);
        suspect_normal(NORMAL_INVERTED, n, -n, g, holds);
        if !is_octahedral {
            let is_unsigned = has(frame, FLAG_NORMAL_UNSIGNED);
            let other = repair_normal(select(2.0 * raw - 1.0, raw, is_unsigned));
            let meant = select(other, world_from_view(other), has(frame, FLAG_NORMAL_VIEW));
            suspect_normal(select(NORMAL_UNSIGNED, NORMAL_SIGNED, is_unsigned), n, meant, g, holds);
        }
        let turned = view_from_world(in_view);
        if dot(g, turned) < DIFFERS_COSINE {
            vote(0u, NORMAL_CAMERA_TURNED, holds, dot(n, turned) > AGREES_COSINE);
        }
    }
    for (var i = 0u; i < DEPTHS; i++) {
        let suspicion = FIRST_DEPTH + i;
        var meant = stored;
        meant.depth = meant_depth(suspicion, stored.depth, stored.centre);
        for (var k = 0; k < 4; k++) {
            meant.depths[k] = meant_depth(suspicion, stored.depths[k], stored.centre + vec2<f32>(neighbour_step(k)));
        }
        let other = world_from_view(patch_normal(meant));
        let differs = dot(g, other) < DIFFERS_COSINE || !is_possible(given);
        if is_possible(meant) && differs {
            vote(0u, suspicion, holds, dot(n, other) > AGREES_COSINE);
        }
    }
}

// Also where the value cannot be what it is said to be. What a depth buffer is cleared to is at either end.
fn has_depth(pixel: vec2<u32>, surface: Surface) -> bool {
    let value = stored_depth(pixel);
    let is_drawn = is_finite(value) && value > 0.0 && value != 1.0;
    return !is_miss(surface) || (has(frame, FLAG_DEPTH_HARDWARE) && is_drawn);
}

fn is_possible(p: Patch) -> bool {
    return p.depth > 0.0 && all(p.depths > vec4(0.0));
}

fn stored_depth(pixel: vec2<u32>) -> f32 {
    return textureLoad(depth, frame.origin + pixel, 0).x;
}

fn suspect_normal(suspicion: u32, given: vec3<f32>, meant: vec3<f32>, geometric: vec3<f32>, holds: bool) {
    if dot(given, meant) < DIFFERS_COSINE {
        vote(0u, suspicion, holds, dot(meant, geometric) > AGREES_COSINE);
    }
}

fn neighbour_step(i: i32) -> vec2<i32> {
    let side = 1 - 2 * (i & 1);
    return select(vec2(0, side), vec2(side, 0), i < 2);
}

// Linear view depth, up to a factor that normals do not depend on, of a value that is meant to be something else. Not positive where
// it cannot be that.
fn meant_depth(suspicion: u32, value: f32, pixel: vec2<f32>) -> f32 {
    switch suspicion {
        case DEPTH_HARDWARE: {
            let c = frame.unprojection;
            let w = c.z + c.w * value;
            return select(-1.0, (c.x + c.y * value) / w, w != 0.0);
        }
        case DEPTH_INVERSE: { return 1.0 / value; }
        case DEPTH_INVERSE_FAR: { return select(-1.0, 1.0 / (1.0 - value), value < 1.0); }
        case DEPTH_REVERSED: { return 1.0 - value; }
        case DEPTH_LINEAR: { return value; }
        default: {
            // A ray is the longer the farther off the axis it goes; all are parallel in an orthographic view.
            return value / length(mix(vec3(0.0, 0.0, 1.0), view_position(pixel, 1.0), frame.current.perspective));
        }
    }
}

// Relative to the eye, in view space.
fn view_position(pixel: vec2<f32>, depth: f32) -> vec3<f32> {
    return view_from_world(position_of(frame.current, pixel, depth));
}

fn view_from_world(v: vec3<f32>) -> vec3<f32> {
    return (frame.current.view_from_world * vec4(v, 0.0)).xyz;
}

fn world_from_view(v: vec3<f32>) -> vec3<f32> {
    return (vec4(v, 0.0) * frame.current.view_from_world).xyz;
}

// Unit normal in view space that faces the eye.
fn patch_normal(p: Patch) -> vec3<f32> {
    var corners: array<vec3<f32>, 4>;
    for (var i = 0; i < 4; i++) {
        corners[i] = view_position(p.centre + vec2<f32>(neighbour_step(i)), p.depths[i]);
    }
    // Scaled first: of tiny and of huge depths, and of narrow views, the product would leave what `repair_normal` takes.
    let across = repair_normal((corners[0] - corners[1]) / max(length(corners[0] - corners[1]), 1e-30));
    let down = repair_normal((corners[2] - corners[3]) / max(length(corners[2] - corners[3]), 1e-30));
    let n = repair_normal(cross(down, across));
    let eye = select(vec3(0.0, 0.0, 1.0), -view_position(p.centre, p.depth), frame.current.perspective > 0.0);
    return select(-n, n, dot(n, eye) > 0.0);
}
