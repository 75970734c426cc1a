//! How much GPU memory each resource takes.

/// A resource on the GPU.
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

/// What a denoiser holds on the GPU, by kind; small constant resources are left out. See
/// [`Denoiser::memory`](crate::Denoiser::memory).
#[derive(Debug, Clone, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Memory {
    /// What outlives a frame: temporal means, their noise, the surfaces of two frames.
    pub history: Vec<Allocation>,
    /// Linear models and their windows.
    pub models: Vec<Allocation>,
    /// What is dead after a frame. It could be shared by denoisers that are recorded one after the other.
    pub scratch: Vec<Allocation>,
}

impl Memory {
    /// Everything, kind by kind.
    pub fn allocations(&self) -> impl Iterator<Item = &Allocation> {
        [&self.history, &self.models, &self.scratch].into_iter().flatten()
    }

    /// Bytes of everything.
    pub fn total(&self) -> u64 {
        Self::sum(self.allocations())
    }

    /// Bytes of some of it: `Memory::sum(&memory.history)`.
    pub fn sum<'a>(allocations: impl IntoIterator<Item = &'a Allocation>) -> u64 {
        allocations.into_iter().map(|allocation| allocation.bytes).sum()
    }
}
