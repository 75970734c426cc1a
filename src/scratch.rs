//! What lives for one frame only.

use crate::gpu::{buffer, image, words};
use crate::layout::{BUCKETS, LEVELS, SAMPLE_BUCKETS};
use crate::{Allocation, Memory, layout};
use wgpu::{Buffer, BufferUsages, TextureFormat, TextureView};

/// What lives for one frame only, or for less: what is dead lends its memory to what comes after.
#[derive(Debug)]
pub(crate) struct Scratch {
    /// Later, where a debug view shows it, the mix weight.
    pub signal: TextureView,
    /// Later, where a debug view shows it, the prediction.
    pub reprojected: TextureView,
    /// Later, where somebody asks for it, the output's expected error.
    pub reprojected_noise: TextureView,
    /// Per tile: of the change of the light, later of the temporal means.
    pub moments: Buffer,
    pub innovations: Buffer,
    pub coverage: Buffer,
    pub centre_list: Buffer,
    /// Per level: tiles by what a model would gain them. Used under a budget only.
    pub histogram: Buffer,
    /// How many pixels are worth how much to sample, and what that is in samples.
    pub sample_histogram: Buffer,
    /// Stand in for optional inputs that did not come.
    pub no_float: TextureView,
    pub no_uint: TextureView,
}

impl Scratch {
    pub fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let tiles = layout::count(layout::tiles(size));
        Self {
            signal: image(device, "quell signal", size, TextureFormat::R32Uint),
            reprojected: image(device, "quell reprojected", size, TextureFormat::Rg32Uint),
            reprojected_noise: image(device, "quell reprojected noise", size, TextureFormat::R32Uint),
            moments: buffer(device, "quell moments", layout::moments(tiles)),
            innovations: buffer(
                device,
                "quell innovations",
                layout::models(layout::count(layout::innovation_centres(size, false))),
            ),
            coverage: words(device, "quell coverage", tiles, BufferUsages::COPY_DST),
            centre_list: buffer(device, "quell centre list", tiles),
            histogram: words(
                device,
                "quell histogram",
                u64::from(BUCKETS) * LEVELS as u64,
                BufferUsages::COPY_DST,
            ),
            sample_histogram: words(
                device,
                "quell sample histogram",
                SAMPLE_BUCKETS + 1,
                BufferUsages::COPY_DST,
            ),
            no_float: image(device, "quell no image", [1, 1], TextureFormat::R32Float),
            no_uint: image(device, "quell no image", [1, 1], TextureFormat::R32Uint),
        }
    }

    pub fn add_memory(&self, memory: &mut Memory) {
        memory.scratch.extend([
            Allocation::of_image("signal", &self.signal),
            Allocation::of_image("reprojected", &self.reprojected),
            Allocation::of_image("reprojected_noise", &self.reprojected_noise),
            Allocation::of_buffer("moments", &self.moments),
            Allocation::of_buffer("innovations", &self.innovations),
            Allocation::of_buffer("coverage", &self.coverage),
            Allocation::of_buffer("centre_list", &self.centre_list),
        ]);
    }
}
