//! What outlives a frame, in two copies: the passes read the previous frame's and write the current one's.

use crate::Allocation;
use crate::gpu::image;
use wgpu::{TextureFormat, TextureView};

/// One frame's copy.
#[derive(Debug)]
pub(crate) struct HistoryImages {
    /// Packed surfaces: normal, depth, material, id.
    pub guide: TextureView,
    /// Temporal mean of demodulated radiance, effective sample count in w.
    pub mean: TextureView,
    /// How far samples scatter, and how far the mean is off by chance.
    pub noise: TextureView,
}

#[derive(Debug)]
pub(crate) struct History {
    copies: [HistoryImages; 2],
    current: usize,
}

impl History {
    pub fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let copy = || HistoryImages {
            guide: image(device, "quell guide", size, TextureFormat::Rgba32Uint),
            mean: image(device, "quell history", size, TextureFormat::Rgba16Float),
            noise: image(device, "quell noise", size, TextureFormat::Rgba16Float),
        };
        Self { copies: [copy(), copy()], current: 0 }
    }

    pub fn memory(&self) -> Vec<Allocation> {
        let of_both = |name, image: fn(&HistoryImages) -> &TextureView| {
            let bytes = self.copies.iter().map(|copy| Allocation::of_image(name, image(copy)).bytes).sum();
            Allocation { name, bytes }
        };
        vec![
            of_both("guide", |copy| &copy.guide),
            of_both("history", |copy| &copy.mean),
            of_both("noise", |copy| &copy.noise),
        ]
    }

    pub fn current(&self) -> &HistoryImages {
        &self.copies[self.current]
    }

    pub fn previous(&self) -> &HistoryImages {
        &self.copies[1 - self.current]
    }

    /// What was current becomes previous.
    pub fn swap(&mut self) {
        self.current = 1 - self.current;
    }
}
