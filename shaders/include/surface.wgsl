// The guide image: what is known of the surface behind a pixel, in four words.

struct Surface {
    normal: vec3<f32>,
    depth: f32,            // linear view depth; 0 is a miss
    inverse_albedo: f32,   // q = 0.1 / luminance of the floored albedo
    roughness: f32,
    id: u32,
}

// Unit vector to the octahedron's square, -1..1. Source: Cigolle et al., "A Survey of Efficient Representations for
// Independent Unit Vectors", JCGT 2014.
fn octahedral_encode(n: vec3<f32>) -> vec2<f32> {
    let p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    let folded = (1.0 - abs(p.yx)) * select(vec2(-1.0), vec2(1.0), p >= vec2(0.0));
    return select(p, folded, n.z < 0.0);
}

fn octahedral_decode(e: vec2<f32>) -> vec3<f32> {
    let z = 1.0 - abs(e.x) - abs(e.y);
    let folded = (1.0 - abs(e.yx)) * select(vec2(-1.0), vec2(1.0), e >= vec2(0.0));
    return normalize(vec3(select(e, folded, z < 0.0), z));
}

const LARGEST_INVERSE_ALBEDO = 5.0; // 0.1 over the albedo floor

fn pack_surface(s: Surface) -> vec4<u32> {
    return vec4(
        pack2x16snorm(octahedral_encode(s.normal)),
        bitcast<u32>(s.depth),
        pack2x16unorm(vec2(s.inverse_albedo / LARGEST_INVERSE_ALBEDO, s.roughness)),
        s.id,
    );
}

fn unpack_surface(words: vec4<u32>) -> Surface {
    let material = unpack2x16unorm(words.z);
    return Surface(
        octahedral_decode(unpack2x16snorm(words.x)),
        bitcast<f32>(words.y),
        material.x * LARGEST_INVERSE_ALBEDO,
        material.y,
        words.w,
    );
}

fn is_miss(s: Surface) -> bool {
    return s.depth <= 0.0;
}

const NORMAL_COSINE = 0.9;    // about 25 degrees: what a shading normal varies by on one smooth surface
const PLANE_DISTANCE = 0.01;  // of the view depth

// Whether a point at `offset` may stand in for one with `normal` and `depth`: similar normal, within the tangent plane. That
// both have one id, and are no misses, is left to the caller.
fn continues(normal: vec3<f32>, depth: f32, other_normal: vec3<f32>, offset: vec3<f32>) -> bool {
    return dot(normal, other_normal) > NORMAL_COSINE && abs(dot(normal, offset)) < PLANE_DISTANCE * depth;
}

fn same_surface(a: Surface, b: Surface, offset: vec3<f32>) -> bool {
    return !is_miss(b) && a.id == b.id && continues(a.normal, a.depth, b.normal, offset);
}
