//! How much GPU memory each resource takes.

/// A resource that a denoiser holds on the GPU; see [`Denoiser::memory`](crate::Denoiser::memory).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Allocation {
    /// As in the shaders.
    pub name: &'static str,
    /// Size in bytes, without what a driver adds by alignment.
    pub bytes: u64,
}

impl Allocation {
    /// What an image of one mip level and one layer takes.
    pub fn of_image(name: &'static str, view: &wgpu::TextureView) -> Self {
        let texture = view.texture();
        let texel = texture.format().block_copy_size(None).unwrap_or_default();
        let bytes = u64::from(texture.width()) * u64::from(texture.height()) * u64::from(texel);
        Self { name, bytes }
    }

    /// What a buffer takes.
    pub fn of_buffer(name: &'static str, buffer: &wgpu::Buffer) -> Self {
        Self { name, bytes: buffer.size() }
    }
}
