// Draws what was denoised over the view target, where it lies. Its alpha stays.

@group(0) @binding(0) var denoised: texture_2d<f32>;

@vertex
fn corner(@builtin(vertex_index) i: u32) -> @builtin(position) vec4f {
    return vec4f(4 * f32(i % 2) - 1, 4 * f32(i / 2) - 1, 0, 1);
}

@fragment
fn pixel(@builtin(position) at: vec4f) -> @location(0) vec4f {
    return textureLoad(denoised, vec2u(at.xy), 0);
}
