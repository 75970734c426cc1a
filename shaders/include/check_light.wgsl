// Statistics of albedo, emission, ids and depth that need no suspicion of their own.
//
// A pass binds radiance, albedo, emission, sample_count and previous_guide.

const PIXELS = 0u;
const DEPTH_NEGATIVE = 1u;
const HITS = 2u;
const ALBEDO_ONE = 3u;
const ALBEDO_ZERO = 4u;
const EMITTERS = 5u;
const EMISSION_LACKING = 6u;   // radiance below emission
const EMISSION_TWICE = 7u;     // radiance about twice emission
const EMISSION_LESS = 8u;      // radiance below twice emission
const IDS_FOUND = 9u;          // surfaces of the previous frame by motion, depth and normal
const IDS_SAME = 10u;
const SLOPE = 11u;             // of radiance over albedo, and its weight; see `check_slopes`
const SLOPE_WEIGHT = 12u;
const DECODED_SLOPE = 13u;
const DECODED_WEIGHT = 14u;
const LIGHT_WORDS = 15u;

fn check_light(pixel: vec2<u32>, surface: Surface) {
    tally(FIRST_LIGHT + PIXELS, true);
    let reflectance = textureLoad(albedo, frame.origin + pixel, 0).rgb;
    tally(FIRST_LIGHT + HITS, true);
    // Rounded to 8 bits they are exact.
    tally(FIRST_LIGHT + ALBEDO_ONE, all(reflectance > vec3(0.998)));
    tally(FIRST_LIGHT + ALBEDO_ZERO, all(abs(reflectance) < vec3(0.002)));
    if has(frame, FLAG_EMISSION) {
        check_emission(pixel);
    }
}

const LEAST_EMISSION = 1e-3;

fn check_emission(pixel: vec2<u32>) {
    let emitted = luminance(repair_emission(textureLoad(emission, frame.origin + pixel, 0).rgb));
    let seen = textureLoad(radiance, frame.origin + pixel, 0).rgb;
    // What was not traced shows nothing.
    if emitted > LEAST_EMISSION && all_finite(seen) && samples_at(pixel) > 0.0 {
        let ratio = luminance(seen) / emitted;
        tally(FIRST_LIGHT + EMITTERS, true);
        tally(FIRST_LIGHT + EMISSION_LACKING, ratio < 0.9);
        tally(FIRST_LIGHT + EMISSION_LESS, ratio < 1.98);
        tally(FIRST_LIGHT + EMISSION_TWICE, ratio >= 1.98 && ratio < 2.1);
    }
}

const SAME_NORMAL_COSINE = 0.95;
const SAME_PLANE = 0.01; // of the depth

// Ids of what motion, normal and distance say to be one surface.
fn check_ids(pixel: vec2<u32>, surface: Surface, moved: vec2<f32>) {
    let uv = (vec2<f32>(pixel) + 0.5 + clamp(moved, vec2(-1e6), vec2(1e6))) / frame.current.size;
    let texel = vec2<i32>(floor(uv * frame.previous.size));
    if !has(frame, FLAG_SURFACE_ID) || !inside(texel, frame.previous) {
        return;
    }
    let tap = unpack_surface(textureLoad(previous_guide, texel, 0).xy);
    let position = position_of(frame.current, vec2<f32>(pixel), surface.depth) + frame.eye_delta;
    let offset = position_of(frame.previous, vec2<f32>(texel), tap.depth) - position;
    let is_near = abs(dot(surface.normal, offset)) < SAME_PLANE * surface.depth;
    if !is_miss(tap) && dot(tap.normal, surface.normal) > SAME_NORMAL_COSINE && is_near {
        tally(FIRST_LIGHT + IDS_FOUND, true);
        tally(FIRST_LIGHT + IDS_SAME, tap.id == surface.id);
    }
}

// Of each pixel that tells how radiance goes with albedo: luminance of radiance, of albedo, and of albedo decoded from sRGB.
var<workgroup> lit: array<vec3<f32>, 64>;
var<workgroup> tile_surface: Surface;

const ROUGH = 0.5;              // what is smoother shows more than its albedo
const LEAST_ALBEDO = 0.01;
const LEAST_LIT = 16.0;         // pixels of a tile
const SLOPE_ONE: f32 = 32.0;    // a slope of 1 in the words

fn enter_lit(pixel: vec2<u32>, lane: u32, surface: Surface) {
    let seen = textureLoad(radiance, frame.origin + pixel, 0).rgb;
    let reflectance = textureLoad(albedo, frame.origin + pixel, 0).rgb;
    let is_dull = surface.roughness >= ROUGH || has(frame, FLAG_SPLIT);
    let is_dark = !has(frame, FLAG_EMISSION) || luminance(repair_emission(textureLoad(emission, frame.origin + pixel, 0).rgb)) <= 0.0;
    let is_of_tile = surface.id == tile_surface.id && dot(surface.normal, tile_surface.normal) > SAME_NORMAL_COSINE;
    let is_lit = is_of_tile && is_dull && is_dark && all_finite(seen) && all_finite(reflectance) && samples_at(pixel) > 0.0;
    let a = luminance(reflectance);
    if is_lit && a > LEAST_ALBEDO && !is_miss(surface) && !is_miss(tile_surface) {
        lit[lane] = vec3(clamp(luminance(seen), 0.0, HALF_MAX), a, luminance(linear_from_srgb(reflectance)));
    }
}

// What is lit alike is as bright as its albedo: within a tile, radiance = c albedo^(1 + slope) with slope 0. One step of the
// Poisson likelihood's Newton iteration from 0, summed over tiles: bounded, however bright a single sample is.
fn check_slopes() {
    for (var i = 0u; i < 2u; i++) {
        var sums = vec4(0.0); // pixels, radiance, albedo, albedo log albedo
        for (var lane = 0u; lane < 64u; lane++) {
            let a = lit[lane][i + 1u];
            if a > 0.0 {
                sums += vec4(1.0, lit[lane].x, a, a * log(a));
            }
        }
        if sums.x < LEAST_LIT || sums.y <= 0.0 {
            return;
        }
        var slope = vec2(0.0);
        for (var lane = 0u; lane < 64u; lane++) {
            let a = lit[lane][i + 1u];
            if a > 0.0 {
                let off = log(a) - sums.w / sums.z;
                slope += vec2((lit[lane].x * sums.z / sums.y - a) * off, a * off * off);
            }
        }
        let words = vec2<i32>(round(slope * (SLOPE_ONE * sums.x / sums.z)));
        atomicAdd(&tallies[FIRST_LIGHT + SLOPE + 2u * i], bitcast<u32>(words.x));
        atomicAdd(&tallies[FIRST_LIGHT + SLOPE_WEIGHT + 2u * i], u32(words.y));
    }
}

// Source: IEC 61966-2-1.
fn linear_from_srgb(v: vec3<f32>) -> vec3<f32> {
    let c = max(v, vec3(0.0));
    return select(pow((c + 0.055) / 1.055, vec3(2.4)), c / 12.92, c <= vec3(0.04045));
}
