// The space that temporal antialiasing compares and mixes colours in: tonemapped, so that one bright sample does not
// outweigh an edge's others, and YCoCg, whose axes fit the spread of neighbouring colours better than RGB's.
// Source: Karis, "High Quality Temporal Supersampling" (SIGGRAPH courses 2014).

// The largest value below 1 that half-precision radiance becomes.
const TONE_MAX = HALF_MAX / (1.0 + HALF_MAX);

fn tone(radiance: vec3<f32>) -> vec3<f32> {
    return radiance / (1.0 + radiance);
}

// Inverse of `tone`.
fn radiance_of(toned: vec3<f32>) -> vec3<f32> {
    let t = clamp(toned, vec3(0.0), vec3(TONE_MAX));
    return t / (1.0 - t);
}

fn ycocg(c: vec3<f32>) -> vec3<f32> {
    return vec3(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * c.r - 0.5 * c.b, -0.25 * c.r + 0.5 * c.g - 0.25 * c.b);
}

// Inverse of `ycocg`.
fn rgb(c: vec3<f32>) -> vec3<f32> {
    return vec3(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z);
}
