//! Where the times come from that a [`Budget::Milliseconds`](crate::Budget) is kept by, and what plan they lead to.

use crate::budget::{Bounds, Controller, EARLY, Plan, Reading};
use crate::layout;
use crate::readback::Readback;
use crate::{FrameInputs, Notice, Settings, Statistics};
use wgpu::{BufferUsages, ComputePassTimestampWrites, Features, QueryType};

/// Pixels for one model of a signal while no time is known.
const PIXELS_A_MODEL: u64 = 256;
/// By how many frames at most a time that the caller measured is late.
const CALLERS_LATENCY: u32 = EARLY + 1;
/// Frames without a time after which there is none to be expected.
const PATIENCE: u32 = 8;

/// Chooses what frames may do by time. Exists while there is a budget of time.
#[derive(Debug)]
pub(crate) struct Pacing {
    controller: Controller,
    timer: Option<Timer>,
    frames: u32,
    is_timed: bool,
}

impl Pacing {
    /// Starts at a frame.
    pub fn new(device: &wgpu::Device, bounds: Bounds, frame: u32) -> Self {
        Self {
            controller: Controller::new(bounds, frame),
            timer: device.features().contains(Features::TIMESTAMP_QUERY).then(|| Timer::new(device)),
            frames: 0,
            is_timed: false,
        }
    }

    /// Notes that history starts anew in `frame`.
    pub fn restart(&mut self, frame: u32) {
        self.controller.restart(frame);
    }

    /// What `frame` may do, from what has arrived by now.
    pub fn plan(
        &mut self,
        queue: &wgpu::Queue,
        inputs: &FrameInputs<'_>,
        statistics: Option<Statistics>,
        (bounds, target_ms): (Bounds, f32),
        frame: u32,
    ) -> Plan {
        self.controller.rebound(bounds, frame);
        let own = self.timer.as_mut().and_then(|timer| timer.newest(queue));
        let measured =
            inputs.measured_ms.map(|ms| Reading { frame: frame.saturating_sub(CALLERS_LATENCY), ms });
        let reading = if inputs.measured_ms.is_some() { measured } else { own };
        self.is_timed |= self.timer.is_some() || reading.is_some();
        self.frames = self.frames.saturating_add(1);
        if let Some(reading) = reading {
            self.controller.add_time(reading);
        }
        if let Some(statistics) = statistics {
            self.controller.add_models(statistics.frame, statistics.models());
        }
        self.controller.plan(target_ms, frame)
    }

    /// What the caller should know.
    pub fn notice(&self) -> Option<Notice> {
        (!self.is_timed && self.frames >= PATIENCE).then_some(Notice::NoTimestamps)
    }

    /// Marks the begin of a frame's passes on the GPU.
    pub fn begin(&self, encoder: &mut wgpu::CommandEncoder) {
        if let Some(timer) = &self.timer {
            timer.mark(encoder, Some(0), None);
        }
    }

    /// Marks their end, and has the times copied.
    pub fn end(&mut self, device: &wgpu::Device, encoder: &mut wgpu::CommandEncoder, frame: u32) {
        if let Some(timer) = &mut self.timer {
            timer.mark(encoder, None, Some(1));
            encoder.resolve_query_set(&timer.queries, 0..2, &timer.resolved, 0);
            timer.copies.record(device, encoder, &[&timer.resolved], frame);
        }
    }
}

/// Between what a frame of `size` pixels and so many signals may be paced.
pub(crate) fn bounds(settings: &Settings, size: [u32; 2], signals: u32) -> Bounds {
    let models = [layout::least_models(size), layout::count(layout::tiles(size))];
    Bounds {
        models: models.map(|models| models as u32 * signals),
        start: layout::count(size).div_ceil(PIXELS_A_MODEL) as u32 * signals,
        savings: [settings.savings, settings.most_savings.max(settings.savings)],
    }
}

/// Times frames by timestamps of its own: those that the caller may want take the passes, which have room for one pair.
#[derive(Debug)]
struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    copies: Readback<u32>,
}

impl Timer {
    fn new(device: &wgpu::Device) -> Self {
        Self {
            queries: device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("quell frame time"),
                ty: QueryType::Timestamp,
                count: 2,
            }),
            resolved: device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("quell frame time"),
                size: 2 * u64::from(wgpu::QUERY_SIZE),
                usage: BufferUsages::QUERY_RESOLVE | BufferUsages::COPY_SRC,
                mapped_at_creation: false,
            }),
            copies: Readback::default(),
        }
    }

    /// An empty pass with a timestamp: portable, unlike timestamps between passes.
    fn mark(&self, encoder: &mut wgpu::CommandEncoder, begin: Option<u32>, end: Option<u32>) {
        encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
            label: Some("quell frame time"),
            timestamp_writes: Some(ComputePassTimestampWrites {
                query_set: &self.queries,
                beginning_of_pass_write_index: begin,
                end_of_pass_write_index: end,
            }),
        });
    }

    fn newest(&mut self, queue: &wgpu::Queue) -> Option<Reading> {
        let (frame, ticks) = self.copies.newest::<u64>()?;
        let ns = ticks[1].saturating_sub(ticks[0]) as f64 * f64::from(queue.get_timestamp_period());
        Some(Reading { frame, ms: (ns / 1e6) as f32 })
    }
}
