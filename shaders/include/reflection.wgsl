// Where what is seen in a surface appears to be: behind it, along the view ray, as in a mirror.
//
// A pass binds hit_distance, normal_roughness and depth.
// Source: the mirror equation, 1 / image = 1 / object + 2 curvature (Hecht, "Optics", section 5.4); how far the main direction of a
// rough lobe lies from the mirrored one: Lagarde and de Rousiers, "Moving Frostbite to Physically Based Rendering", SIGGRAPH
// 2014 course, section 4.9.3

const FARTHEST_REFLECTION = 1e3; // view depths; the sky
const LEAST_BEND = 0.1;          // of 1 + 2 curvature * distance: concave mirrors are not followed to their focus

// Distance behind the surface at which its reflection appears; 0 where it is not known, as of something on the surface itself.
fn reflection_distance(pixel: vec2<u32>, surface: Surface, position: vec3<f32>) -> f32 {
    let hit = known_hit_distance(pixel, surface, position);
    if hit <= 0.0 {
        return 0.0;
    }
    let bend = max(1.0 + 2.0 * curvature_at(pixel, surface, position) * hit, LEAST_BEND);
    let alpha = surface.roughness * surface.roughness;
    let mirror_like = (1.0 - alpha) * (sqrt(1.0 - alpha) + alpha);
    return mirror_like * hit / bend;
}

fn hit_distance_at(pixel: vec2<i32>, surface: Surface) -> f32 {
    let found = textureLoad(hit_distance, pixel, 0).x;
    let farthest = FARTHEST_REFLECTION * surface.depth;
    // By its bits: infinity is far, NaN is not known.
    let is_known = found > 0.0 && (bitcast<u32>(found) & 0x7fffffffu) <= 0x7f800000u;
    return select(0.0, select(min(found, farthest), farthest, !is_finite(found) || found >= frame.far), is_known);
}

// The pixel's own, or where no ray went the specular way, the mean of those of its neighbours on the surface.
fn known_hit_distance(pixel: vec2<u32>, surface: Surface, position: vec3<f32>) -> f32 {
    let own = hit_distance_at(vec2<i32>(pixel), surface);
    if own > 0.0 {
        return own;
    }
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0; i < 9; i++) {
        let texel = vec2<i32>(pixel) + vec2(i % 3 - 1, i / 3 - 1);
        if inside(texel, frame) {
            let found = hit_distance_at(texel, surface);
            let other = neighbour_at(texel);
            if found > 0.0 && continues(surface.normal, surface.depth, other.normal, other.position - position) {
                sum += 1.0 / found; // near things count more, as they move more
                count += 1.0;
            }
        }
    }
    return select(0.0, count / max(sum, 1e-30), count > 0.0);
}

struct Neighbour {
    normal: vec3<f32>,
    position: vec3<f32>,
}

fn neighbour_at(texel: vec2<i32>) -> Neighbour {
    let normal = repair_normal(textureLoad(normal_roughness, texel, 0).xyz);
    let d = textureLoad(depth, texel, 0).x;
    let seen = select(0.0, d, is_finite(d) && d > 0.0); // else far from any surface
    return Neighbour(normal, position_of(frame, frame.current, vec2<f32>(texel), seen));
}

// Of the surface, by how its normals turn from pixel to pixel: 1 / radius, positive where it bulges towards the viewer.
fn curvature_at(pixel: vec2<u32>, surface: Surface, position: vec3<f32>) -> f32 {
    let own = neighbour_at(vec2<i32>(pixel)); // its normal is not rounded, other than the surface's
    var sum = 0.0;
    var count = 0.0;
    for (var i = 0; i < 4; i++) {
        let side = (i & 2) - 1;
        let texel = vec2<i32>(pixel) + CURVATURE_STEP * select(vec2(0, side), vec2(side, 0), (i & 1) == 0);
        if inside(texel, frame) {
            let other = neighbour_at(texel);
            let offset = other.position - position;
            if continues(surface.normal, surface.depth, other.normal, offset) {
                sum += dot(other.normal - own.normal, offset) / max(dot(offset, offset), 1e-30);
                count += 1.0;
            }
        }
    }
    return sum / max(count, 1.0);
}

const CURVATURE_STEP = 2; // pixels: normals are rounded

// Where it appears, eye-relative.
fn reflected_position(position: vec3<f32>, distance: f32) -> vec3<f32> {
    return position - towards_eye(frame.current, position) * distance;
}

// Length of the view ray to the surface over that to its reflection: 1 on the surface, 0 at the sky.
fn nearness(length: f32, distance: f32) -> f32 {
    return length / max(length + distance, 1e-30);
}
