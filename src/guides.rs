//! The surfaces of this frame and of the one before.

use crate::gpu::image;
use crate::{Allocation, Memory};
use wgpu::{TextureFormat, TextureView};

/// The previous frame's surfaces are read while the current one's are written.
#[derive(Debug)]
pub(crate) struct Guides {
    /// Packed surfaces: normal, depth, material, id.
    images: [TextureView; 2],
    current: usize,
}

impl Guides {
    pub fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let guide = || image(device, "quell guide", size, TextureFormat::Rg32Uint);
        Self { images: [guide(), guide()], current: 0 }
    }

    pub fn add_memory(&self, memory: &mut Memory) {
        memory.history.extend([
            Allocation::of_image("guide", self.current()),
            Allocation::of_image("previous_guide", self.previous()),
        ]);
    }

    pub fn current(&self) -> &TextureView {
        &self.images[self.current]
    }

    pub fn previous(&self) -> &TextureView {
        &self.images[1 - self.current]
    }

    /// The current surfaces become the previous ones.
    pub fn swap(&mut self) {
        self.current = 1 - self.current;
    }
}
