// antialias: temporal antialiasing of any method's output on a jittered camera.
//
// Reads:  an image, motion and depth of this frame; what this pass wrote for the previous one.
// Writes: the image, antialiased; binary logarithm of view depth in alpha, for the next frame.
// Source: Karis, "High Quality Temporal Supersampling" (SIGGRAPH courses 2014): motion of the nearest neighbour, sharp
//         history, tonemapped YCoCg. Salvi, "An Excursion in Temporal Supersampling" (GDC 2016): history is clamped to the
//         neighbourhood's mean and deviation.

//!include frame
//!include toned

@group(0) @binding(1) var image: texture_2d<f32>;
@group(0) @binding(2) var motion: texture_2d<f32>;
@group(0) @binding(3) var depth: texture_2d<f32>;
@group(0) @binding(4) var prev_output: texture_2d<f32>;
@group(0) @binding(5) var output: texture_storage_2d<rgba16float, write>;

// Weight of a new frame; about the last 2 / ALPHA count. Less shimmers less on a still view and lags more in motion.
const ALPHA = 0.15;
// Deviations from the mean that history may differ by. Above the root of 2, a line in one of three columns of the
// neighbourhood stays as it is; more keeps ghosts.
const DEVIATIONS = 1.5;
// Logarithm of the factor by which history's depth may be outside the neighbourhood's.
const DEPTH_TOLERANCE = 0.1;
// In the place of a miss's logarithm of depth; also what is further counts as the sky.
const MISS = 64.0;

fn log_depth(d: f32) -> f32 {
    return select(clamp(log2(max(d, 1e-12)), -MISS, MISS), MISS, is_miss(d));
}

struct Neighbourhood {
    mean: vec3<f32>,
    deviation: vec3<f32>,
    // Of the surface that is nearest to the eye, in pixels: at a silhouette, the edge moves with what is in front.
    motion_px: vec2<f32>,
    // Logarithms of the depths that were here in the previous frame.
    low: f32,
    high: f32,
}

// 3x3 pixels.
fn neighbourhood_of(pixel: vec2<i32>) -> Neighbourhood {
    var sum = vec3(0.0);
    var squares = vec3(0.0);
    var count = 0.0;
    var nearest = 2.0 * MISS;
    var around: Neighbourhood;
    around.low = MISS;
    around.high = -MISS;
    for (var i = 0; i < 9; i++) {
        let tap = pixel + vec2(i % 3 - 1, i / 3 - 1);
        if !inside(tap) {
            continue;
        }
        let color = ycocg(tone(sanitise(textureLoad(image, tap, 0).rgb)));
        sum += color;
        squares += color * color;
        count += 1.0;
        let d = textureLoad(depth, tap, 0).r;
        let moved = textureLoad(motion, tap, 0).xyz;
        if log_depth(d) < nearest {
            nearest = log_depth(d);
            around.motion_px = moved.xy;
        }
        let before = log_depth(d + select(0.0, moved.z, frame.has_motion_z != 0u && !is_miss(d)));
        around.low = min(around.low, before);
        around.high = max(around.high, before);
    }
    around.mean = sum / count;
    around.deviation = sqrt(max(squares / count - around.mean * around.mean, vec3(0.0)));
    return around;
}

fn catmull_rom(t: vec2<f32>) -> array<vec2<f32>, 4> {
    let t2 = t * t;
    let t3 = t2 * t;
    return array(
        0.5 * (-t3 + 2.0 * t2 - t), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0),
        0.5 * (-3.0 * t3 + 4.0 * t2 + t), 0.5 * (t3 - t2),
    );
}

// Bilinear history loses sharpness with every frame of motion.
fn history_at(position: vec2<f32>) -> vec3<f32> {
    let corner = position - 0.5;
    let base = vec2<i32>(floor(corner));
    var weights = catmull_rom(fract(corner));
    var sum = vec3(0.0);
    for (var i = 0; i < 16; i++) {
        let offset = vec2(i & 3, i >> 2);
        let tap = clamp(base + offset - 1, vec2(0), vec2<i32>(frame.size) - 1);
        sum += weights[offset.x].x * weights[offset.y].y * tone(textureLoad(prev_output, tap, 0).rgb);
    }
    return sum;
}

@compute @workgroup_size(8, 8)
fn antialias(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let pixel = vec2<i32>(id.xy);
    let color = sanitise(textureLoad(image, pixel, 0).rgb);
    let own_depth = log_depth(textureLoad(depth, pixel, 0).r);
    let around = neighbourhood_of(pixel);
    let position = vec2<f32>(pixel) + 0.5 + around.motion_px;
    var history = frame.restart == 0u && all_finite(vec3(around.motion_px, 0.0))
        && all(position >= vec2(0.0)) && all(position < vec2<f32>(frame.size));
    if history {
        // Jitter shows either side of an edge, so history may be of any surface around; of another one, it was uncovered.
        let before = textureLoad(prev_output, vec2<i32>(position), 0).a;
        history = before >= around.low - DEPTH_TOLERANCE && before <= around.high + DEPTH_TOLERANCE;
    }
    var result = color;
    if history {
        let spread = DEVIATIONS * around.deviation;
        let clamped = clamp(ycocg(history_at(position)), around.mean - spread, around.mean + spread);
        result = radiance_of(mix(rgb(clamped), tone(color), ALPHA));
    }
    textureStore(output, pixel, vec4(result, own_depth));
}
