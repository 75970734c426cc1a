// Rays against the scene: every instance is a matrix and a BVH over its mesh; all that never moves is instance 0.
// Source: Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997; the two-wide BVH is the
// builder's (obvhs): a node is two texels, (min, triangle count) and (max, first child or triangle).

// The far children of one path down; the builder checks every tree's depth against it.
const STACK_SIZE: u32 = 48u;
const COUNT_SHIFT: u32 = 24u;

struct Hit {
    distance: f32,
    // Barycentric weights of corners 1 and 2.
    weights: vec2f,
    triangle: u32,
    instance: u32,
}

var<private> stack: array<u32, STACK_SIZE>;

// An inner node's first child, or a leaf's triangle count and first triangle.
fn node_entry(low: vec4f, high: vec4f) -> u32 {
    return u32(high.w) | (u32(low.w) << COUNT_SHIFT);
}

// Where the ray enters the box, FAR where it does not before `limit`.
fn enter_box(low: vec3f, high: vec3f, origin: vec3f, inverse: vec3f, limit: f32) -> f32 {
    let a = (low - origin) * inverse;
    let b = (high - origin) * inverse;
    let near = min(a, b);
    let far = max(a, b);
    let enter = max(max(near.x, near.y), max(near.z, 0.0));
    // Widened by a few ulps, so that a ray along a box's face is not lost to rounding.
    let leave = min(min(far.x, far.y), min(far.z, limit)) * 1.0000004;
    return select(FAR, enter, enter <= leave);
}

fn is_hole(triangle: u32, material: u32, weights: vec2f) -> bool {
    let uvs = triangle_uvs(triangle);
    let uv = uvs[0] * (1.0 - weights.x - weights.y) + uvs[1] * weights.x + uvs[2] * weights.y;
    let layer = load_material(material, 3u)[BASE_COLOR];
    var alpha = load_material(material, 0u).w;
    if layer >= 0.0 {
        alpha *= sample_color(layer, image_uv(material, BASE_COLOR, uv), 0.0).w;
    }
    return alpha < load_material(material, 1u).z;
}

// The nearest hit before `limit`, or with `any` the first that is found; `distance` stays FAR without one.
fn intersect(origin: vec3f, direction: vec3f, limit: f32, any: bool) -> Hit {
    var hit = Hit(FAR, vec2f(0.0), 0u, 0u);
    var nearest = limit;
    for (var instance = 0u; instance < frame.instance_count; instance++) {
        let to_object = object_from_world(instance);
        let o = transform_point(to_object, origin);
        // Not normalised: distances stay those of the world.
        let d = transform_vector(to_object, direction);
        let inverse = 1.0 / select(d, vec3f(1e-12), abs(d) < vec3f(1e-12));
        let root = u32(load_frame(instance * INSTANCE_TEXELS + 9u).x);
        let root_low = textureLoad(nodes, scene_texel(2u * root), 0);
        let root_high = textureLoad(nodes, scene_texel(2u * root + 1u), 0);
        if enter_box(root_low.xyz, root_high.xyz, o, inverse, nearest) >= FAR {
            continue;
        }
        var entry = node_entry(root_low, root_high);
        var depth = 0u;
        var done = false;
        while !done {
            // Descend until a leaf, so that the lanes of a group meet in the leaves' loop.
            while !done && (entry >> COUNT_SHIFT) == 0u {
                let texel = 2u * entry;
                let low_a = textureLoad(nodes, scene_texel(texel), 0);
                let high_a = textureLoad(nodes, scene_texel(texel + 1u), 0);
                let low_b = textureLoad(nodes, scene_texel(texel + 2u), 0);
                let high_b = textureLoad(nodes, scene_texel(texel + 3u), 0);
                let enter_a = enter_box(low_a.xyz, high_a.xyz, o, inverse, nearest);
                let enter_b = enter_box(low_b.xyz, high_b.xyz, o, inverse, nearest);
                let a_first = enter_a <= enter_b;
                let near = node_entry(select(low_b, low_a, a_first), select(high_b, high_a, a_first));
                if max(enter_a, enter_b) < FAR {
                    stack[depth] = node_entry(select(low_a, low_b, a_first), select(high_a, high_b, a_first));
                    depth++;
                }
                if min(enter_a, enter_b) < FAR {
                    entry = near;
                } else if depth > 0u {
                    depth--;
                    entry = stack[depth];
                } else {
                    done = true;
                }
            }
            if done {
                break;
            }
            let first = entry & ((1u << COUNT_SHIFT) - 1u);
            let end = first + (entry >> COUNT_SHIFT);
            for (var i = first; i < end; i++) {
                let triangle = load_triangle(i);
                let p = cross(d, triangle.e2.xyz);
                let inverse_determinant = 1.0 / dot(triangle.e1.xyz, p);
                let s = o - triangle.v0.xyz;
                let u = dot(s, p) * inverse_determinant;
                let q = cross(s, triangle.e1.xyz);
                let v = dot(d, q) * inverse_determinant;
                let t = dot(triangle.e2.xyz, q) * inverse_determinant;
                // Written so that a NaN of a degenerate triangle is a miss.
                if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < nearest {
                    if triangle.v0.w >= 0.0 || !is_hole(i, triangle_material(triangle.v0.w), vec2f(u, v)) {
                        nearest = t;
                        hit = Hit(t, vec2f(u, v), i, instance);
                    }
                }
            }
            if any && hit.distance < FAR {
                return hit;
            }
            if depth > 0u {
                depth--;
                entry = stack[depth];
            } else {
                done = true;
            }
        }
    }
    return hit;
}

fn is_visible(origin: vec3f, direction: vec3f, distance: f32) -> bool {
    return intersect(origin, direction, distance, true).distance >= FAR;
}

// A point just off the surface on the side that `normal` points to.
fn leave_surface(position: vec3f, normal: vec3f) -> vec3f {
    let size = max(max(abs(position.x), abs(position.y)), max(abs(position.z), frame.offset_floor));
    return position + normal * (size * frame.eye.w);
}
