//! The images that the path tracer writes and the denoiser reads, on the GPU.

/// One frame's inputs of the denoiser; each made by [`image()`].
#[derive(Debug)]
pub struct GBuffer {
    pub width: u32,
    pub height: u32,
    /// `Rgba32Float`: noisy radiance, emission included; the sky at a miss.
    pub radiance: wgpu::TextureView,
    /// `Rgba16Float`: albedo at the first hit, 1 at a miss.
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
    pub fn new(device: &wgpu::Device, width: u32, height: u32) -> Self {
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
        }
    }
}
