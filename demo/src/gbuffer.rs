//! The images that the path tracer writes and the denoiser reads, on the GPU.

use crate::gpu::Gpu;
use anyhow::Result;
use half::f16;

/// Linear roughness below which a surface shows what is around it, not only how bright that is.
const REFLECTIVE_ROUGHNESS: f32 = 0.5;

/// What of a frame the denoiser gets apart, by the lobe through which light left the first hit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Split {
    /// Specular radiance, its albedo, and hit distances
    #[default]
    Full,
    /// Hit distances, with combined radiance
    HitDistance,
    /// Nothing: combined radiance
    None,
}

/// The split radiance of a frame: two images that sum to [`GBuffer::radiance`] but for rounding.
#[derive(Debug)]
pub struct Lobes {
    /// `Rgba32Float`: all but `specular`: what left the first hit through its diffuse lobe, emission, and the sky at a miss.
    pub rest: wgpu::TextureView,
    /// `Rgba32Float`: what left the first hit through its specular lobe; 0 at a miss.
    pub specular: wgpu::TextureView,
}

/// One frame's inputs of the denoiser; each made by [`image()`].
#[derive(Debug)]
pub struct GBuffer {
    pub width: u32,
    pub height: u32,
    /// `Rgba32Float`: noisy combined radiance, emission included; the sky at a miss.
    pub radiance: wgpu::TextureView,
    /// `Rgba16Float`: diffuse reflectance at the first hit, specular colour at normal incidence for metals; 1 at a miss. That of
    /// `Lobes::rest` as well, which is black on metals whatever they are demodulated by.
    pub albedo: wgpu::TextureView,
    /// `Rgba16Float`: world-space shading normal, linear roughness in w; 0 at a miss.
    pub normal_roughness: wgpu::TextureView,
    /// `R32Float`: linear view depth; infinity at a miss.
    pub depth: wgpu::TextureView,
    /// `Rgba16Float`: previous minus current position in **pixels** (+x right, +y down), then previous minus
    /// current view depth in z.
    pub motion: wgpu::TextureView,
    /// `R32Uint`: one id per instance and material; 0 at a miss.
    pub surface_id: wgpu::TextureView,
    /// `Rgba16Float`: radiance seen directly from emitters.
    pub emission: wgpu::TextureView,
    /// `R32Uint`: samples traced at the pixel this frame.
    pub sample_count: wgpu::TextureView,
    /// `R32Uint`: samples that the denoiser asks for in the next frame.
    pub sample_map: wgpu::TextureView,
    /// What of the following the denoiser gets, and a capture holds, where nothing else is said.
    pub split: Split,
    /// Of frames that were traced or captured split.
    pub lobes: Option<Lobes>,
    /// `Rgba16Float`: what the specular lobe reflects towards the camera of light that comes evenly from all sides; 1 at a miss.
    /// Only with `lobes`.
    pub specular_albedo: Option<wgpu::TextureView>,
    /// `R32Float`: world-space distance from the first hit along a direction of its specular lobe to the next; 1e30 for the sky,
    /// 0 where no sample went that way.
    pub hit_distance: Option<wgpu::TextureView>,
}

impl Lobes {
    pub fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let image = |label| image(device, label, size, wgpu::TextureFormat::Rgba32Float);
        Self { rest: image("rest"), specular: image("specular") }
    }
}

/// An image that passes write, read, and that can be copied to and from.
pub fn image(
    device: &wgpu::Device,
    label: &str,
    [width, height]: [u32; 2],
    format: wgpu::TextureFormat,
) -> wgpu::TextureView {
    let texture = device.create_texture(&wgpu::TextureDescriptor {
        label: Some(label),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::TEXTURE_BINDING
            | wgpu::TextureUsages::STORAGE_BINDING
            | wgpu::TextureUsages::COPY_SRC
            | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    });
    texture.create_view(&Default::default())
}

impl GBuffer {
    /// Images for combined radiance alone.
    pub fn new(device: &wgpu::Device, width: u32, height: u32) -> Self {
        Self::with_split(device, width, height, Split::None)
    }

    /// Images for what `split` needs; the tracer writes all of them or none.
    pub fn with_split(device: &wgpu::Device, width: u32, height: u32, split: Split) -> Self {
        let is_split = split != Split::None;
        let image = |label, format| image(device, label, [width, height], format);
        use wgpu::TextureFormat::{R32Float, R32Uint, Rgba16Float, Rgba32Float};
        Self {
            width,
            height,
            radiance: image("radiance", Rgba32Float),
            albedo: image("albedo", Rgba16Float),
            normal_roughness: image("normal_roughness", Rgba16Float),
            depth: image("depth", R32Float),
            motion: image("motion", Rgba16Float),
            surface_id: image("surface_id", R32Uint),
            emission: image("emission", Rgba16Float),
            sample_count: image("sample_count", R32Uint),
            sample_map: image("sample_map", R32Uint),
            split,
            lobes: is_split.then(|| Lobes::new(device, [width, height])),
            specular_albedo: is_split.then(|| image("specular_albedo", Rgba16Float)),
            hit_distance: is_split.then(|| image("hit_distance", R32Float)),
        }
    }

    /// Of each pixel, whether its surface is reflective: its roughness is below 0.5, and its depth below `far`. Waits for the GPU.
    pub fn reflective(&self, gpu: &Gpu, far: f32) -> Result<Vec<bool>> {
        let bytes = gpu.read_texture(self.normal_roughness.texture())?;
        let normal_roughness: Vec<[f16; 4]> = bytemuck::pod_collect_to_vec(&bytes);
        let depth: Vec<f32> = bytemuck::pod_collect_to_vec(&gpu.read_texture(self.depth.texture())?);
        let is_reflective = |([.., roughness], depth): (&[f16; 4], &f32)| {
            roughness.to_f32() < REFLECTIVE_ROUGHNESS && *depth < far
        };
        Ok(normal_roughness.iter().zip(&depth).map(is_reflective).collect())
    }
}
