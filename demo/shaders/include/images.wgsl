// Images of materials.

const BASE_COLOR: u32 = 0u;
const METALLIC_ROUGHNESS: u32 = 1u;
const NORMAL: u32 = 2u;
const EMISSIVE: u32 = 3u;

fn load_material(material: u32, texel: u32) -> vec4f {
    return textureLoad(materials, scene_texel(material * MATERIAL_TEXELS + texel), 0);
}

// KHR_texture_transform.
fn image_uv(material: u32, slot: u32, uv: vec2f) -> vec2f {
    let h = vec3f(uv, 1.0);
    let x = load_material(material, 5u + 2u * slot);
    let y = load_material(material, 6u + 2u * slot);
    return vec2f(dot(x.xyz, h), dot(y.xyz, h));
}

// `footprint` is the pixel's width in uv; the level is that of a texel as wide.
fn image_level(footprint: f32) -> f32 {
    return log2(max(footprint * f32(textureDimensions(color_images).x), 1e-6));
}

fn sample_color(layer: f32, uv: vec2f, level: f32) -> vec4f {
    return textureSampleLevel(color_images, image_sampler, uv, u32(layer), level);
}

fn sample_data(layer: f32, uv: vec2f, level: f32) -> vec4f {
    return textureSampleLevel(data_images, image_sampler, uv, u32(layer), level);
}
