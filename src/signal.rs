//! What outlives a frame of one of the signals that are denoised apart.

use crate::gpu::{buffer, image, words};
use crate::layout::{self, LEVELS_WORDS};
use crate::{Allocation, Memory};
use wgpu::{Buffer, BufferUsages, TextureFormat, TextureView};

/// The temporal mean and its noise are replaced in place: `reproject` reads them and writes a copy, `accumulate` reads the copy
/// and writes them.
#[derive(Debug)]
pub(crate) struct Signal {
    /// Temporal mean of demodulated radiance, effective sample count in w.
    pub history: TextureView,
    /// How far samples scatter, and how far the mean is off, by chance.
    pub noise: TextureView,
    /// One per tile. Under a budget they outlive the frame.
    pub models: Buffer,
    /// The window of each tile's model and its age; 0 for no model. Outlives the frame.
    pub windows: Buffer,
    /// `windows` of the frame before, later what they come to in this one.
    pub kept: Buffer,
    /// Per level: arguments of an indirect dispatch, number of models; then the number of models that were kept.
    pub levels: Buffer,
}

impl Signal {
    pub fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let tiles = layout::count(layout::tiles(size));
        let counted = BufferUsages::COPY_DST | BufferUsages::COPY_SRC;
        Self {
            history: image(device, "quell history", size, TextureFormat::Rgba16Float),
            noise: image(device, "quell noise", size, TextureFormat::R32Uint),
            models: buffer(device, "quell models", layout::models(tiles)),
            windows: words(device, "quell windows", tiles, counted),
            kept: words(device, "quell kept", tiles, BufferUsages::COPY_DST),
            levels: words(device, "quell levels", LEVELS_WORDS.into(), counted | BufferUsages::INDIRECT),
        }
    }

    /// Under these names, in this order.
    pub fn add_memory(&self, memory: &mut Memory, names: [&'static str; 5]) {
        let [history, noise, models, windows, kept] = names;
        memory
            .history
            .extend([Allocation::of_image(history, &self.history), Allocation::of_image(noise, &self.noise)]);
        memory.models.extend([
            Allocation::of_buffer(models, &self.models),
            Allocation::of_buffer(windows, &self.windows),
            Allocation::of_buffer(kept, &self.kept),
        ]);
    }

    /// Clears what the passes count in, and hands on which models the frame before had, where that is of this one's tiles.
    pub fn clear(&self, encoder: &mut wgpu::CommandEncoder, knows_models: bool) {
        if knows_models {
            encoder.copy_buffer_to_buffer(&self.windows, 0, &self.kept, 0, self.kept.size());
        } else {
            encoder.clear_buffer(&self.kept, 0, None);
        }
        encoder.clear_buffer(&self.windows, 0, None);
        encoder.clear_buffer(&self.levels, 0, None);
    }
}
