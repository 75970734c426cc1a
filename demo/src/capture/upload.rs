//! From a captured frame to the images on the GPU.

use super::Frame;
use crate::gbuffer::{GBuffer, Lobes, Split, image};
use crate::image::{half_from_f32, write_texture};
use half::f16;
use wgpu::TextureFormat;

/// Images for frames like `frame`.
///
/// Where it has no `motion.Z`, motion is `Rg32Float`, which has no third component: a zero there would claim that
/// no point's depth ever changes.
pub fn gbuffer_for(device: &wgpu::Device, frame: &Frame) -> GBuffer {
    let mut gbuffer = GBuffer::new(device, frame.width, frame.height);
    // As much as frames have.
    gbuffer.split = Split::Full;
    if frame.motion_depth.is_none() {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("motion"),
            size: gbuffer.motion.texture().size(),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: TextureFormat::Rg32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::COPY_SRC
                | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        gbuffer.motion = texture.create_view(&Default::default());
    }
    gbuffer
}

/// Writes `frame` into `gbuffer`, filling in the defaults of images that it lacks. Frames of one capture may differ
/// in their optional images, so those that this one lacks are dropped and others made, and the motion image is made anew where it
/// has to change its format.
///
/// # Panics
/// Where the frame's size is not the images'.
pub fn upload(device: &wgpu::Device, queue: &wgpu::Queue, frame: &Frame, gbuffer: &mut GBuffer) {
    assert_eq!((frame.width, frame.height), (gbuffer.width, gbuffer.height));
    let has_z = gbuffer.motion.texture().format() == TextureFormat::Rgba16Float;
    if has_z != frame.motion_depth.is_some() {
        gbuffer.motion = gbuffer_for(device, frame).motion;
    }
    let size = [frame.width, frame.height];
    let new = |label, format| image(device, label, size, format);
    let GBuffer { lobes, specular_albedo, hit_distance, .. } = gbuffer;
    *lobes = frame.specular.as_ref().map(|_| lobes.take().unwrap_or_else(|| Lobes::new(device, size)));
    *specular_albedo = frame.specular_albedo.as_ref().map(|_| {
        specular_albedo.take().unwrap_or_else(|| new("specular_albedo", TextureFormat::Rgba16Float))
    });
    *hit_distance = frame
        .hit_distance
        .as_ref()
        .map(|_| hit_distance.take().unwrap_or_else(|| new("hit_distance", TextureFormat::R32Float)));
    let pixels = frame.radiance.len();
    let write_half = |view: &wgpu::TextureView, texels: Vec<[f32; 4]>| {
        let half: Vec<[f16; 4]> = texels.into_iter().map(|texel| texel.map(half_from_f32)).collect();
        write_texture(queue, view.texture(), &half);
    };
    let with =
        |rgb: &[[f32; 3]], w: f32| -> Vec<[f32; 4]> { rgb.iter().map(|&[r, g, b]| [r, g, b, w]).collect() };

    write_texture(queue, gbuffer.radiance.texture(), &with(&frame.combined_radiance(), 1.0));
    if let (Some(lobes), Some(specular)) = (&gbuffer.lobes, &frame.specular) {
        write_texture(queue, lobes.rest.texture(), &with(&frame.radiance, 1.0));
        write_texture(queue, lobes.specular.texture(), &with(specular, 1.0));
    }
    if let (Some(view), Some(albedo)) = (&gbuffer.specular_albedo, &frame.specular_albedo) {
        write_half(view, with(albedo, 1.0));
    }
    if let (Some(view), Some(distances)) = (&gbuffer.hit_distance, &frame.hit_distance) {
        write_texture(queue, view.texture(), distances);
    }
    write_half(&gbuffer.albedo, with(&frame.albedo, 1.0));
    let mut normal_roughness = with(&frame.normal, 1.0);
    for (texel, &roughness) in normal_roughness.iter_mut().zip(frame.roughness.iter().flatten()) {
        texel[3] = roughness;
    }
    write_half(&gbuffer.normal_roughness, normal_roughness);
    write_texture(queue, gbuffer.depth.texture(), &frame.depth);
    match &frame.motion_depth {
        Some(z) => {
            let motion = frame.motion.iter().zip(z).map(|(&[x, y], &z)| [x, y, z, 0.0]).collect();
            write_half(&gbuffer.motion, motion);
        }
        None => write_texture(queue, gbuffer.motion.texture(), &frame.motion),
    }
    let integers =
        |plane: &Option<Vec<u32>>, default: u32| plane.clone().unwrap_or_else(|| vec![default; pixels]);
    write_texture(queue, gbuffer.surface_id.texture(), &integers(&frame.surface_id, 0));
    write_texture(queue, gbuffer.sample_count.texture(), &integers(&frame.samples, 1));
    match &frame.emission {
        Some(emission) => write_half(&gbuffer.emission, with(emission, 0.0)),
        None => write_half(&gbuffer.emission, vec![[0.0; 4]; pixels]),
    }
}
