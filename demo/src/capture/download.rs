//! From the images on the GPU to a frame that can be captured.

use super::Frame;
use crate::gbuffer::{GBuffer, Split};
use crate::gpu::Gpu;
use anyhow::{Context, Result};
use bytemuck::pod_collect_to_vec;
use half::f16;
use wgpu::TextureFormat;

/// Reads the images of `gbuffer` back, of split ones those of `gbuffer.split`; the frame has no reference. Waits for the GPU.
///
/// Half-precision images come back exactly. Emission, roughness, identities and sample counts are always there,
/// motion's depth where the image has it.
pub fn download(gpu: &Gpu, gbuffer: &GBuffer) -> Result<Frame> {
    let lobes = gbuffer.lobes.as_ref().filter(|_| gbuffer.split == Split::Full);
    let radiance = lobes.map_or(&gbuffer.radiance, |lobes| &lobes.rest);
    let specular = lobes.map(|lobes| &lobes.specular);
    let specular_albedo = lobes.and(gbuffer.specular_albedo.as_ref());
    let hit_distance = gbuffer.hit_distance.as_ref().filter(|_| gbuffer.split != Split::None);
    let optional_rgb = |view: Option<&wgpu::TextureView>| -> Result<_> {
        view.map(|view| Ok(rgb(&vectors(gpu, view)?))).transpose()
    };
    let normal_roughness = vectors(gpu, &gbuffer.normal_roughness)?;
    let motion = vectors(gpu, &gbuffer.motion)?;
    let has_z = gbuffer.motion.texture().format().components() > 2;
    Ok(Frame {
        width: gbuffer.width,
        height: gbuffer.height,
        radiance: rgb(&vectors(gpu, radiance)?),
        albedo: rgb(&vectors(gpu, &gbuffer.albedo)?),
        normal: rgb(&normal_roughness),
        depth: floats(gpu, &gbuffer.depth)?,
        motion: motion.iter().map(|m| [m[0], m[1]]).collect(),
        motion_depth: has_z.then(|| motion.iter().map(|m| m[2]).collect()),
        roughness: Some(normal_roughness.iter().map(|n| n[3]).collect()),
        surface_id: Some(pod_collect_to_vec(&gpu.read_texture(gbuffer.surface_id.texture())?)),
        emission: Some(rgb(&vectors(gpu, &gbuffer.emission)?)),
        samples: Some(pod_collect_to_vec(&gpu.read_texture(gbuffer.sample_count.texture())?)),
        specular: optional_rgb(specular)?,
        specular_albedo: optional_rgb(specular_albedo)?,
        hit_distance: hit_distance.map(|view| floats(gpu, view)).transpose()?,
        reference: None,
    })
}

fn floats(gpu: &Gpu, view: &wgpu::TextureView) -> Result<Vec<f32>> {
    Ok(pod_collect_to_vec(&gpu.read_texture(view.texture())?))
}

fn rgb(texels: &[[f32; 4]]) -> Vec<[f32; 3]> {
    texels.iter().map(|&[r, g, b, _]| [r, g, b]).collect()
}

/// A float image, filled up to four components with zeros.
fn vectors(gpu: &Gpu, view: &wgpu::TextureView) -> Result<Vec<[f32; 4]>> {
    let texture = view.texture();
    let bytes = gpu.read_texture(texture)?;
    let format = texture.format();
    let values: Vec<f32> = match format {
        TextureFormat::Rgba16Float | TextureFormat::Rg16Float => {
            pod_collect_to_vec::<u8, f16>(&bytes).into_iter().map(f16::to_f32).collect()
        }
        TextureFormat::Rgba32Float | TextureFormat::Rg32Float => pod_collect_to_vec(&bytes),
        _ => return None.with_context(|| format!("cannot capture an image of format {format:?}")),
    };
    let texel = |values: &[f32]| {
        let mut texel = [0.0; 4];
        texel[..values.len()].copy_from_slice(values);
        texel
    };
    Ok(values.chunks_exact(usize::from(format.components())).map(texel).collect())
}
