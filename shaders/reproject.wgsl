// reproject: packs this frame's inputs, fetches each pixel's history from where its surface was in the previous frame, and sums,
// per tile, the moments of what the new samples differ by from that history.
//
// Reads   the caller's images; the previous frame's guide; history, noise.
// Writes  guide: the surface; signal: this frame's sample (layouts: include/surface, include/signal)
//         reprojected: history mean, effective sample count in w (0: no history); at a miss its radiance; reprojected_noise
//         moments, of the change (layout: include/features)
// Source  bilinear taps tested one by one: Schied et al., "Spatiotemporal Variance-Guided Filtering", HPG 2017, section
//         4.1; cubic weights: Catmull and Rom 1974, as used for history in temporal anti-aliasing

//!include frame numbers noise surface signal demodulate inputs motion memory reflection features innovations tile_moments

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var radiance: texture_2d<f32>;
@group(0) @binding(2) var albedo: texture_2d<f32>;
@group(0) @binding(3) var normal_roughness: texture_2d<f32>;
@group(0) @binding(4) var roughness: texture_2d<f32>;
@group(0) @binding(5) var depth: texture_2d<f32>;
@group(0) @binding(6) var motion: texture_2d<f32>;
@group(0) @binding(7) var surface_id: texture_2d<u32>;
@group(0) @binding(8) var emission: texture_2d<f32>;
@group(0) @binding(9) var sample_count: texture_2d<u32>;
@group(0) @binding(10) var hit_distance: texture_2d<f32>;
@group(0) @binding(11) var previous_guide: texture_2d<u32>;
@group(0) @binding(12) var history: texture_2d<f32>;
@group(0) @binding(13) var noise: texture_2d<u32>;
@group(0) @binding(14) var guide: texture_storage_2d<rg32uint, write>;
@group(0) @binding(15) var signal: texture_storage_2d<r32uint, write>;
@group(0) @binding(16) var reprojected: texture_storage_2d<rg32uint, write>;
@group(0) @binding(17) var reprojected_noise: texture_storage_2d<r32uint, write>;
@group(0) @binding(18) var<storage, read_write> moments: array<vec4<f32>>;

const OWN_FEATURES = INNOVATION_OWN_FEATURES;

// Where the pixel's surface was: what a tap must look like to belong to it.
struct Origin {
    texel: vec2<f32>,       // pixel coordinates in the previous frame, centres at integers
    position: vec3<f32>,    // relative to the previous eye
    surface: Surface,
    tolerance: f32,         // distance from the tangent plane that passes
    nearness: f32,          // of what the specular signal shows there (include/reflection)
}

// A direction that a surface turned by in one frame passes; more is taken for another surface.
const REPROJECTED_NORMAL_COSINE = 0.8;
// Fewer valid bilinear taps than this are mostly another surface.
const LEAST_WEIGHT = 0.05;
const OFF_SCREEN = -8.0; // where there is no history
// Closer than this to a texel centre, resampling would only blur. Motion in half precision is no finer.
const SNAP_PX = 0.002;

@compute @workgroup_size(8, 8)
fn reproject(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) tile: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    leave_out(lane);
    let is_inside = all(id.xy < frame.size);
    var follows = IS_SPECULAR;
    if HAS_REFLECTIONS {
        if is_inside && has(frame, FLAG_HISTORY) {
            weights[lane] = evidence_for_reflections(id.xy);
        }
        workgroupBarrier();
        follows = favours_reflections();
        workgroupBarrier();
        weights[lane] = 0.0;
    }
    if is_inside {
        enter_pixel(id.xy, lane, follows);
    }
    workgroupBarrier();
    if skip_tile(tile.xy, lane) {
        return;
    }
    sum_tile(tile.xy, lane);
}

// Of one signal, the tile's samples tell whether they are better explained by what their surfaces showed, or by what is seen in
// them: a vote of each pixel, from -1 to 1, by how far it beats its history's noise. The votes lie where the weights will.
fn evidence_for_reflections(pixel: vec2<u32>) -> f32 {
    let surface = read_surface(pixel);
    let sample = read_sample(pixel, surface);
    if sample.count == 0.0 {
        return 0.0;
    }
    let position = position_of(frame.current, vec2<f32>(pixel), surface.depth);
    let reflection = reflection_at(pixel, surface, position);
    let origin = find_origin(pixel, unpack_surface(pack_surface(surface)));
    let shown = fetch(origin);
    let seen = fetch(find_reflected_origin(pixel, origin, position, reflection));
    if shown.history.w > 0.0 && seen.history.w > 0.0 {
        let off_shown = luminance(sample.signal) - luminance(shown.history.rgb);
        let off_seen = luminance(sample.signal) - luminance(seen.history.rgb);
        let squares = vec2(off_shown * off_shown, off_seen * off_seen);
        return (squares.x - squares.y) / max(shown.noise.variance + squares.x + squares.y, 1e-12);
    }
    return 0.0;
}

fn favours_reflections() -> bool {
    var sum = 0.0;
    for (var lane = 0u; lane < TILE * TILE; lane++) {
        sum += weights[lane];
    }
    return sum >= 0.0; // of equal ones the reflected history is the longer
}

fn enter_pixel(pixel: vec2<u32>, lane: u32, follows: bool) {
    var seen = read_surface(pixel);
    let position = position_of(frame.current, vec2<f32>(pixel), seen.depth);
    var reflection: Reflection;
    if IS_SPECULAR | HAS_REFLECTIONS {
        if follows && has(frame, FLAG_HIT_DISTANCE) && !is_miss(seen) {
            reflection = reflection_at(pixel, seen, position);
        }
    }
    if IS_SPECULAR {
        if reflection.hit_distance <= 0.0 && has(frame, FLAG_HISTORY) && !is_miss(seen) {
            // Its surface as the guide will hold it.
            reflection.hit_distance = remembered_hit_distance(find_origin(pixel, unpack_surface(pack_surface(seen))));
        }
        seen.cue = nearness(ray_length(frame.current, position), reflection.hit_distance);
    }
    let words = pack_surface(seen);
    let surface = unpack_surface(words);
    textureStore(guide, pixel, vec4(words, 0u, 0u));
    let sample = read_sample(pixel, surface);
    let signal_word = select(NO_SAMPLE, pack_signal(sample.signal, pixel, 2u * frame.index), sample.count > 0.0);
    textureStore(signal, pixel, vec4(signal_word));
    var fetched = Fetched(vec4(0.0), Noise());
    if is_miss(surface) {
        fetched.history = vec4(read_miss(pixel), 0.0);
    } else if has(frame, FLAG_HISTORY) {
        fetched = fetch_signal(pixel, find_origin(pixel, surface), position, reflection, sample.count);
    }
    let mean = dither_to_half(fetched.history.rgb, pixel, 2u * frame.index);
    let old = vec2(pack2x16float(mean.rg), pack2x16float(vec2(mean.b, fetched.history.w)));
    let count = unpack2x16float(old.y).y;
    let old_noise = pack_noise(fetched.noise, count, pixel, 2u * frame.index);
    textureStore(reprojected, pixel, vec4(old, 0u, 0u));
    textureStore(reprojected_noise, pixel, vec4(old_noise));
    if sample.count > 0.0 && count > 0.0 {
        enter_change(pixel, surface, Sample(unpack_signal(signal_word), sample.count), vec4(mean, count), lane);
        let own = unpack_noise(old_noise, count);
        noises[lane] = vec3(own.variance, luminance(mean), count);
    }
}

// A pixel without samples or without history enters with weight 0.
fn enter_change(pixel: vec2<u32>, surface: Surface, sample: Sample, old: vec4<f32>, lane: u32) {
    let position = position_of(frame.current, vec2<f32>(pixel), surface.depth);
    own_row = row_of(surface_features(surface, position), sample.signal - old.rgb, vec2(0.0));
    weights[lane] = sample.count;
}

fn find_origin(pixel: vec2<u32>, surface: Surface) -> Origin {
    let size = frame.previous.size;
    let uv = (vec2<f32>(pixel) + 0.5) / frame.current.size;
    let moved = motion_at(pixel);
    let offset = moved.xy;
    let sampled_uv = uv + frame.current.jitter / frame.current.size;
    let still = position_at(frame.current, sampled_uv, surface.depth) + frame.eye_delta;
    var origin: Origin;
    origin.surface = surface;
    origin.tolerance = PLANE_DISTANCE * surface.depth;
    if !is_finite(offset.x) || !is_finite(offset.y) || any(abs(offset) > vec2(4.0)) {
        origin.texel = vec2(OFF_SCREEN);
        return origin;
    }
    origin.texel = (uv + offset) * size - 0.5;
    let nearest = round(origin.texel);
    if all(abs(origin.texel - nearest) < vec2(SNAP_PX)) {
        origin.texel = nearest;
    }
    // Depth in the previous frame: told, or that of a point that stood still, or (for something that moved on its own)
    // no better than the depth now, with room for error.
    var depth = surface.depth;
    let still_projected = project(frame.previous, still);
    if has(frame, FLAG_MOTION_DEPTH) && is_finite(moved.z) {
        depth += moved.z;
    } else if all(abs(still_projected.xy - (sampled_uv + offset)) * size < vec2(STILL_PX)) {
        depth = still_projected.z;
    } else {
        origin.tolerance *= 10.0;
    }
    origin.position = position_at(frame.previous, sampled_uv + offset, depth);
    return origin;
}

// Where hit distances are known, what is seen in the surface is followed, not the surface; that only where the other left no
// history, or where the lobe is too wide for the view of it to have turned. It then counts for no more than that.
fn fetch_signal(
    pixel: vec2<u32>,
    origin: Origin,
    position: vec3<f32>,
    reflection: Reflection,
    samples: f32,
) -> Fetched {
    if !(IS_SPECULAR | HAS_REFLECTIONS) { // a constant, other than by `||`
        return fetch(origin);
    }
    let frames = memory(origin.surface, position);
    let reflected = find_reflected_origin(pixel, origin, position, reflection);
    var fetched: Fetched;
    if reflected.texel.x > OFF_SCREEN && frames < frame.max_history {
        fetched = fetch(reflected);
    }
    if fetched.history.w <= 0.0 {
        var of_surface = origin;
        of_surface.nearness = nearness(ray_length(frame.previous, origin.position), reflection.hit_distance);
        fetched = fetch(of_surface);
        fetched.history.w = min(fetched.history.w, frames * max(samples, 1.0));
    }
    return fetched;
}

// Where what is seen in the surface was seen, off the screen where that is not known. What the surface moved by on its own moves it
// along.
fn find_reflected_origin(pixel: vec2<u32>, origin: Origin, position: vec3<f32>, reflection: Reflection) -> Origin {
    var reflected = origin;
    reflected.texel = vec2(OFF_SCREEN);
    if reflection.hit_distance <= 0.0 || origin.texel.x <= OFF_SCREEN {
        return reflected;
    }
    let reflector = previous_reflector(pixel, origin.surface, position, reflection);
    if !reflector.is_known {
        return reflected;
    }
    let moved = origin.texel - previous_texel(position);
    let own = select(moved, vec2(0.0), all(abs(moved) < vec2(STILL_PX)));
    let hit = position + reflection.towards * reflection.hit_distance;
    reflected.texel = previous_texel(reflector.position) + own;
    reflected.position = origin.position + reflector.position - position;
    reflected.surface.normal = reflector.normal;
    let eye_distance = ray_length(frame.previous, reflector.position + frame.eye_delta);
    reflected.nearness = nearness(eye_distance, length(hit - reflector.position));
    return reflected;
}

// Where a point that is given relative to the current eye was, if it stood still.
fn previous_texel(position: vec3<f32>) -> vec2<f32> {
    let uv = project(frame.previous, position + frame.eye_delta).xy;
    return uv * frame.previous.size - frame.current.jitter * (frame.previous.size / frame.current.size) - 0.5;
}

// What the surface knew of the distance, where no ray of this frame tells.
fn remembered_hit_distance(origin: Origin) -> f32 {
    let texel = vec2<i32>(round(origin.texel));
    if !inside(texel, frame.previous) {
        return 0.0;
    }
    let tap = unpack_surface(textureLoad(previous_guide, texel, 0).xy);
    if is_miss(tap) || tap.id != origin.surface.id || tap.cue <= 0.0 {
        return 0.0;
    }
    return ray_length(frame.previous, origin.position) * (1.0 / tap.cue - 1.0);
}

// Motion by which a surface is told from one that stands still.
const STILL_PX = 0.5;
// Difference of nearness by which one reflected thing is told from another in a mirror, the rounding of the code included.
const NEARNESS_TOLERANCE = 0.01;

// The tangent plane of an origin, one for all taps. Where hit distances are followed, taps are compared with it by their positions
// instead, which takes longer and fewer registers: there none are left.
struct Plane {
    along: Elevation,
    level: f32,
}

fn plane_of(origin: Origin) -> Plane {
    var plane: Plane;
    plane.level = dot(origin.surface.normal, origin.position);
    if !HAS_REFLECTIONS {
        plane.along = elevation_along(frame.previous, origin.surface.normal);
    }
    return plane;
}

fn off_plane(plane: Plane, normal: vec3<f32>, texel: vec2<f32>, depth: f32) -> f32 {
    if HAS_REFLECTIONS {
        return dot(normal, position_of(frame.previous, texel, depth)) - plane.level;
    }
    return elevation_of(plane.along, texel, depth) - plane.level;
}

fn tap_belongs(texel: vec2<i32>, origin: Origin, plane: Plane) -> bool {
    if !inside(texel, frame.previous) {
        return false;
    }
    let tap = unpack_surface(textureLoad(previous_guide, texel, 0).xy);
    if is_miss(tap) || tap.id != origin.surface.id {
        return false;
    }
    if IS_SPECULAR {
        // A rough surface shows many things at once.
        let is_other = abs(origin.nearness - tap.cue) > NEARNESS_TOLERANCE + tap.roughness;
        if is_other && origin.nearness > 0.0 && tap.cue > 0.0 {
            return false;
        }
    }
    let normal = origin.surface.normal;
    let distance = off_plane(plane, normal, vec2<f32>(texel), tap.depth);
    return dot(tap.normal, normal) > REPROJECTED_NORMAL_COSINE && abs(distance) < origin.tolerance;
}

struct Fetched {
    history: vec4<f32>,
    noise: Noise,
}

// Bilinear where a tap does not belong; otherwise cubic, from the twelve of 4x4 taps that are not in the corners, which weigh
// 1.6 % at most.
fn fetch(origin: Origin) -> Fetched {
    let base = vec2<i32>(floor(origin.texel));
    let f = origin.texel - floor(origin.texel);
    let cubic = array(catmull_rom_weights(f.x), catmull_rom_weights(f.y));
    let plane = plane_of(origin);
    var plain = Fetched(vec4(0.0), Noise());
    var weight = 0.0;
    var sharp = Fetched(vec4(0.0), Noise()); // the deviations take the same weights as the mean, whose noise they stand for
    var range = vec2(HALF_MAX, 0.0);         // of the inner taps' luminance
    var is_whole = !has(frame, FLAG_BILINEAR) && is_between_texels(f); // all taps belong to the surface and have samples
    for (var i = 0; i < INNER_TAPS || (is_whole && i < TAPS); i++) {
        let step = tap_step(i);
        let w = cubic_weight(cubic[0], step.x) * cubic_weight(cubic[1], step.y);
        if w == 0.0 {
            continue;
        }
        let texel = base + step;
        let mean = textureLoad(history, texel, 0); // any value outside of the frame, where no tap belongs
        // One that was never sampled has a surface but no mean.
        if mean.w <= 0.0 || !tap_belongs(texel, origin, plane) {
            is_whole = false;
            continue;
        }
        let noise = unpack_noise(textureLoad(noise, texel, 0).x, mean.w);
        sharp.history += w * mean;
        sharp.noise.deviations += w * noise.deviations;
        if i < INNER_TAPS {
            let sides = select(1.0 - f, f, step == vec2(1));
            let share = sides.x * sides.y;
            plain.history += share * mean;
            plain.noise.variance += share * noise.variance;
            plain.noise.deviations += share * noise.deviations;
            weight += share;
            let l = luminance(mean.rgb);
            range = vec2(min(range.x, l), max(range.y, l));
        }
    }
    // 0 is no history.
    let inverse = select(0.0, 1.0 / weight, weight >= LEAST_WEIGHT);
    var fetched = Fetched(inverse * plain.history, Noise(inverse * plain.noise.variance, inverse * plain.noise.deviations));
    let total = 1.0 - (cubic[0].x + cubic[0].w) * (cubic[1].x + cubic[1].w);
    // Negative lobes ring next to something bright. What is far below all taps holds no colour to brighten.
    let l = luminance(sharp.history.rgb) / total;
    if is_whole && l >= 0.5 * range.x {
        let mean = max(sharp.history.rgb, vec3(0.0)) / total;
        fetched.history = vec4(mean * (clamp(l, range.x, range.y) / max(l, 1e-30)), fetched.history.w);
        fetched.noise.deviations = sharp.noise.deviations / total;
    }
    return fetched;
}

// A function, so that tests/cost can leave it out of still views.
fn is_between_texels(f: vec2<f32>) -> bool {
    return any(f > vec2(0.0));
}

const INNER_TAPS = 4;
const TAPS = 12;

// Four inner taps, then two on each side.
fn tap_step(i: i32) -> vec2<i32> {
    if i < INNER_TAPS {
        return vec2(i & 1, i >> 1u);
    }
    let outer = vec2(3 * ((i >> 1u) & 1) - 1, i & 1);
    return select(outer, outer.yx, i >= INNER_TAPS + 4);
}

// Of the tap at -1, 0, 1 or 2.
fn cubic_weight(weights: vec4<f32>, at: i32) -> f32 {
    return select(select(weights.x, weights.y, at == 0), select(weights.z, weights.w, at == 2), at > 0);
}

fn catmull_rom_weights(f: f32) -> vec4<f32> {
    let f2 = f * f;
    let f3 = f2 * f;
    return 0.5 * vec4(
        -f3 + 2.0 * f2 - f,
        3.0 * f3 - 5.0 * f2 + 2.0,
        -3.0 * f3 + 4.0 * f2 + f,
        f3 - f2,
    );
}
