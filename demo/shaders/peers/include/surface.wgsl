// What is seen at a pixel in 8 bytes, so that a filter's tap costs one small load: view depth in x; normal
// (octahedral, 11 bits a side) and 10 bits of the surface's id in y. Depth is 0 at a miss and negative where the
// surface was never sampled, which is no history.

struct Surface {
    depth: f32,
    normal: vec3<f32>,
    id: u32,
}

const NORMAL_STEPS = 1023.0;

// Octahedral map of a unit vector into the square: Cigolle et al., "A Survey of Efficient Representations for
// Independent Unit Vectors" (JCGT 2014), section 3.
fn fold(p: vec2<f32>) -> vec2<f32> {
    return (1.0 - abs(p.yx)) * select(vec2(-1.0), vec2(1.0), p >= vec2(0.0));
}

fn pack_surface(surface: Surface, sampled: bool) -> vec2<u32> {
    let n = surface.normal;
    let p = n.xy / max(abs(n.x) + abs(n.y) + abs(n.z), 1e-6);
    let square = select(fold(p), p, n.z >= 0.0);
    let steps = vec2<u32>(vec2<i32>(round(clamp(square, vec2(-1.0), vec2(1.0)) * NORMAL_STEPS)) + 1023);
    let depth = select(-surface.depth, surface.depth, sampled);
    return vec2(bitcast<u32>(depth), steps.x | (steps.y << 11u) | (surface.id << 22u));
}

fn depth_of(packed: vec2<u32>) -> f32 {
    return abs(bitcast<f32>(packed.x));
}

fn is_sampled(packed: vec2<u32>) -> bool {
    return bitcast<f32>(packed.x) > 0.0;
}

fn id_of(packed: vec2<u32>) -> u32 {
    return packed.y >> 22u;
}

fn normal_of(packed: vec2<u32>) -> vec3<f32> {
    let steps = vec2(packed.y & 0x7ffu, (packed.y >> 11u) & 0x7ffu);
    let p = vec2<f32>(vec2<i32>(steps) - 1023) / NORMAL_STEPS;
    let z = 1.0 - abs(p.x) - abs(p.y);
    return normalize(vec3(select(fold(p), p, z >= 0.0), z));
}

// `normal` as it is in the G-buffer; `id` of any 32 bits, spread over 10 by its product with 2^32 / the golden ratio.
fn surface_of(depth: f32, normal: vec3<f32>, id: u32) -> Surface {
    let length2 = dot(normal, normal);
    let usable = is_finite(length2) && length2 > 1e-12;
    return Surface(depth, select(vec3(0.0, 0.0, 1.0), normalize(normal), usable), (id * 0x9e3779b1u) >> 22u);
}
