// Lights: emissive triangles, the sun, punctual lights and the sky.

struct LightSample {
    direction: vec3f,
    distance: f32,
    // Without visibility.
    radiance: vec3f,
    // Per solid angle, choice of the light included. Of a light without extent: the choice alone.
    pdf: f32,
    is_delta: bool,
}

fn sky_radiance(direction: vec3f) -> vec3f {
    let up = direction.y;
    return mix(frame.sky_horizon.xyz, select(frame.sky_ground.xyz, frame.sky_zenith.xyz, up > 0.0), sqrt(abs(up)));
}

fn is_in_sun(direction: vec3f) -> bool {
    let d = direction - frame.sun_direction.xyz;
    // |a - b|^2 = 2 (1 - cos), which keeps the digits that the cosine of a small angle loses.
    return frame.sun_radiance.w > 0.0 && dot(d, d) < 2.0 * frame.sun_direction.w;
}

// Density with which `sample_light` finds the sun.
fn sun_pdf() -> f32 {
    return frame.light_choice.y * frame.sun_radiance.w;
}

// Density per solid angle of a point on an emitter, from its density per area.
fn emitter_pdf(area_pdf: f32, distance: f32, cosine: f32) -> f32 {
    return frame.light_choice.x * area_pdf * distance * distance / max(cosine, 1e-6);
}

fn sample_light(position: vec3f) -> LightSample {
    let choice = random();
    let u = random2();
    if choice < frame.light_choice.x {
        return sample_emitter(position, u);
    }
    if choice < frame.light_choice.x + frame.light_choice.y {
        return sample_sun(u);
    }
    return sample_punctual(position, u.x);
}

fn sample_emitter(position: vec3f, u: vec2f) -> LightSample {
    var light = LightSample(vec3f(0.0, 1.0, 0.0), 0.0, vec3f(0.0), 0.0, false);
    // Alias table (Walker 1974): a column is chosen evenly, then one of its two emitters.
    let column = min(u32(random() * f32(frame.light_count)), frame.light_count - 1u);
    var entry = load_frame(frame.light_offset + column);
    if random() >= entry.z {
        entry = load_frame(frame.light_offset + u32(entry.w));
    }
    let r = sqrt(u.x);
    let hit = Hit(0.0, vec2f(r * (1.0 - u.y), r * u.y), u32(entry.x), u32(entry.y));
    let triangle = load_triangle(hit.triangle);
    let to_world = world_from_object(hit.instance);
    let local = triangle.v0.xyz + triangle.e1.xyz * hit.weights.x + triangle.e2.xyz * hit.weights.y;
    let towards = transform_point(to_world, local) - position;
    light.distance = length(towards);
    light.direction = towards / max(light.distance, 1e-20);
    let outward = transform_normal(object_from_world(hit.instance), cross(triangle.e1.xyz, triangle.e2.xyz));
    let cosine = -dot(normalize(outward), light.direction);

    let material = triangle_material(triangle.v0.w);
    let emissive = load_material(material, 2u);
    if cosine <= 0.0 && emissive.w == 0.0 {
        return light;
    }
    let now = load_frame(frame.material_frame_offset + material);
    light.radiance = emissive.xyz * now.x;
    let layer = load_material(material, 3u)[EMISSIVE];
    if layer >= 0.0 {
        let uvs = triangle_uvs(hit.triangle);
        let w = hit.weights;
        let uv = uvs[0] * (1.0 - w.x - w.y) + uvs[1] * w.x + uvs[2] * w.y;
        light.radiance *= sample_color(layer, image_uv(material, EMISSIVE, uv), 0.0).xyz;
    }
    light.pdf = emitter_pdf(now.y, light.distance, abs(cosine));
    return light;
}

fn sample_sun(u: vec2f) -> LightSample {
    let fall = u.x * frame.sun_direction.w;
    let r = sqrt(fall * (2.0 - fall));
    let angle = 2.0 * PI * u.y;
    let direction = basis(frame.sun_direction.xyz) * vec3f(r * cos(angle), r * sin(angle), 1.0 - fall);
    return LightSample(direction, FAR, frame.sun_radiance.xyz, sun_pdf(), false);
}

fn sample_punctual(position: vec3f, u: f32) -> LightSample {
    let index = min(u32(u * f32(frame.punctual_count)), frame.punctual_count - 1u);
    let first = frame.punctual_offset + index * PUNCTUAL_TEXELS;
    let place = load_frame(first);
    let axis = load_frame(first + 1u);
    let intensity = load_frame(first + 2u).xyz;
    let choice = frame.light_choice.z / f32(frame.punctual_count);
    if place.w == 0.0 {
        return LightSample(-axis.xyz, FAR, intensity, choice, true);
    }
    let towards = place.xyz - position;
    let distance = length(towards);
    let direction = towards / max(distance, 1e-20);
    var falloff = 1.0 / max(distance * distance, 1e-12);
    // The range's window and the spot's cone as KHR_lights_punctual recommends them.
    let reach = distance / axis.w;
    falloff *= clamp(1.0 - reach * reach * reach * reach, 0.0, 1.0);
    let cone = load_frame(first + 3u);
    let edge = clamp(-dot(axis.xyz, direction) * cone.x + cone.y, 0.0, 1.0);
    return LightSample(direction, distance, intensity * (falloff * edge * edge), choice, true);
}
