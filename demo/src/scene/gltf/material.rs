//! Materials.

use super::error::fail;
use super::limits::MOST_LIGHT;
use super::read::File;
use super::{Result, element};
use crate::scene::{Material, TextureRef};
use glam::Vec2;

pub(super) fn load(file: &File, source: &gltf::Material<'_>) -> Result<Material> {
    let what = element("material", source.index().unwrap_or_default(), source.name());
    let pbr = source.pbr_metallic_roughness();
    let image_of = |texture: gltf::Texture<'_>| match texture.source() {
        Some(image) => Ok(TextureRef::new(image.index())),
        None => {
            let reason = format!("its texture {} has no PNG or JPEG image", texture.index());
            fail(&file.path, &what, reason)
        }
    };
    let info = |info: Option<gltf::texture::Info<'_>>| {
        let Some(info) = info else {
            return Ok(None);
        };
        let mut texture = image_of(info.texture())?;
        if let Some(t) = info.texture_transform() {
            texture = TextureRef {
                offset: t.offset().into(),
                rotation: t.rotation(),
                scale: t.scale().into(),
                ..texture
            };
        }
        Ok(Some(texture))
    };
    let mut normal_texture = None;
    if let Some(normal) = source.normal_texture() {
        let texture = image_of(normal.texture())?;
        let json = normal.extensions().and_then(|e| e.get("KHR_texture_transform"));
        normal_texture = Some(json.map_or(texture, |json| transformed(texture, json)));
    }
    let strength = source.emissive_strength().unwrap_or(1.0);
    let material = Material {
        name: source.name().unwrap_or_default().to_owned(),
        base_color: pbr.base_color_factor(),
        base_color_texture: info(pbr.base_color_texture())?,
        metallic: pbr.metallic_factor(),
        roughness: pbr.roughness_factor(),
        metallic_roughness_texture: info(pbr.metallic_roughness_texture())?,
        normal_texture,
        normal_scale: source.normal_texture().map_or(1.0, |n| n.scale()),
        specular: 1.0,
        emissive: source.emissive_factor().map(|e| e * strength),
        emissive_texture: info(source.emissive_texture())?,
        emission_scale: None,
        // Blending is not traced: what is more than half there is solid.
        alpha_cutoff: match source.alpha_mode() {
            gltf::material::AlphaMode::Opaque => None,
            gltf::material::AlphaMode::Mask => Some(source.alpha_cutoff().unwrap_or(0.5)),
            gltf::material::AlphaMode::Blend => Some(0.5),
        },
        double_sided: source.double_sided(),
    };
    check(file, &what, &material)?;
    Ok(material)
}

fn check(file: &File, what: &str, material: &Material) -> Result<()> {
    let textures = [
        material.base_color_texture,
        material.metallic_roughness_texture,
        material.normal_texture,
        material.emissive_texture,
    ];
    let transforms = textures.into_iter().flatten().flat_map(|t| t.matrix()).flatten();
    let numbers = [material.metallic, material.roughness, material.normal_scale];
    let numbers = numbers.into_iter().chain(material.base_color).chain(material.alpha_cutoff);
    if !numbers.chain(transforms).all(f32::is_finite) {
        return fail(&file.path, what, "a factor or a texture transform is not finite");
    }
    if !material.emissive.iter().all(|value| (0.0..=MOST_LIGHT).contains(value)) {
        let reason = format!("its emission is {:?}, expected 0 to {MOST_LIGHT:e} each", material.emissive);
        return fail(&file.path, what, reason);
    }
    Ok(())
}

/// The gltf crate gives a normal texture's transform only as JSON.
fn transformed(texture: TextureRef, json: &gltf::json::Value) -> TextureRef {
    let number = |value: &gltf::json::Value| value.as_f64().map(|v| v as f32);
    let pair = |key: &str, default: Vec2| {
        let values = json.get(key).and_then(|v| v.as_array());
        let get = |i: usize| values.and_then(|v| v.get(i)).and_then(number);
        Vec2::new(get(0).unwrap_or(default.x), get(1).unwrap_or(default.y))
    };
    TextureRef {
        offset: pair("offset", Vec2::ZERO),
        rotation: json.get("rotation").and_then(number).unwrap_or(0.0),
        scale: pair("scale", Vec2::ONE),
        ..texture
    }
}

/// The set of texture coordinates that a material's meshes need.
pub(super) fn uv_set(source: &gltf::Material<'_>) -> u32 {
    let pbr = source.pbr_metallic_roughness();
    let textures = [pbr.base_color_texture(), pbr.metallic_roughness_texture(), source.emissive_texture()];
    let used = textures.into_iter().flatten().next();
    let set = |info: gltf::texture::Info<'_>| {
        info.texture_transform().and_then(|t| t.tex_coord()).unwrap_or(info.tex_coord())
    };
    used.map(set).or(source.normal_texture().map(|n| n.tex_coord())).unwrap_or(0)
}
