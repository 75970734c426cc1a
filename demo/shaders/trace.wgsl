// trace: radiance that arrives at each pixel, by path tracing.
//
// Reads:  the scene, the frame, hits, sample_count; listed and work (see plan): the pixels that get any
// Writes: radiance (mean of the frame's samples)
// Source: Veach 1997, chapters 8 to 10 (path tracing, multiple importance sampling with the power heuristic,
//         Russian roulette)

//!include scene
//!include images
//!include random
//!include intersect
//!include camera
//!include surface
//!include bsdf
//!include lights
//!include primary

@group(2) @binding(1) var radiance_out: texture_storage_2d<rgba32float, write>;
@group(2) @binding(2) var sample_count: texture_2d<u32>;
@group(2) @binding(3) var<storage, read> listed: array<u32>;
@group(2) @binding(4) var<storage, read> work: array<u32>;

const LIGHTS_ONLY: u32 = 1u;
const BSDF_ONLY: u32 = 2u;
// Bounces before Russian roulette may end a path.
const SURE_BOUNCES: u32 = 2u;
// A rough bounce widens the footprint that images are read with; a smooth one keeps it. In radians.
const ROUGH_SPREAD: f32 = 0.1;

// Weight of a sample that the technique with density `a` took and the one with density `b` might have taken.
fn power_heuristic(a: f32, b: f32) -> f32 {
    let ratio = b / max(a, 1e-20);
    return 1.0 / (1.0 + ratio * ratio);
}

// Weight of light that a ray found which the BSDF chose with density `pdf`.
fn found_weight(bounce: u32, pdf: f32, light_pdf: f32) -> f32 {
    if bounce == 0u || light_pdf <= 0.0 || frame.strategy == BSDF_ONLY {
        return 1.0;
    }
    return select(power_heuristic(pdf, light_pdf), 0.0, frame.strategy == LIGHTS_ONLY);
}

// Light that arrives straight from a light chosen at random, times the reflectance.
fn direct_light(seen: Surface, bsdf: Bsdf, world: mat3x3f, out: vec3f) -> vec3f {
    let light = sample_light(seen.position);
    let reaches = light.pdf > 0.0 && dot(light.direction, seen.geometric_normal) > 0.0;
    let skipped = frame.strategy == BSDF_ONLY && !light.is_delta;
    if !reaches || skipped {
        return vec3f(0.0);
    }
    let reflected = evaluate_bsdf(bsdf, out, light.direction * world);
    var contribution = reflected.xyz * light.radiance / light.pdf;
    if !light.is_delta && frame.strategy != LIGHTS_ONLY {
        contribution *= power_heuristic(light.pdf, reflected.w);
    }
    if all(contribution <= vec3f(0.0)) {
        return vec3f(0.0);
    }
    let origin = leave_surface(seen.position, seen.geometric_normal);
    // Stops short of the light, whose own surface would hide it.
    let visible = is_visible(origin, light.direction, light.distance * 0.9995);
    return select(vec3f(0.0), contribution, visible);
}

fn trace_path(primary: Hit, primary_direction: vec3f) -> vec3f {
    var radiance = vec3f(0.0);
    var throughput = vec3f(1.0);
    var pdf = 1.0;
    var hit = primary;
    var direction = primary_direction;
    var cone_width = 0.0;
    var cone_spread = frame.light_choice.w;
    for (var bounce = 0u; ; bounce++) {
        if hit.distance >= FAR {
            radiance += throughput * sky_radiance(direction);
            if is_in_sun(direction) {
                radiance += throughput * frame.sun_radiance.xyz * found_weight(bounce, pdf, sun_pdf());
            }
            break;
        }
        cone_width += cone_spread * hit.distance;
        let seen = load_surface(hit, direction, cone_width);
        if any(seen.emission > vec3f(0.0)) {
            let cosine = abs(dot(seen.geometric_normal, direction));
            let light_pdf = emitter_pdf(seen.light_pdf, hit.distance, cosine);
            radiance += throughput * seen.emission * found_weight(bounce, pdf, light_pdf);
        }
        if bounce >= frame.max_bounces {
            break;
        }

        let world = basis(seen.normal);
        let out = -direction * world;
        let bsdf = make_bsdf(seen, out.z);
        if dot(frame.light_choice.xyz, vec3f(1.0)) > 0.0 {
            radiance += throughput * direct_light(seen, bsdf, world, out);
        }

        let into = sample_bsdf(bsdf, out);
        let reflected = evaluate_bsdf(bsdf, out, into);
        direction = normalize(world * into);
        if reflected.w <= 0.0 || dot(direction, seen.geometric_normal) <= 0.0 {
            break;
        }
        pdf = reflected.w;
        throughput *= reflected.xyz / pdf;
        if bounce >= SURE_BOUNCES {
            let survival = min(max(throughput.x, max(throughput.y, throughput.z)), 0.95);
            if random() >= survival {
                break;
            }
            throughput /= survival;
        }
        cone_spread = max(cone_spread, ROUGH_SPREAD * (1.0 - bsdf.choose_specular * (1.0 - bsdf.alpha)));
        hit = intersect(leave_surface(seen.position, seen.geometric_normal), direction, FAR, false);
    }
    return radiance;
}

@compute @workgroup_size(64)
fn trace(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) lane: u32) {
    let place = (group.y * WORK_COLUMNS + group.x) * TRACED_TOGETHER + lane;
    if place >= work[WORK_PIXELS] {
        return;
    }
    let pixel = vec2u(listed[place] & 0xffffu, listed[place] >> 16u);
    let count = textureLoad(sample_count, pixel, 0).x;
    seed_random(pixel, frame.frame_index, frame.seed);
    let direction = camera_direction(sample_position_px(pixel));
    let hit = primary_hit(pixel, direction);
    var sum = vec3f(0.0);
    for (var i = 0u; i < count; i++) {
        sum += trace_path(hit, direction);
    }
    textureStore(radiance_out, pixel, vec4f(sum / f32(count), 1.0));
}
