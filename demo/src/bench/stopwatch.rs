//! Times single frames and waits for each: by timestamps on a GPU, by the wall clock elsewhere.

use super::is_cpu;
use crate::gpu::Gpu;
use crate::gpu_timer::has_true_timestamps;
use crate::method::{Method, MethodFrame, MethodRunner};
use anyhow::{Context, Result};
use quell::{PassProfiler, PassTimestamps, Timestamps};
use serde::Serialize;
use std::cell::RefCell;
use std::time::{Duration, Instant};

/// What a frame's time is read from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Clock {
    /// From the begin of the first pass to the end of the last, on the GPU.
    GpuTimestamps,
    /// From the submission until the GPU is done, on the CPU.
    Wall,
}

/// How long one frame took.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameTime {
    pub frame_ms: f64,
    /// `encode` and the finishing of its command buffer, where wgpu records what `encode` asked for.
    pub cpu_ms: f64,
    /// As [`MethodRunner::passes`]; by the wall clock those of quell on a CPU adapter, or none.
    pub passes_ms: Vec<f64>,
}

/// Measures frames one by one, with nothing else on the GPU.
#[derive(Debug)]
pub struct Stopwatch {
    /// None where the wall clock is used.
    queries: Option<Queries>,
}

#[derive(Debug)]
struct Queries {
    set: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    readback: wgpu::Buffer,
    ns_per_tick: f64,
}

impl Stopwatch {
    /// For frames of at most `passes` passes.
    pub fn new(gpu: &Gpu, passes: usize) -> Self {
        let clock = if has_true_timestamps(&gpu.device) { Clock::GpuTimestamps } else { Clock::Wall };
        Self::with_clock(gpu, clock, passes)
    }

    fn with_clock(gpu: &Gpu, clock: Clock, passes: usize) -> Self {
        Self { queries: (clock == Clock::GpuTimestamps).then(|| Queries::new(gpu, passes)) }
    }

    pub fn clock(&self) -> Clock {
        if self.queries.is_some() { Clock::GpuTimestamps } else { Clock::Wall }
    }

    /// What the denoiser is to be told of the time that its frame took: that by the wall clock. Timestamps of a CPU adapter say nothing;
    /// by others it times itself.
    pub fn told_ms(&self, time: &FrameTime) -> Option<f32> {
        (self.clock() == Clock::Wall).then_some(time.frame_ms as f32)
    }

    /// Runs one frame and waits for it. `frame`'s own timestamps are replaced.
    pub fn measure(
        &self,
        gpu: &Gpu,
        runner: &mut MethodRunner,
        frame: &MethodFrame<'_>,
    ) -> Result<FrameTime> {
        if self.queries.is_none() && is_cpu(gpu) && runner.method() == Method::Quell {
            return measure_pass_by_pass(gpu, runner, frame);
        }
        let passes = runner.passes().len();
        let timestamps =
            self.queries.as_ref().map(|queries| Timestamps { query_set: &queries.set, first_query: 0 });
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let start = Instant::now();
        runner.encode(gpu, &mut encoder, &MethodFrame { timestamps, ..*frame })?;
        let commands = encoder.finish();
        let cpu_ms = milliseconds(start.elapsed());

        // The timestamps are collected by a command buffer of their own, which `cpu_ms` does not count.
        let collect = self.queries.as_ref().map(|queries| queries.collect(gpu, passes));
        let start = Instant::now();
        gpu.queue.submit([commands].into_iter().chain(collect));
        gpu.device.poll(wgpu::PollType::wait_indefinitely()).context("waiting for the GPU")?;
        let wall_ms = milliseconds(start.elapsed());

        let (frame_ms, passes_ms) = match &self.queries {
            Some(queries) => queries.read(passes)?,
            None => (wall_ms, Vec::new()),
        };
        Ok(FrameTime { frame_ms, cpu_ms, passes_ms })
    }
}

/// By the wall clock: each pass is submitted by itself and waited for. Only where dispatches run one after the other anyway.
fn measure_pass_by_pass(gpu: &Gpu, runner: &mut MethodRunner, frame: &MethodFrame<'_>) -> Result<FrameTime> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let waiting =
        Waiting { gpu, passes_ms: RefCell::new(vec![0.0; runner.passes().len()]), rest_ms: 0.0.into() };
    let start = Instant::now();
    runner.encode(gpu, &mut encoder, &MethodFrame { profiler: Some(&waiting), ..*frame })?;
    waiting.flush(&mut encoder, None);
    let whole_ms = milliseconds(start.elapsed());
    let passes_ms = waiting.passes_ms.into_inner();
    let frame_ms = passes_ms.iter().sum::<f64>() + waiting.rest_ms.into_inner();
    Ok(FrameTime { frame_ms, cpu_ms: whole_ms - frame_ms, passes_ms })
}

/// Submits what was recorded before and after each pass, and waits for it.
#[derive(Debug)]
struct Waiting<'a> {
    gpu: &'a Gpu,
    passes_ms: RefCell<Vec<f64>>,
    /// Of what is in no pass, such as clears.
    rest_ms: RefCell<f64>,
}

impl Waiting<'_> {
    fn flush(&self, encoder: &mut wgpu::CommandEncoder, pass: Option<&str>) {
        let recorded =
            std::mem::replace(encoder, self.gpu.device.create_command_encoder(&Default::default()));
        let commands = recorded.finish();
        let start = Instant::now();
        self.gpu.queue.submit([commands]);
        // A lost device shows at the frame's end.
        let _ = self.gpu.device.poll(wgpu::PollType::wait_indefinitely());
        let ms = milliseconds(start.elapsed());
        match quell::PASSES.iter().position(|name| Some(*name) == pass) {
            Some(place) => self.passes_ms.borrow_mut()[place] += ms,
            None => *self.rest_ms.borrow_mut() += ms,
        }
    }
}

impl PassProfiler for Waiting<'_> {
    fn begin(&self, _: &'static str, encoder: &mut wgpu::CommandEncoder) -> Option<PassTimestamps> {
        self.flush(encoder, None);
        None
    }

    fn end(&self, pass: &'static str, encoder: &mut wgpu::CommandEncoder) {
        self.flush(encoder, Some(pass));
    }
}

impl Queries {
    fn new(gpu: &Gpu, passes: usize) -> Self {
        let count = 2 * passes as u32;
        let buffer = |label, usage| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: u64::from(count) * u64::from(wgpu::QUERY_SIZE),
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        Self {
            set: gpu.device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("bench"),
                ty: wgpu::QueryType::Timestamp,
                count,
            }),
            resolved: buffer("bench resolved", Usage::QUERY_RESOLVE | Usage::COPY_SRC),
            readback: buffer("bench readback", Usage::MAP_READ | Usage::COPY_DST),
            ns_per_tick: f64::from(gpu.queue.get_timestamp_period()),
        }
    }

    /// Commands that fetch a frame's timestamps; they can be read when the GPU is done.
    fn collect(&self, gpu: &Gpu, passes: usize) -> wgpu::CommandBuffer {
        let count = 2 * passes as u32;
        let size = u64::from(count) * u64::from(wgpu::QUERY_SIZE);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        encoder.resolve_query_set(&self.set, 0..count, &self.resolved, 0);
        encoder.copy_buffer_to_buffer(&self.resolved, 0, &self.readback, 0, size);
        // A failure shows when the mapped range is asked for.
        encoder.map_buffer_on_submit(&self.readback, wgpu::MapMode::Read, ..size, |_| {});
        encoder.finish()
    }

    /// Milliseconds of the frame and of its passes.
    fn read(&self, passes: usize) -> Result<(f64, Vec<f64>)> {
        let size = 2 * passes as u64 * u64::from(wgpu::QUERY_SIZE);
        let bytes = self.readback.slice(..size).get_mapped_range().context("reading timestamps")?;
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes);
        drop(bytes);
        self.readback.unmap();
        Ok(spans(&ticks, self.ns_per_tick))
    }
}

/// Milliseconds of the frame and of its passes, from a begin and an end per pass. Passes may overlap.
fn spans(ticks: &[u64], ns_per_tick: f64) -> (f64, Vec<f64>) {
    // Some drivers let the end come before the begin when a pass takes no time.
    let span = |begin: u64, end: u64| end.saturating_sub(begin) as f64 * ns_per_tick / 1e6;
    let begin = ticks.iter().step_by(2).min().copied().unwrap_or_default();
    let end = ticks.iter().skip(1).step_by(2).max().copied().unwrap_or_default();
    (span(begin, end), ticks.chunks_exact(2).map(|pass| span(pass[0], pass[1])).collect())
}

fn milliseconds(duration: Duration) -> f64 {
    duration.as_nanos() as f64 / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gbuffer::Split;
    use crate::method::Method;
    use crate::tracer::Sampling;
    use crate::walk::{Walk, WalkOptions};
    use quell::Settings;

    #[test]
    fn a_frame_lasts_from_its_first_begin_to_its_last_end() {
        // The second pass begins before the first, and outlasts all others.
        let ticks = [2000, 4000, 1000, 13_000, 5000, 6000, 12_000, 11_999];
        let (frame_ms, passes_ms) = spans(&ticks, 500.0);
        assert_eq!(frame_ms, 6.0);
        assert_eq!(passes_ms, [1.0, 6.0, 0.5, 0.0]);
    }

    /// Frames of a tiny walk.
    fn measure(clock: Clock) -> (usize, Vec<FrameTime>) {
        let gpu = Gpu::new().expect("tests need a Vulkan driver");
        let (width, height) = (32, 18);
        let options = WalkOptions {
            scene: None,
            width,
            height,
            frames: 3,
            fps: 30.0,
            start_s: 0.0,
            spp: 1.0,
            sampling: Sampling::Uniform,
            seed: 0,
            jitter: false,
            split: Split::default(),
        };
        let walk = Walk::new(&gpu, options).unwrap();
        let mut runner = MethodRunner::new(&gpu, Method::Quell, width, height).unwrap();
        let passes = runner.passes().len();
        let stopwatch = Stopwatch::with_clock(&gpu, clock, passes + 1);
        assert_eq!(stopwatch.clock(), clock);
        let settings = Settings::default();
        let times = (0..3).map(|i| {
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            walk.trace(&gpu, &mut encoder, i);
            gpu.queue.submit([encoder.finish()]);
            let frame = MethodFrame::new(walk.gbuffer(), walk.view(i).camera, i == 0, &settings);
            stopwatch.measure(&gpu, &mut runner, &frame).unwrap()
        });
        (passes, times.collect())
    }

    #[test]
    fn timestamps_of_all_passes_arrive_with_their_frame() {
        // Mesa's CPU driver takes them at wrong moments, but it does take them, and within the frame.
        let (passes, times) = measure(Clock::GpuTimestamps);
        for time in times {
            assert_eq!(time.passes_ms.len(), passes);
            let longest = time.passes_ms.iter().copied().fold(0.0, f64::max);
            assert!(longest > 0.0 && time.frame_ms >= longest, "{time:?}");
        }
    }

    #[test]
    fn the_wall_clock_waits_for_the_frame() {
        let (passes, times) = measure(Clock::Wall);
        let place = |name| quell::PASSES.iter().position(|pass| *pass == name).unwrap();
        let least = |name| times.iter().map(|time| time.passes_ms[place(name)]).fold(f64::MAX, f64::min);
        let [busy, idle] = ["compose", "debug_view"].map(least);
        assert!(busy > 4.0 * idle, "what has nothing to do takes no time: {busy}, {idle}");
        for time in &times {
            // Submitting alone takes some microseconds, ten passes on a CPU far more.
            assert!(time.frame_ms > 0.1 && time.cpu_ms > 0.0, "{time:?}");
            assert_eq!(time.passes_ms.len(), passes);
            assert!(time.frame_ms >= time.passes_ms.iter().sum(), "{time:?}");
        }
    }
}
