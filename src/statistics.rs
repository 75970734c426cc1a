//! What a frame came to, read back without blocking.

use crate::layout::{LEVEL_WORDS, LEVELS};
use std::collections::VecDeque;
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// What a frame came to; see [`Denoiser::statistics`](crate::Denoiser::statistics).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Statistics {
    /// The frame, counted from 0 since the denoiser was created or resized.
    pub frame: u32,
    /// Linear models that were fitted, coarse to fine: at centres every 32, 16 and 8 pixels.
    pub models_by_level: [u32; LEVELS],
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
    pending: VecDeque<Pending>,
    latest: Option<Statistics>,
}

#[derive(Debug)]
struct Pending {
    frame: u32,
    buffer: wgpu::Buffer,
    is_mapped: Arc<AtomicBool>,
}

/// More frames than any caller has in flight. Encoders that were dropped leave their copies here, until these fall out.
const MOST_PENDING: usize = 8;

impl StatisticsReader {
    /// Records a copy of the counters at the end of a frame; it is mapped when the caller's submission is done.
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        levels: &wgpu::Buffer,
        frame: u32,
    ) {
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("quell statistics"),
            size: levels.size(),
            usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        encoder.copy_buffer_to_buffer(levels, 0, &buffer, 0, levels.size());
        let is_mapped = Arc::new(AtomicBool::new(false));
        let mapped = Arc::clone(&is_mapped);
        encoder.map_buffer_on_submit(&buffer, wgpu::MapMode::Read, .., move |result| {
            mapped.store(result.is_ok(), Ordering::Release);
        });
        if self.pending.len() == MOST_PENDING {
            self.pending.pop_front();
        }
        self.pending.push_back(Pending { frame, buffer, is_mapped });
    }

    /// The newest statistics that have arrived.
    pub fn latest(&mut self) -> Option<Statistics> {
        let is_mapped = |pending: &Pending| pending.is_mapped.load(Ordering::Acquire);
        if let Some(newest) = self.pending.iter().rposition(is_mapped) {
            // Older ones will not be asked for any more.
            let arrived = self.pending.drain(..=newest).next_back();
            self.latest = arrived.and_then(|pending| pending.read()).or(self.latest);
        }
        self.latest
    }
}

impl Pending {
    fn read(&self) -> Option<Statistics> {
        let range = self.buffer.slice(..).get_mapped_range().ok()?;
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&range);
        let count = |level: usize| words[(level + 1) * LEVEL_WORDS as usize - 1];
        Some(Statistics { frame: self.frame, models_by_level: std::array::from_fn(count) })
    }
}
