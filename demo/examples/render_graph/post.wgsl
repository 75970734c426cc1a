// What comes after quell; joined to boxes.wgsl. Images may be larger than the frame, which is their top left part.

@group(0) @binding(1) var image: texture_2d<f32>;
@group(0) @binding(2) var linear_sampler: sampler;
@group(0) @binding(3) var glow_image: texture_2d<f32>;

struct Screen { @builtin(position) clip: vec4f, @location(0) uv: vec2f }

@vertex
fn screen(@builtin(vertex_index) vertex: u32) -> Screen {
    let uv = vec2f(f32(vertex % 2u), f32(vertex / 2u)) * 2.0;
    return Screen(vec4f(2.0 * uv.x - 1.0, 1.0 - 2.0 * uv.y, 0.0, 1.0), uv);
}

/// Bright surroundings, at half the size.
@fragment
fn glow(at: Screen) -> @location(0) vec4f {
    var sum = vec3f(0.0);
    for (var i = 0u; i < 64u; i++) {
        let offset = (vec2f(f32(i % 8u), f32(i / 8u)) - 3.5) / 150.0;
        sum += max(part(image, at.uv + offset, 1.0) - 0.6, vec3f(0.0));
    }
    return vec4f(sum / 64.0, 1.0);
}

@fragment
fn tonemap_glow(at: Screen) -> @location(0) vec4f {
    let radiance = part(image, at.uv, 1.0) + 0.2 * part(glow_image, at.uv, 2.0);
    return vec4f(srgb(radiance / (1.0 + radiance)), 1.0);
}

/// Scales the frame up to its place on the screen.
@fragment
fn present(at: Screen) -> @location(0) vec4f {
    return vec4f(part(image, at.uv, 1.0), 1.0);
}

/// Of an image that is `shrink` times smaller than the view.
fn part(shown_part: texture_2d<f32>, uv: vec2f, shrink: f32) -> vec3f {
    let size = ceil(vec2f(frame.size) / shrink);
    let texel = clamp(uv * size, vec2f(0.5), size - 0.5);
    return textureSampleLevel(shown_part, linear_sampler, texel / vec2f(textureDimensions(shown_part)), 0.0).rgb;
}
