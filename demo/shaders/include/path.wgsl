// Paths from the camera's first hit on. Whoever includes this binds `listed` and `sample_count`, and says by `const SPLIT` whether the path's radiance is also told
// apart by lobe; where it is not, that costs nothing.
// Source: Veach 1997, chapters 8 to 10 (path tracing, multiple importance sampling with the power heuristic,
//         Russian roulette)

const LIGHTS_ONLY: u32 = 1u;
const BSDF_ONLY: u32 = 2u;
// Bounces before Russian roulette may end a path.
const SURE_BOUNCES: u32 = 2u;
// A rough bounce widens the footprint that images are read with; a smooth one keeps it. In radians.
const ROUGH_SPREAD: f32 = 0.1;

// What the paths of a pixel begin with.
struct Start {
    pixel: vec2u,
    count: u32,
    direction: vec3f,
    hit: Hit,
}

// The pixel at a place of the list.
fn start_at(place: u32) -> Start {
    let pixel = vec2u(listed[place] & 0xffffu, listed[place] >> 16u);
    let count = textureLoad(sample_count, pixel, 0).x;
    seed_random(pixel, frame.frame_index, frame.seed);
    let direction = camera_direction(sample_position_px(pixel));
    return Start(pixel, count, direction, primary_hit(pixel, direction));
}

// What a path brings to the camera.
struct Path {
    radiance: vec3f,
    // The same, split: what left the first hit through its specular lobe, and the rest. Only where `SPLIT`.
    rest: vec3f,
    specular: vec3f,
    // From the first hit to the next; 0 where that direction was not drawn from the specular lobe.
    hit_distance: f32,
}

// Parts of 1, per channel. Each direction is shared by what the lobes reflect of it, whichever of them it was drawn from: that
// is exact, and has less noise.
struct Shares {
    rest: vec3f,
    specular: vec3f,
}

struct DirectLight {
    radiance: vec3f,
    shares: Shares,
}

fn shares_of(reflected: Reflected) -> Shares {
    let all = max(reflectance(reflected), vec3f(1e-30));
    return Shares(reflected.diffuse / all, reflected.specular / all);
}

fn add(path: ptr<function, Path>, radiance: vec3f, shares: Shares) {
    (*path).radiance += radiance;
    if SPLIT {
        (*path).rest += radiance * shares.rest;
        (*path).specular += radiance * shares.specular;
    }
}

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
fn direct_light(seen: Surface, bsdf: Bsdf, world: mat3x3f, out: vec3f) -> DirectLight {
    let none = DirectLight(vec3f(0.0), Shares(vec3f(0.0), vec3f(0.0)));
    let light = sample_light(seen.position);
    let reaches = light.pdf > 0.0 && dot(light.direction, seen.geometric_normal) > 0.0;
    let skipped = frame.strategy == BSDF_ONLY && !light.is_delta;
    if !reaches || skipped {
        return none;
    }
    let reflected = evaluate_bsdf(bsdf, out, light.direction * world);
    var contribution = reflectance(reflected) * light.radiance / light.pdf;
    if !light.is_delta && frame.strategy != LIGHTS_ONLY {
        contribution *= power_heuristic(light.pdf, reflected.pdf);
    }
    if all(contribution <= vec3f(0.0)) {
        return none;
    }
    let origin = leave_surface(seen.position, seen.geometric_normal);
    // Stops short of the light, whose own surface would hide it.
    let visible = is_visible(origin, light.direction, light.distance * 0.9995);
    return DirectLight(select(vec3f(0.0), contribution, visible), shares_of(reflected));
}

fn trace_path(primary: Hit, primary_direction: vec3f) -> Path {
    var path = Path(vec3f(0.0), vec3f(0.0), vec3f(0.0), 0.0);
    var throughput = vec3f(1.0);
    // How the first hit's lobes share what comes along the path; what is seen directly is of neither.
    var shares = Shares(vec3f(1.0), vec3f(0.0));
    var pdf = 1.0;
    var hit = primary;
    var direction = primary_direction;
    var cone_width = 0.0;
    var cone_spread = frame.light_choice.w;
    for (var bounce = 0u; ; bounce++) {
        if hit.distance >= FAR {
            add(&path, throughput * sky_radiance(direction), shares);
            if is_in_sun(direction) {
                let sun = throughput * frame.sun_radiance.xyz * found_weight(bounce, pdf, sun_pdf());
                add(&path, sun, shares);
            }
            break;
        }
        cone_width += cone_spread * hit.distance;
        let seen = load_surface(hit, direction, cone_width);
        if any(seen.emission > vec3f(0.0)) {
            let cosine = abs(dot(seen.geometric_normal, direction));
            let light_pdf = emitter_pdf(seen.light_pdf, hit.distance, cosine);
            add(&path, throughput * seen.emission * found_weight(bounce, pdf, light_pdf), shares);
        }
        if bounce >= frame.max_bounces {
            break;
        }

        let world = basis(seen.normal);
        let out = -direction * world;
        let bsdf = make_bsdf(seen, out.z);
        if dot(frame.light_choice.xyz, vec3f(1.0)) > 0.0 {
            let direct = direct_light(seen, bsdf, world, out);
            if bounce == 0u {
                add(&path, throughput * direct.radiance, direct.shares);
            } else {
                add(&path, throughput * direct.radiance, shares);
            }
        }

        let sampled = sample_bsdf(bsdf, out);
        let reflected = evaluate_bsdf(bsdf, out, sampled.into);
        direction = normalize(world * sampled.into);
        if reflected.pdf <= 0.0 || dot(direction, seen.geometric_normal) <= 0.0 {
            break;
        }
        pdf = reflected.pdf;
        throughput *= reflectance(reflected) / pdf;
        if bounce >= SURE_BOUNCES {
            let survival = min(max(throughput.x, max(throughput.y, throughput.z)), 0.95);
            if random() >= survival {
                break;
            }
            throughput /= survival;
        }
        cone_spread = max(cone_spread, ROUGH_SPREAD * (1.0 - bsdf.choose_specular * (1.0 - bsdf.alpha)));
        hit = intersect(leave_surface(seen.position, seen.geometric_normal), direction, FAR, false);
        if SPLIT && bounce == 0u {
            shares = shares_of(reflected);
            path.hit_distance = select(0.0, hit.distance, sampled.is_specular);
        }
    }
    return path;
}
