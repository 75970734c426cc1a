// The surface at a hit: geometry, material, emission.

struct Surface {
    position: vec3f,
    // Both face the viewer.
    geometric_normal: vec3f,
    normal: vec3f,
    base_color: vec3f,
    metallic: f32,
    roughness: f32,
    specular: f32,
    emission: vec3f,
    // Density per area with which next-event estimation chooses this point; 0 where it never does.
    light_pdf: f32,
}

// `cone_width` is the ray's footprint at the hit, for the images' level of detail.
// Source: Akenine-Moeller et al., "Texture Level of Detail Strategies for Real-Time Ray Tracing", RTG 2019, 20.3.
fn load_surface(hit: Hit, direction: vec3f, cone_width: f32) -> Surface {
    var surface: Surface;
    let triangle = load_triangle(hit.triangle);
    let material = triangle_material(triangle.v0.w);
    let to_world = world_from_object(hit.instance);
    let to_object = object_from_world(hit.instance);
    let w = vec3f(1.0 - hit.weights.x - hit.weights.y, hit.weights);

    let object_position = triangle.v0.xyz + triangle.e1.xyz * w.y + triangle.e2.xyz * w.z;
    surface.position = transform_point(to_world, object_position);

    let outward = normalize(transform_normal(to_object, cross(triangle.e1.xyz, triangle.e2.xyz)));
    let is_front = dot(outward, direction) < 0.0;
    surface.geometric_normal = select(-outward, outward, is_front);

    let n0 = load_corner(hit.triangle, 0u);
    let n1 = load_corner(hit.triangle, 1u);
    let n2 = load_corner(hit.triangle, 2u);
    let t0 = load_corner(hit.triangle, 3u);
    let t1 = load_corner(hit.triangle, 4u);
    let t2 = load_corner(hit.triangle, 5u);
    let uv = vec2f(n0.w, t0.w) * w.x + vec2f(n1.w, t1.w) * w.y + vec2f(n2.w, t2.w) * w.z;
    var normal = normalize(transform_normal(to_object, n0.xyz * w.x + n1.xyz * w.y + n2.xyz * w.z));

    // Footprint in uv, by the triangle's uv per world length. Half way between the projected footprint's short
    // and long side: the long one would blur every floor.
    let e1 = transform_vector(to_world, triangle.e1.xyz);
    let e2 = transform_vector(to_world, triangle.e2.xyz);
    let d1 = vec2f(n1.w, t1.w) - vec2f(n0.w, t0.w);
    let d2 = vec2f(n2.w, t2.w) - vec2f(n0.w, t0.w);
    let uv_per_length = sqrt(abs(d1.x * d2.y - d1.y * d2.x) / max(length(cross(e1, e2)), 1e-20));
    let facing = max(abs(dot(outward, direction)), 0.05);
    let level = image_level(uv_per_length * cone_width / sqrt(facing));

    let layers = load_material(material, 3u);
    let factors = load_material(material, 1u);
    surface.base_color = load_material(material, 0u).xyz;
    if layers[BASE_COLOR] >= 0.0 {
        surface.base_color *= sample_color(layers[BASE_COLOR], image_uv(material, BASE_COLOR, uv), level).xyz;
    }
    surface.metallic = factors.x;
    surface.roughness = factors.y;
    surface.specular = factors.w;
    if layers[METALLIC_ROUGHNESS] >= 0.0 {
        let image = sample_data(layers[METALLIC_ROUGHNESS], image_uv(material, METALLIC_ROUGHNESS, uv), level);
        surface.roughness *= image.y;
        surface.metallic *= image.z;
    }
    if layers[NORMAL] >= 0.0 {
        let image = sample_data(layers[NORMAL], image_uv(material, NORMAL, uv), level).xyz * 2.0 - 1.0;
        let scaled = image * vec3f(vec2f(load_material(material, 4u).x), 1.0);
        let object_tangent = t0.xyz * w.x + t1.xyz * w.y + t2.xyz * w.z;
        let tangent = transform_vector(to_world, object_tangent);
        let across = tangent - normal * dot(normal, tangent);
        if dot(across, across) > 1e-12 {
            let bitangent = cross(normal, normalize(across)) * triangle.e2.w;
            normal = normalize(normalize(across) * scaled.x + bitangent * scaled.y + normal * max(scaled.z, 1e-3));
        }
    }
    surface.normal = face_viewer(select(-normal, normal, is_front), surface.geometric_normal, direction);

    let emissive = load_material(material, 2u);
    surface.emission = vec3f(0.0);
    surface.light_pdf = 0.0;
    if any(emissive.xyz > vec3f(0.0)) && (is_front || emissive.w > 0.0) {
        let now = load_frame(frame.material_frame_offset + material);
        surface.emission = emissive.xyz * now.x;
        surface.light_pdf = now.y;
        if layers[EMISSIVE] >= 0.0 {
            surface.emission *= sample_color(layers[EMISSIVE], image_uv(material, EMISSIVE, uv), level).xyz;
        }
    }
    return surface;
}

// A shading normal that is seen from behind is turned until it is seen edge-on; one that points into the surface
// until it does not. Both come of interpolation and normal images, not of the shape.
fn face_viewer(normal: vec3f, geometric_normal: vec3f, direction: vec3f) -> vec3f {
    var n = normal;
    let out = dot(n, geometric_normal);
    if out < 0.0 {
        n = normalize(n - geometric_normal * (out - 1e-3));
    }
    let facing = -dot(n, direction);
    if facing < 1e-3 {
        n = normalize(n - direction * (1e-3 - facing));
    }
    return n;
}

fn diffuse_color(surface: Surface) -> vec3f {
    return surface.base_color * (1.0 - surface.metallic);
}

// Reflectance at normal incidence.
fn specular_color(surface: Surface) -> vec3f {
    return mix(vec3f(0.04 * surface.specular), surface.base_color, surface.metallic);
}
