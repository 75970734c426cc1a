// debug_view: one of the frame's inner images, as a picture.
//
// Reads   guide, motion, prediction, history, noise, mix_weight, error, models, windows.
// Writes  debug: the caller's image

//!include frame numbers noise surface motion features linear_model windows models error

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var guide: texture_2d<u32>;
@group(0) @binding(2) var motion: texture_2d<f32>;
@group(0) @binding(3) var prediction: texture_2d<u32>;
@group(0) @binding(4) var history: texture_2d<f32>;
@group(0) @binding(5) var noise: texture_2d<u32>;
@group(0) @binding(6) var mix_weight: texture_2d<u32>;
@group(0) @binding(7) var error: texture_2d<u32>;
@group(0) @binding(8) var<storage, read> models: array<vec4<f32>>;
@group(0) @binding(9) var<storage, read> windows: array<u32>;
@group(0) @binding(10) var debug: texture_storage_2d<rgba16float, write>;

const OWN_FEATURES = MODEL_OWN_FEATURES;

const VIEW_PREDICTION = 1u;
const VIEW_TEMPORAL_MEAN = 2u;
const VIEW_HISTORY_LENGTH = 3u;
const VIEW_STANDARD_ERROR = 4u;
const VIEW_MIX_WEIGHT = 5u;
const VIEW_NORMAL = 6u;
const VIEW_DEPTH = 7u;
const VIEW_MOTION = 8u;
const VIEW_SURFACE_ID = 9u;
const VIEW_WINDOWS = 10u;
const VIEW_COVERAGE = 11u;
const VIEW_PREDICTED_ERROR = 12u;
const VIEW_OUTPUT_ERROR = 13u;

const FULL_COVERAGE = 16.0; // models over a pixel that are shown white

@compute @workgroup_size(8, 8)
fn debug_view(@builtin(global_invocation_id) id: vec3<u32>) {
    if any(id.xy >= frame.size) {
        return;
    }
    let surface = unpack_surface(textureLoad(guide, id.xy, 0).xy);
    var colour = vec3(0.0);
    if !is_miss(surface) || frame.debug_view == VIEW_MOTION {
        colour = picture(id.xy, surface);
    }
    textureStore(debug, frame.origin + id.xy, vec4(colour, 1.0));
}

fn picture(pixel: vec2<u32>, surface: Surface) -> vec3<f32> {
    let mean = textureLoad(history, pixel, 0);
    let predicted = unpack_prediction(textureLoad(prediction, pixel, 0).xy);
    switch frame.debug_view {
        case VIEW_PREDICTION: {
            return select(mean.rgb, predicted.signal, is_known(predicted));
        }
        case VIEW_TEMPORAL_MEAN: {
            return mean.rgb;
        }
        case VIEW_HISTORY_LENGTH: {
            return vec3(mean.w / frame.max_history);
        }
        case VIEW_STANDARD_ERROR: {
            if mean.w <= 0.0 || !is_known(predicted) {
                return vec3(0.0);
            }
            let own = unpack_noise(textureLoad(noise, pixel, 0).x, mean.w);
            return vec3(standard_error(predicted, own.variance, mean.w) / max(luminance(mean.rgb), 1e-6));
        }
        case VIEW_MIX_WEIGHT: {
            return vec3(bitcast<f32>(textureLoad(mix_weight, pixel, 0).x));
        }
        case VIEW_OUTPUT_ERROR: {
            return vec3(unpack_error(textureLoad(error, pixel, 0).x).deviation);
        }
        case VIEW_NORMAL: {
            return 0.5 + 0.5 * surface.normal;
        }
        case VIEW_DEPTH: {
            return vec3(1.0 / (1.0 + surface.depth));
        }
        case VIEW_MOTION: {
            let moved = motion_at(pixel).xy * frame.current.size;
            return hue(atan2(moved.y, moved.x) / 6.2831853) * saturate(length(moved) / 16.0);
        }
        case VIEW_SURFACE_ID: {
            return hue(f32(surface.id) / f32(IDS));
        }
        default: {
            return models_picture(pixel);
        }
    }
}

// What is known of the models whose windows hold a pixel.
fn models_picture(pixel: vec2<u32>) -> vec3<f32> {
    let own = vec2<i32>(pixel / TILE);
    let most = i32(WIDEST_REACH);
    var sum = vec3(0.0); // weight, window, error
    var count = 0.0;
    for (var y = -most; y <= most; y++) {
        for (var x = -most; x <= most; x++) {
            let tile = own + vec2(x, y);
            if any(tile < vec2(0)) || any(tile >= vec2<i32>(frame.tiles)) {
                continue;
            }
            let index = u32(tile.y) * frame.tiles.x + u32(tile.x);
            let head = models[index * MODEL_STRIDE];
            let size = stored_window(windows[index]);
            if size == 0u {
                continue;
            }
            let middle = (vec2<f32>(tile) + 0.5) * f32(TILE);
            let weight = tent(vec2<f32>(pixel) + 0.5 - middle, size);
            if weight > 0.0 {
                count += 1.0;
                sum += weight * head[HEAD_TRUST] * vec3(1.0, f32(size), head[HEAD_ERROR]);
            }
        }
    }
    if frame.debug_view == VIEW_COVERAGE {
        return vec3(count / FULL_COVERAGE);
    }
    if frame.debug_view == VIEW_PREDICTED_ERROR {
        return vec3(sqrt(sum.z / max(sum.x, 1e-30)));
    }
    let own_size = stored_window(windows[u32(own.y) * frame.tiles.x + u32(own.x)]);
    let middle = vec2<u32>(own) * TILE + TILE / 2u;
    if own_size > 0u && all(pixel + 1u >= middle) && all(pixel <= middle) {
        return window_hue(f32(own_size));
    }
    return 0.4 * window_hue(sum.y / max(sum.x, 1e-30));
}

// Red: a window of five tiles; green: 3x3; blue: 5x5.
fn window_hue(chosen: f32) -> vec3<f32> {
    return hue((chosen - 1.0) / 3.0);
}

fn hue(turns: f32) -> vec3<f32> {
    return saturate(abs(fract(turns + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0);
}
