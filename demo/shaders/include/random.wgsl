// Random numbers: a sequence per pixel, frame and seed, the same on every run.
// Source: Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020 (pcg4d, pcg).

var<private> random_state: u32;

fn seed_random(pixel: vec2u, frame: u32, seed: u32) {
    var v = vec4u(pixel, frame, seed) * 1664525u + 1013904223u;
    v += v.yzxy * v.wxyz;
    v ^= v >> vec4u(16u);
    v += v.yzxy * v.wxyz;
    random_state = v.x ^ v.w;
}

// In [0, 1), 24 bits.
fn random() -> f32 {
    random_state = random_state * 747796405u + 2891336453u;
    let word = ((random_state >> ((random_state >> 28u) + 4u)) ^ random_state) * 277803737u;
    let bits = (word >> 22u) ^ word;
    return f32(bits >> 8u) * 0x1p-24;
}

fn random2() -> vec2f {
    let x = random();
    return vec2f(x, random());
}
