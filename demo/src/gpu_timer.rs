//! GPU times of passes, without ever waiting for the GPU: a ring of query sets that are read back when they are ready.
//!
//! On a device without `TIMESTAMP_QUERY`, and on a CPU adapter, nothing is reserved and nothing is reported.

use crate::compute::timestamp_writes;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};

/// Frames whose times can be under way at once; a frame that finds no free slot goes untimed.
const SLOTS: usize = 4;

const PENDING: u8 = 0;
const MAPPED: u8 = 1;
const FAILED: u8 = 2;

/// Whether the device has timestamps that measure compute passes. On a CPU adapter (Mesa's) they do not wait for them: they
/// would be wrong, not just late.
pub fn has_true_timestamps(device: &wgpu::Device) -> bool {
    let on_cpu = device.adapter_info().device_type == wgpu::DeviceType::Cpu;
    device.features().contains(wgpu::Features::TIMESTAMP_QUERY) && !on_cpu
}

/// Measures labelled passes of a frame.
///
/// Per frame: [`reserve`](Self::reserve) for the passes, [`resolve`](Self::resolve) as the last command,
/// [`submitted`](Self::submitted) after the submission, and [`poll`](Self::poll) at any time for the newest results.
#[derive(Debug)]
pub struct GpuTimer {
    /// Empty where the device has no timestamps.
    slots: Vec<Slot>,
    /// Slot of the frame being recorded, once something is reserved in it.
    current: Option<usize>,
    capacity: u32,
    ns_per_tick: f32,
    frame: u64,
    latest: Vec<(String, f32)>,
    latest_frame: u64,
}

#[derive(Debug)]
struct Slot {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
    /// Label of each pair of queries.
    labels: Vec<String>,
    frame: u64,
    /// Under way: from the first reservation until the results are read.
    busy: bool,
    state: Arc<AtomicU8>,
}

impl GpuTimer {
    /// A timer for at most `capacity` passes a frame.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, capacity: u32) -> Self {
        let count = if has_true_timestamps(device) { SLOTS } else { 0 };
        Self::with_slots(device, queue, capacity, count)
    }

    fn with_slots(device: &wgpu::Device, queue: &wgpu::Queue, capacity: u32, count: usize) -> Self {
        let capacity = capacity.clamp(1, wgpu::QUERY_SET_MAX_QUERIES / 2);
        let buffer = |label, usage| {
            device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: u64::from(2 * capacity) * u64::from(wgpu::QUERY_SIZE),
                usage,
                mapped_at_creation: false,
            })
        };
        let slot = |_| Slot {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("gpu_timer"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * capacity,
            }),
            resolved: buffer(
                "gpu_timer resolved",
                wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            ),
            readback: buffer(
                "gpu_timer readback",
                wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
            ),
            labels: Vec::new(),
            frame: 0,
            busy: false,
            state: Arc::new(AtomicU8::new(PENDING)),
        };
        Self {
            slots: (0..count).map(slot).collect(),
            current: None,
            capacity,
            ns_per_tick: queue.get_timestamp_period(),
            frame: 0,
            latest: Vec::new(),
            latest_frame: 0,
        }
    }

    /// Whether there is anything to measure with.
    pub fn is_measuring(&self) -> bool {
        !self.slots.is_empty()
    }

    /// Reserves queries for passes that follow each other: pass `i` writes `first_query + 2 i` and the one after it.
    /// All must run in this frame: reading a query that was not written can wait for ever. None where there is nothing to
    /// measure with; the passes then run untimed.
    pub fn reserve(&mut self, passes: &[&str]) -> Option<quell::Timestamps<'_>> {
        if self.current.is_none() {
            let free = self.slots.iter().position(|slot| !slot.busy)?;
            self.slots[free].busy = true;
            self.slots[free].labels.clear();
            self.current = Some(free);
        }
        let slot = &mut self.slots[self.current?];
        let first = slot.labels.len();
        if first + passes.len() > self.capacity as usize {
            return None;
        }
        slot.labels.extend(passes.iter().map(|&label| label.to_owned()));
        Some(quell::Timestamps { query_set: &slot.queries, first_query: 2 * first as u32 })
    }

    /// Reserves for one compute pass.
    pub fn reserve_pass(&mut self, label: &str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        timestamp_writes(self.reserve(&[label]), 0)
    }

    /// Records the collection of this frame's times, after all its passes.
    pub fn resolve(&self, encoder: &mut wgpu::CommandEncoder) {
        let Some(slot) = self.current.map(|current| &self.slots[current]) else {
            return;
        };
        let count = 2 * slot.labels.len() as u32;
        if count > 0 {
            encoder.resolve_query_set(&slot.queries, 0..count, &slot.resolved, 0);
            let size = u64::from(count) * u64::from(wgpu::QUERY_SIZE);
            encoder.copy_buffer_to_buffer(&slot.resolved, 0, &slot.readback, 0, size);
        }
    }

    /// Starts reading this frame's times back. Call after the submission of what [`resolve`](Self::resolve) recorded.
    pub fn submitted(&mut self) {
        self.frame += 1;
        let Some(slot) = self.current.take().map(|current| &mut self.slots[current]) else {
            return;
        };
        if slot.labels.is_empty() {
            slot.busy = false;
            return;
        }
        slot.frame = self.frame;
        slot.state.store(PENDING, Ordering::Release);
        let state = Arc::clone(&slot.state);
        slot.readback.slice(..).map_async(wgpu::MapMode::Read, move |result| {
            state.store(if result.is_ok() { MAPPED } else { FAILED }, Ordering::Release);
        });
    }

    /// Label and milliseconds of each pass of the newest frame whose times have arrived; empty before the first.
    pub fn poll(&mut self, device: &wgpu::Device) -> &[(String, f32)] {
        // An error here is a lost device, which the next submission reports.
        let _ = device.poll(wgpu::PollType::Poll);
        for (i, slot) in self.slots.iter_mut().enumerate() {
            if !slot.busy || self.current == Some(i) {
                continue;
            }
            match slot.state.load(Ordering::Acquire) {
                MAPPED => {
                    if slot.frame > self.latest_frame
                        && let Ok(bytes) = slot.readback.slice(..).get_mapped_range()
                    {
                        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes);
                        self.latest = times(&slot.labels, &ticks, self.ns_per_tick);
                        self.latest_frame = slot.frame;
                    }
                    slot.readback.unmap();
                    slot.busy = false;
                }
                FAILED => slot.busy = false,
                _ => {}
            }
            if !slot.busy {
                slot.state.store(PENDING, Ordering::Release);
            }
        }
        &self.latest
    }
}

fn times(labels: &[String], ticks: &[u64], ns_per_tick: f32) -> Vec<(String, f32)> {
    let pairs = labels.iter().zip(ticks.chunks_exact(2));
    let measured = pairs.map(|(label, pair)| {
        // Some drivers let the end come before the begin when a pass takes no time.
        let elapsed = pair[1].saturating_sub(pair[0]);
        (label.clone(), elapsed as f32 * ns_per_tick * 1e-6)
    });
    measured.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Gpu;

    #[test]
    fn ticks_become_milliseconds_and_never_negative() {
        let labels = ["a".to_owned(), "b".to_owned()];
        let found = times(&labels, &[1_000_000, 3_000_000, 5, 4], 0.5);
        assert_eq!(found, [("a".to_owned(), 1.0), ("b".to_owned(), 0.0)]);
    }

    #[test]
    fn times_arrive_without_waiting_and_slots_are_reused() {
        let gpu = Gpu::new().expect("tests need a Vulkan driver");
        assert!(GpuTimer::with_slots(&gpu.device, &gpu.queue, 4, 0).reserve_pass("nothing").is_none());
        // The mechanism works on a CPU adapter too, only its numbers mean nothing.
        let mut timer = GpuTimer::with_slots(&gpu.device, &gpu.queue, 4, SLOTS);
        for _ in 0..3 * SLOTS {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            // More than the capacity is refused, not written out of range.
            assert!(timer.reserve(&["x"; 5]).is_none());
            for label in ["first", "second"] {
                let timestamp_writes = timer.reserve_pass(label);
                encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                    label: Some(label),
                    timestamp_writes,
                });
            }
            timer.resolve(&mut encoder);
            gpu.queue.submit([encoder.finish()]);
            timer.submitted();
            timer.poll(&gpu.device);
        }
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let times = timer.poll(&gpu.device);
        let labels: Vec<&str> = times.iter().map(|(label, _)| label.as_str()).collect();
        assert_eq!(labels, ["first", "second"]);
        assert!(times.iter().all(|(_, ms)| (0.0..1000.0).contains(ms)), "{times:?}");
    }
}
