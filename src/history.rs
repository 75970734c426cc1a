//! What outlives a frame.

use crate::Allocation;
use crate::gpu::image;
use wgpu::{TextureFormat, TextureView};

/// The temporal mean and its noise are replaced in place: `reproject` reads them and writes a copy, `accumulate` reads the copy
/// and writes them. Of the surfaces, the previous frame's are read while the current one's are written.
#[derive(Debug)]
pub(crate) struct History {
    /// Temporal mean of demodulated radiance, effective sample count in w.
    pub mean: TextureView,
    /// How far samples scatter, and how far the mean is off by chance.
    pub noise: TextureView,
    /// Packed surfaces: normal, depth, material, id.
    guides: [TextureView; 2],
    current: usize,
}

impl History {
    pub fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let guide = || image(device, "quell guide", size, TextureFormat::Rg32Uint);
        Self {
            mean: image(device, "quell history", size, TextureFormat::Rgba16Float),
            noise: image(device, "quell noise", size, TextureFormat::R32Uint),
            guides: [guide(), guide()],
            current: 0,
        }
    }

    pub fn memory(&self) -> Vec<Allocation> {
        vec![
            Allocation::of_image("history", &self.mean),
            Allocation::of_image("noise", &self.noise),
            Allocation::of_image("guide", self.guide()),
            Allocation::of_image("previous_guide", self.previous_guide()),
        ]
    }

    pub fn guide(&self) -> &TextureView {
        &self.guides[self.current]
    }

    pub fn previous_guide(&self) -> &TextureView {
        &self.guides[1 - self.current]
    }

    /// The current surfaces become the previous ones.
    pub fn swap(&mut self) {
        self.current = 1 - self.current;
    }
}
