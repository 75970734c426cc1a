// predict: every pixel from the models whose windows hold it, weighted by a tent that ends at the window's border, and by how
// well they fit.
//
// Reads   guide, history, noise, models.
// Writes  prediction: predicted demodulated radiance; in w the standard error of the temporal mean, < 0 without samples
// Source  Moon et al. 2015, section 4.3: overlapping predictions are averaged

//!include frame numbers surface features

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var guide: texture_2d<u32>;
@group(0) @binding(2) var history: texture_2d<f32>;
@group(0) @binding(3) var noise: texture_2d<f32>;
@group(0) @binding(4) var<storage, read> models: array<f32>;
@group(0) @binding(5) var prediction: texture_storage_2d<rgba16float, write>;

// A workgroup is one cell of the grid of centres, so all its pixels read the same models.
@compute @workgroup_size(8, 8)
fn predict(@builtin(global_invocation_id) id: vec3<u32>, @builtin(workgroup_id) cell: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let surface = unpack_surface(textureLoad(guide, id.xy, 0));
    if is_miss(surface) {
        textureStore(prediction, id.xy, vec4(0.0));
        return;
    }
    let mean = textureLoad(history, id.xy, 0);
    let z = features(id.xy, surface, position_of(frame, frame.current, vec2<f32>(id.xy), surface.depth));
    let reach = window_reach(frame);
    var sum = vec4(0.0);
    var noises = vec2(0.0); // gain, relative noise
    // The widest window (28 pixels about the middle of a cell's first tile) reaches one cell back and two ahead.
    for (var y = -1; y <= 2; y++) {
        for (var x = -1; x <= 2; x++) {
            let centre = vec2<i32>(cell.xy) + vec2(x, y);
            if any(centre < vec2(0)) || any(centre >= vec2<i32>(frame.centres)) {
                continue;
            }
            let middle = (vec2<f32>(centre) * f32(CENTRE_STRIDE) + 0.5) * f32(TILE);
            let tent = max(1.0 - abs(vec2<f32>(id.xy) + 0.5 - middle) / reach, vec2(0.0));
            let start = (u32(centre.y) * frame.centres.x + u32(centre.x)) * MODEL_STRIDE;
            let weight = tent.x * tent.y * models[start + MODEL_TRUST];
            if weight > 0.0 && models[start + MODEL_WEIGHT] > 0.0 {
                sum += weight * vec4(evaluate(start, z), 1.0);
                noises += weight
                    * vec2(models[start + MODEL_NOISE_GAIN], models[start + MODEL_RELATIVE_NOISE]);
            }
        }
    }
    // Without any sample near, the temporal mean is all there is.
    var predicted = mean.rgb;
    if sum.w > 0.0 {
        predicted = clamp(sum.rgb / sum.w, vec3(0.0), vec3(HALF_MAX));
    }
    var standard_error = -1.0;
    if mean.w > 0.0 && sum.w > 0.0 {
        // With a prior sample, as noisy as the window's are: few samples that all were dark are no certainty.
        let l = luminance(predicted);
        let prior = noises.y / sum.w * l * l;
        let own = noises.x / sum.w * textureLoad(noise, id.xy, 0).x;
        standard_error = sqrt((own * mean.w + prior) / (mean.w + 1.0) / mean.w);
    }
    textureStore(prediction, id.xy, vec4(predicted, min(standard_error, HALF_MAX)));
}

fn evaluate(start: u32, z: array<f32, FEATURES>) -> vec3<f32> {
    var value = model_vector(start + MODEL_MEAN + FEATURES);
    for (var i = 0u; i < FEATURES; i++) {
        value += (z[i] - models[start + MODEL_MEAN + i]) * model_vector(start + MODEL_SLOPE + i * CHANNELS);
    }
    return value;
}

fn model_vector(at: u32) -> vec3<f32> {
    return vec3(models[at], models[at + 1u], models[at + 2u]);
}
