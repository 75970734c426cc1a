// Are hit distances in world units? From smooth surfaces the ray of a mirror is followed over the screen until it meets a surface
// that faces it; the distance given over the one found is counted by its logarithm.
//
// A pass binds hit_distance.

const REFLECTED = 0u;             // rays that met something
const ALONG_PATH = 1u;            // of these, those whose distance is right once the way from the eye to the surface is taken off
const FIRST_RATIO = 2u;
const RATIOS = 97u;               // -12 to 12 octaves in quarters; the middle one is a ratio of 1
const REFLECTION_WORDS = FIRST_RATIO + RATIOS;

const SMOOTH_ROUGHNESS = 0.2;
const MARCH_STEPS = 64;
const MARCH_FIRST = 0.02;         // of the depth
const MARCH_GROWTH = 1.12;        // to about 28 times the depth
const LEAST_LIFT = 0.03;          // of the depth: what is met lies clear of the surface's own plane
const MEETS = 0.01;               // of the depth: off the tangent plane of what is met

fn check_reflection(pixel: vec2<u32>, surface: Surface) {
    let told = textureLoad(hit_distance, frame.origin + pixel, 0).x;
    if surface.roughness > SMOOTH_ROUGHNESS || !(told > 0.0) || !is_finite(told) || told > LARGEST_DEPTH {
        return;
    }
    let position = position_of(frame.current, vec2<f32>(pixel), surface.depth);
    let towards = reflect(-towards_eye(frame.current, position), surface.normal);
    let found = march(position, towards, surface);
    if found <= 0.0 {
        return;
    }
    tally(FIRST_REFLECTION + REFLECTED, true);
    let own = told - ray_length(frame.current, position);
    tally(FIRST_REFLECTION + ALONG_PATH, own > 0.0 && abs(log2(own / found)) < 0.125);
    let bin = i32(round(4.0 * log2(told / found))) + i32(RATIOS / 2u);
    if bin >= 0 && bin < i32(RATIOS) {
        tally(FIRST_REFLECTION + FIRST_RATIO + u32(bin), true);
    }
}

// Distance to what the ray meets on the screen; 0 where that is not sure.
fn march(start: vec3<f32>, towards: vec3<f32>, from_surface: Surface) -> f32 {
    var t = MARCH_FIRST * from_surface.depth;
    for (var i = 0; i < MARCH_STEPS; i++) {
        let point = start + t * towards;
        let projected = project(frame.current, point);
        let texel = vec2<i32>(floor(projected.xy * frame.current.size - frame.current.jitter));
        if projected.z <= 0.0 || !inside(texel, frame.current) {
            return 0.0;
        }
        let met = read_surface(vec2<u32>(texel));
        if !is_miss(met) && projected.z > met.depth {
            return refine(start, towards, from_surface, texel, met);
        }
        t *= MARCH_GROWTH;
    }
    return 0.0;
}

// Where the ray meets the tangent plane of the surface that it passed behind, if that surface is seen there.
fn refine(start: vec3<f32>, towards: vec3<f32>, from_surface: Surface, first: vec2<i32>, passed: Surface) -> f32 {
    var texel = first;
    var met = passed;
    var t = 0.0;
    for (var i = 0; i < 4; i++) {
        let on_plane = position_of(frame.current, vec2<f32>(texel), met.depth);
        let facing = dot(met.normal, towards);
        if facing > -0.05 || abs(dot(from_surface.normal, on_plane - start)) < LEAST_LIFT * from_surface.depth {
            return 0.0;
        }
        let last = t;
        t = dot(met.normal, on_plane - start) / facing;
        if i > 0 && abs(t - last) < MEETS * t {
            return t;
        }
        let projected = project(frame.current, start + t * towards);
        texel = vec2<i32>(floor(projected.xy * frame.current.size - frame.current.jitter));
        if t <= 0.0 || projected.z <= 0.0 || !inside(texel, frame.current) {
            return 0.0;
        }
        met = read_surface(vec2<u32>(texel));
        if is_miss(met) {
            return 0.0;
        }
    }
    return 0.0;
}
