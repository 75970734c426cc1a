// compose: mixes prediction and temporal mean by their estimated errors, and makes radiance of it again.
//
// Reads   guide, prediction, history, noise; the caller's radiance (at misses), albedo, emission.
// Writes  output: the caller's image; mix_weight: share of the temporal mean
// Source  shrinkage towards a model by estimated risk: James and Stein, "Estimation with Quadratic Loss", 1961

//!include frame numbers surface demodulate

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var guide: texture_2d<u32>;
@group(0) @binding(2) var prediction: texture_2d<f32>;
@group(0) @binding(3) var history: texture_2d<f32>;
@group(0) @binding(4) var noise: texture_2d<f32>;
@group(0) @binding(5) var radiance: texture_2d<f32>;
@group(0) @binding(6) var albedo: texture_2d<f32>;
@group(0) @binding(7) var emission: texture_2d<f32>;
@group(0) @binding(8) var output: texture_storage_2d<rgba16float, write>;
@group(0) @binding(9) var mix_weight: texture_storage_2d<r32float, write>;

const RADIUS = 2;       // pixels; the errors are means over 5x5 of one surface
const SIDE = 12;        // workgroup and border
const CELLS = SIDE * SIDE;

// A pixel and its border, read once by the workgroup. Depth 0 is a miss or lies outside the frame.
var<workgroup> normals: array<vec3<f32>, CELLS>;
var<workgroup> positions: array<vec3<f32>, CELLS>;
var<workgroup> depths: array<f32, CELLS>;
var<workgroup> ids: array<u32, CELLS>;
// Squared distance of mean and model; the mean's variance as expected (< 0: no samples) and as found by bootstrap.
var<workgroup> errors: array<vec3<f32>, CELLS>;

@compute @workgroup_size(8, 8)
fn compose(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(local_invocation_id) local: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    for (var cell = i32(lane); cell < CELLS; cell += 64) {
        load_cell(cell, vec2<i32>(group.xy * 8u) + vec2(cell % SIDE, cell / SIDE) - vec2(RADIUS));
    }
    workgroupBarrier();
    if any(id.xy >= frame.size) {
        return;
    }
    let cell = (i32(local.y) + RADIUS) * SIDE + i32(local.x) + RADIUS;
    if depths[cell] <= 0.0 {
        let seen = textureLoad(radiance, id.xy, 0).rgb;
        textureStore(output, id.xy, vec4(clamp(select(vec3(0.0), seen, all_finite(seen)), vec3(0.0), vec3(HALF_MAX)), 1.0));
        textureStore(mix_weight, id.xy, vec4(1.0));
        return;
    }
    let share = temporal_share(cell);
    let filtered = mix(textureLoad(prediction, id.xy, 0).rgb, textureLoad(history, id.xy, 0).rgb, share);
    var composed = filtered * demodulator(textureLoad(albedo, id.xy, 0).rgb);
    if has(frame, FLAG_EMISSION) {
        let emitted = textureLoad(emission, id.xy, 0).rgb;
        composed += select(vec3(0.0), emitted, all_finite(emitted));
    }
    textureStore(output, id.xy, vec4(min(composed, vec3(HALF_MAX)), 1.0));
    textureStore(mix_weight, id.xy, vec4(share));
}

fn load_cell(cell: i32, pixel: vec2<i32>) {
    depths[cell] = 0.0;
    if !inside(pixel, frame) {
        return;
    }
    let surface = unpack_surface(textureLoad(guide, pixel, 0));
    normals[cell] = surface.normal;
    depths[cell] = surface.depth;
    ids[cell] = surface.id;
    positions[cell] = position_of(frame, frame.current, vec2<f32>(pixel), surface.depth);
    let predicted = textureLoad(prediction, pixel, 0);
    let mean = textureLoad(history, pixel, 0);
    let distance = luminance(mean.rgb - predicted.rgb);
    let deviation = textureLoad(noise, pixel, 0).y;
    errors[cell] = vec3(distance * distance, predicted.w * abs(predicted.w), deviation * deviation);
}

// Mean and model differ by the model's error and by the mean's noise: what is left of the squared distance D after the
// variance V is the model's squared error B, and the best mix gives the mean B / (B + V) = 1 - V / D. Both are pooled: a
// pixel's own variance is low just where its samples happen to be dark, and would keep them so. The pixel that differs most
// is left out, since one bright sample alone says nothing of the model. The mean of m squares deviates by sqrt(2 / m) of
// itself; what exceeds V by no more than that is taken for chance.
fn temporal_share(cell: i32) -> f32 {
    if !has(frame, FLAG_MIX) || errors[cell].y < 0.0 {
        return 0.0;
    }
    var centre: Surface;
    centre.normal = normals[cell];
    centre.depth = depths[cell];
    centre.id = ids[cell];
    var sum = vec3(0.0);
    var largest = vec3(0.0);
    var pooled = -1.0;
    for (var y = -RADIUS; y <= RADIUS; y++) {
        for (var x = -RADIUS; x <= RADIUS; x++) {
            let tap = cell + y * SIDE + x;
            var other = centre;
            other.normal = normals[tap];
            other.depth = depths[tap];
            other.id = ids[tap];
            if same_surface(centre, other, positions[tap] - positions[cell]) && errors[tap].y >= 0.0 {
                sum += errors[tap];
                pooled += 1.0;
                if errors[tap].x > largest.x {
                    largest = errors[tap];
                }
            }
        }
    }
    let left = sum - largest;
    if pooled < 1.0 || left.x <= 0.0 {
        return 0.0;
    }
    return saturate(1.0 - max(left.y, left.z) / left.x);
}
