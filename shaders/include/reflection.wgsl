// Where what is seen in a surface was seen in the previous frame.
//
// A pass binds hit_distance, normal_roughness and depth.
// Source: light goes from eye to hit where the half vector is the normal; a Newton step along the surface to where that holds for
// another eye: Jakob and Marschner, "Manifold Exploration", SIGGRAPH 2012, section 4. On a plane this is the virtual image of a
// mirror, on a sphere the mirror equation. Highlights of rough lobes lie about the same point.

// What is known of the specular ray of a pixel.
struct Reflection {
    normal: vec3<f32>,      // of the surface, not rounded
    towards: vec3<f32>,     // unit vector to what is seen, of a mirror
    hit_distance: f32,      // 0: not known
}

const HITS = vec2(1e-3, 1e3); // view depths: what touches the surface, the sky

// Of a surface as `read_surface` gives it.
fn reflection_at(pixel: vec2<u32>, surface: Surface, position: vec3<f32>) -> Reflection {
    let towards = reflect(-towards_eye(frame.current, position), surface.normal);
    return Reflection(surface.normal, towards, known_hit_distance(pixel, surface, position));
}

fn hit_distance_at(pixel: vec2<i32>, surface: Surface) -> f32 {
    let found = textureLoad(hit_distance, frame.origin + vec2<u32>(pixel), 0).x;
    let range = HITS * surface.depth;
    // By its bits: infinity is far, NaN is not known.
    let is_known = found > 0.0 && (bitcast<u32>(found) & 0x7fffffffu) <= 0x7f800000u;
    let is_sky = !is_finite(found) || found >= frame.far;
    return select(0.0, select(clamp(found, range.x, range.y), range.y, is_sky), is_known);
}

// Mean over what the lobe takes in, as far as that is 3x3 pixels: a ray is one sample of it. Motion is linear in the inverse.
fn known_hit_distance(pixel: vec2<u32>, surface: Surface, position: vec3<f32>) -> f32 {
    let pixel_width = 2.0 * mix(1.0, surface.depth, frame.current.perspective) / (abs(frame.current.scale.y) * frame.current.size.y);
    let own = hit_distance_at(vec2<i32>(pixel), surface);
    var sum = vec2(0.0);
    for (var i = 0; i < 9; i++) {
        let texel = vec2<i32>(pixel) + vec2(i % 3 - 1, i / 3 - 1);
        if inside(texel, frame.current) {
            let found = hit_distance_at(texel, surface);
            let other = neighbour_at(texel);
            let distance = dot(surface.normal, other.position - position);
            let is_alike = continues(surface.normal, surface.depth, other.normal, distance, NORMAL_COSINE);
            if found > 0.0 && other.is_hit && is_alike {
                let share = saturate(2.0 * surface.roughness * surface.roughness * found / pixel_width - 1.0);
                sum += select(share, 1.0, i == 4 || own <= 0.0) * vec2(1.0 / found, 1.0);
            }
        }
    }
    return sum.y / max(sum.x, 1e-30) * select(0.0, 1.0, sum.y > 0.0);
}

struct Neighbour {
    normal: vec3<f32>,
    position: vec3<f32>,
    is_hit: bool,
}

fn neighbour_at(texel: vec2<i32>) -> Neighbour {
    let pixel = vec2<u32>(texel);
    let normal = decode_normal(textureLoad(normal_roughness, frame.origin + pixel, 0).xyz);
    let found = view_depth_at(pixel);
    return Neighbour(normal, position_of(frame.current, vec2<f32>(texel), found), found > 0.0);
}

// Columns span the tangent plane. Source: Duff et al., "Building an Orthonormal Basis, Revisited", JCGT 2017
fn tangents(n: vec3<f32>) -> mat2x3<f32> {
    let side = select(-1.0, 1.0, n.z >= 0.0);
    let a = -1.0 / (side + n.z);
    let b = n.x * n.y * a;
    return mat2x3(1.0 + side * n.x * n.x * a, side * b, -side * n.x, b, side + n.y * n.y * a, -n.y);
}

const CURVATURE_STEP = 2;  // pixels: normals are rounded
const LEAST_SPREAD = 1e-3; // of the neighbours, in a direction that counts

// How the normal turns along the surface, in the basis of the tangents: positive where it bulges towards the viewer. Least squares
// over the neighbours; 0 along a direction in which there is none.
fn curvature_at(pixel: vec2<u32>, surface: Surface, position: vec3<f32>, normal: vec3<f32>, basis: mat2x3<f32>) -> mat2x2<f32> {
    var products = mat2x2<f32>();
    var squares = mat2x2<f32>();
    for (var i = 0; i < 4; i++) {
        let side = (i & 2) - 1;
        let texel = vec2<i32>(pixel) + CURVATURE_STEP * select(vec2(0, side), vec2(side, 0), (i & 1) == 0);
        if inside(texel, frame.current) {
            let other = neighbour_at(texel);
            let offset = other.position - position;
            let distance = dot(surface.normal, offset);
            if other.is_hit && continues(surface.normal, surface.depth, other.normal, distance, NORMAL_COSINE) {
                let turn = (other.normal - normal) * basis;
                let along = offset * basis;
                products += mat2x2(turn * along.x, turn * along.y);
                squares += mat2x2(along * along.x, along * along.y);
            }
        }
    }
    let size = squares[0][0] + squares[1][1];
    if size <= 0.0 {
        return mat2x2<f32>();
    }
    let ridge = mat2x2(LEAST_SPREAD, 0.0, 0.0, LEAST_SPREAD);
    let turned = (products * (1.0 / size)) * inverse_of(squares * (1.0 / size) + ridge);
    let shear = 0.5 * (turned[0][1] + turned[1][0]);
    return mat2x2(turned[0][0], shear, shear, turned[1][1]);
}

fn inverse_of(m: mat2x2<f32>) -> mat2x2<f32> {
    return mat2x2(m[1][1], -m[0][1], -m[1][0], m[0][0]) * (1.0 / determinant(m));
}

// A point of the surface in the tangent plane's basis, and what it looks like.
struct Reflector {
    position: vec3<f32>, // relative to the current eye
    normal: vec3<f32>,
    is_known: bool,
}

const LEAST_BEND = 0.1; // of a flat mirror: concave ones are not followed to their focus

// Where on the surface the previous eye saw what is now seen in the pixel, if all stood still. Its hit distance is known.
fn previous_reflector(pixel: vec2<u32>, surface: Surface, position: vec3<f32>, seen: Reflection) -> Reflector {
    let normal = seen.normal;
    let basis = tangents(normal);
    let curvature = curvature_at(pixel, surface, position, normal, basis);
    let before = position + frame.eye_delta;
    let eye = towards_eye(frame.previous, before);
    let halfway = eye + seen.towards;
    let scale = 1.0 / max(length(halfway), 1e-6);
    // How the half vector turns along the surface, if it is flat.
    let eye_nearness = frame.previous.perspective / max(length(before), 1e-30);
    let flat = scale * (eye_nearness * perpendicular(eye * basis) + 1.0 / seen.hit_distance * perpendicular(seen.towards * basis));
    let bent = flat + curvature;
    if bent[0][0] + bent[1][1] <= 0.0 || !(determinant(bent) > LEAST_BEND * determinant(flat)) {
        return Reflector(position, surface.normal, false);
    }
    let step = inverse_of(bent) * (scale * (halfway * basis));
    let turn = curvature * step;
    let lifted = position + basis * step - 0.5 * dot(step, turn) * normal;
    return Reflector(lifted, normalize(normal + basis * turn), true);
}

// Projects on what is perpendicular to a unit vector, of which `v` is the part in the tangent plane.
fn perpendicular(v: vec2<f32>) -> mat2x2<f32> {
    return mat2x2(1.0 - v.x * v.x, -v.x * v.y, -v.x * v.y, 1.0 - v.y * v.y);
}

// Distance of the eye over that and the distance of the hit: 1 for what touches the surface, next to 0 for the sky; 0 where the hit
// is not known.
fn nearness(eye_distance: f32, hit_distance: f32) -> f32 {
    return select(0.0, eye_distance / max(eye_distance + hit_distance, 1e-30), hit_distance > 0.0);
}
