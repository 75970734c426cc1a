//! What a frame costs.

use crate::gpu::Gpu;
use crate::gpu_timer::GpuTimer;
use crate::method::{MethodFrame, MethodRunner};
use anyhow::Result;
use std::time::Instant;

/// Times frames one by one, waiting for each.
pub struct Clock(GpuTimer);

impl Clock {
    /// For methods of at most `passes` passes.
    pub fn new(gpu: &Gpu, passes: usize) -> Self {
        Self(GpuTimer::new(&gpu.device, &gpu.queue, passes as u32))
    }

    /// What [`run`](Self::run) returns.
    pub fn description(&self) -> &'static str {
        if self.0.is_measuring() {
            "time is the median over frames of the sum of all passes, by GPU timestamps"
        } else {
            "time is the median over frames from submission until the work is done, by wall clock"
        }
    }

    /// Denoises a frame and returns its milliseconds.
    pub fn run(&mut self, gpu: &Gpu, runner: &mut MethodRunner, frame: &MethodFrame<'_>) -> Result<f64> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let timestamps = self.0.reserve(runner.passes());
        runner.encode(gpu, &mut encoder, &MethodFrame { timestamps, ..*frame })?;
        self.0.resolve(&mut encoder);
        let start = Instant::now();
        gpu.queue.submit([encoder.finish()]);
        self.0.submitted();
        gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
        let wall = start.elapsed().as_secs_f64() * 1e3;
        let passes = self.0.poll(&gpu.device);
        Ok(if passes.is_empty() { wall } else { passes.iter().map(|(_, ms)| f64::from(*ms)).sum() })
    }
}
