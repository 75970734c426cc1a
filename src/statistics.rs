//! What a frame came to, read back without blocking.

use crate::layout::{LEVEL_WORDS, LEVELS, LEVELS_WORDS};
use crate::readback::Readback;

/// What a frame came to; see [`Denoiser::statistics`](crate::Denoiser::statistics).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct Statistics {
    /// The frame, counted from 0 since the denoiser was created or resized.
    pub frame: u32,
    /// Linear models that were fitted, coarse to fine: at centres every 32, 16 and 8 pixels.
    pub models_by_level: [u32; LEVELS],
    /// Linear models of earlier frames that were used again, under a [`Budget`](crate::Budget).
    pub models_kept: u32,
    /// How many were allowed to be fitted; none without a budget.
    pub model_limit: Option<u32>,
    /// How many of the [`SAVINGS`](crate::SAVINGS) the frame took.
    pub savings: u32,
}

impl Statistics {
    /// Linear models that were fitted.
    pub fn models(&self) -> u32 {
        self.models_by_level.iter().sum()
    }
}

/// Copies of counters on their way from the GPU.
#[derive(Debug, Default)]
pub(crate) struct StatisticsReader {
    /// By frame, its limit and its savings.
    copies: Readback<(u32, Option<u32>, u32)>,
    latest: Option<Statistics>,
}

impl StatisticsReader {
    /// Records a copy of each signal's counters at the end of a frame.
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        levels: [Option<&wgpu::Buffer>; 2],
        plan: (u32, Option<u32>, u32),
    ) {
        let levels: Vec<_> = levels.into_iter().flatten().collect();
        self.copies.record(device, encoder, &levels, plan);
    }

    /// The newest statistics that have arrived.
    pub fn latest(&mut self) -> Option<Statistics> {
        if let Some(((frame, model_limit, savings), words)) = self.copies.newest::<u32>() {
            let sum =
                |word: usize| words.chunks_exact(LEVELS_WORDS as usize).map(|signal| signal[word]).sum();
            let count = |level: usize| sum((level + 1) * LEVEL_WORDS as usize - 1);
            self.latest = Some(Statistics {
                frame,
                models_by_level: std::array::from_fn(count),
                models_kept: sum(LEVELS_WORDS as usize - 1),
                model_limit,
                savings,
            });
        }
        self.latest
    }
}
