// The primary hit, from the image that `visibility` wrote.

@group(2) @binding(0) var hits: texture_2d<f32>;

fn primary_hit(pixel: vec2u, direction: vec3f) -> Hit {
    let stored = textureLoad(hits, pixel, 0);
    if stored.x < 0.0 {
        return Hit(FAR, vec2f(0.0), 0u, 0u);
    }
    var hit = Hit(0.0, stored.zw, u32(stored.x), u32(stored.y));
    let triangle = load_triangle(hit.triangle);
    let local = triangle.v0.xyz + triangle.e1.xyz * hit.weights.x + triangle.e2.xyz * hit.weights.y;
    hit.distance = dot(transform_point(world_from_object(hit.instance), local) - frame.eye.xyz, direction);
    return hit;
}
