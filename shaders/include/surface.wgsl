// The guide image: what is known of the surface behind a pixel, in two words.

struct Surface {
    normal: vec3<f32>,
    depth: f32,            // linear view depth; 0 is a miss
    cue: f32,              // 0.1 / luminance of the demodulator; of the specular signal, nearness (include/reflection); of the
                           // rest of a split, 0
    roughness: f32,
    id: u32,               // hashed to 10 bits
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

const IDS = 1024u;                  // that are told apart

// Bits of the two words, from the lowest: normal 11 + 11, id 10; roughness 5, cue 7, depth 20.
fn pack_surface(s: Surface) -> vec2<u32> {
    let normal = vec2<u32>(vec2<i32>(round(octahedral_encode(s.normal) * 1023.0)) + 1023);
    let roughness = u32(round(s.roughness * 31.0));
    let cue = u32(round(sqrt(saturate(s.cue)) * 127.0));
    return vec2(
        normal.x | (normal.y << 11u) | (s.id << 22u),
        roughness | (cue << 5u) | (pack_depth(s.depth) << 12u),
    );
}

fn unpack_surface(words: vec2<u32>) -> Surface {
    let normal = vec2<i32>(vec2(words.x & 2047u, (words.x >> 11u) & 2047u)) - 1023;
    let cue = f32((words.y >> 5u) & 127u) / 127.0;
    return Surface(
        octahedral_decode(vec2<f32>(normal) / 1023.0),
        unpack_depth(words.y >> 12u),
        cue * cue,
        f32(words.y & 31u) / 31.0,
        words.x >> 22u,
    );
}

// A float of 7 exponent and 13 mantissa bits, 2^-64 to 2^64: off by at most 1/16384 of itself. Code 0 is a miss.
const DEPTH_BIAS = 63u << 13u;

fn pack_depth(depth: f32) -> u32 {
    let code = (bitcast<u32>(depth) + 512u) >> 10u;
    return select(0u, clamp(code, DEPTH_BIAS + 1u, DEPTH_BIAS + 0xfffffu) - DEPTH_BIAS, depth > 0.0);
}

fn unpack_depth(code: u32) -> f32 {
    return select(0.0, bitcast<f32>((code + DEPTH_BIAS) << 10u), code > 0u);
}

fn is_miss(s: Surface) -> bool {
    return s.depth <= 0.0;
}

const NORMAL_COSINE = 0.9;    // about 25 degrees: what a shading normal varies by on one smooth surface
const PLANE_DISTANCE = 0.01;  // of the view depth

// Whether a point with `other_normal`, `distance` along `normal` from the one with `normal` and `depth`, may stand in for it: similar
// normal, within the tangent plane. That both have one id, and are no misses, is left to the caller.
fn continues(normal: vec3<f32>, depth: f32, other_normal: vec3<f32>, distance: f32, cosine: f32) -> bool {
    return dot(normal, other_normal) > cosine && abs(distance) < PLANE_DISTANCE * depth;
}

fn same_surface(a: Surface, b: Surface, distance: f32, cosine: f32) -> bool {
    return !is_miss(b) && a.id == b.id && continues(a.normal, a.depth, b.normal, distance, cosine);
}
