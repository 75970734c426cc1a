//! Copies of small buffers on their way from the GPU, read without blocking.

use crate::gpu::catch;
use std::collections::VecDeque;
use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
};

/// What was copied at the end of frames; `M` tells what each copy is about.
#[derive(Debug)]
pub(crate) struct Readback<M> {
    pending: VecDeque<Pending<M>>,
}

#[derive(Debug)]
struct Pending<M> {
    about: M,
    buffer: wgpu::Buffer,
    is_mapped: Arc<AtomicBool>,
}

/// More frames than any caller has in flight. Encoders that were dropped leave their copies here, until these fall out.
const MOST_PENDING: usize = 8;

impl<M> Default for Readback<M> {
    fn default() -> Self {
        Self { pending: VecDeque::new() }
    }
}

impl<M> Readback<M> {
    /// Records a copy of all of `sources`, one behind the other; it is mapped when the caller's submission is done.
    pub fn record(
        &mut self,
        device: &wgpu::Device,
        encoder: &mut wgpu::CommandEncoder,
        sources: &[&wgpu::Buffer],
        about: M,
    ) {
        let create = || {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("quell readback"),
                size: sources.iter().map(|source| source.size()).sum(),
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        // Without memory for it a frame goes without.
        let Ok(buffer) = catch(device, create) else { return };
        let mut end = 0;
        for source in sources {
            encoder.copy_buffer_to_buffer(source, 0, &buffer, end, source.size());
            end += source.size();
        }
        let is_mapped = Arc::new(AtomicBool::new(false));
        let mapped = Arc::clone(&is_mapped);
        encoder.map_buffer_on_submit(&buffer, wgpu::MapMode::Read, .., move |result| {
            mapped.store(result.is_ok(), Ordering::Release);
        });
        if self.pending.len() == MOST_PENDING {
            self.pending.pop_front();
        }
        self.pending.push_back(Pending { about, buffer, is_mapped });
    }

    /// The newest copy that has arrived since the last call. Older ones will not be asked for any more.
    pub fn newest<T: bytemuck::Pod>(&mut self) -> Option<(M, Vec<T>)> {
        let is_mapped = |pending: &Pending<M>| pending.is_mapped.load(Ordering::Acquire);
        let newest = self.pending.iter().rposition(is_mapped)?;
        let Pending { about, buffer, .. } = self.pending.drain(..=newest).next_back()?;
        let range = buffer.slice(..).get_mapped_range().ok()?;
        Some((about, bytemuck::pod_collect_to_vec(&range)))
    }

    /// All copies that have arrived since the last call, oldest first.
    pub fn arrived<T: bytemuck::Pod>(&mut self) -> Vec<Vec<T>> {
        let is_mapped = |pending: &Pending<M>| pending.is_mapped.load(Ordering::Acquire);
        // Those of encoders that were dropped never arrive; the ones behind them do.
        let (arrived, pending) = self.pending.drain(..).partition(is_mapped);
        self.pending = pending;
        let read = |Pending { buffer, .. }: Pending<M>| {
            let range = buffer.slice(..).get_mapped_range().ok()?;
            Some(bytemuck::pod_collect_to_vec(&range))
        };
        VecDeque::into_iter(arrived).filter_map(read).collect()
    }
}
