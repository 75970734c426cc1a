//! What several cameras take, each with a history of its own and all with one set of pipelines.

use crate::bench::percentiles::Percentiles;
use crate::bench::{BenchOptions, set_up, trace};
use crate::gpu::Gpu;
use crate::method::{MethodFrame, MethodRunner};
use anyhow::{Context, Result};
use serde::Serialize;
use std::fmt;
use std::time::Instant;

/// How many there are at a time: a camera, two eyes, a screen split in four.
const COUNTS: [usize; 3] = [1, 2, 4];

/// What so many views take.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Views {
    pub views: usize,
    /// All views of a frame in one submission, by the wall clock until it is done.
    pub frame_ms: Percentiles,
    /// All views.
    pub memory_bytes: u64,
}

/// Denoises a walk as seen by one, two and four cameras of `size` pixels each, which take turns frame by frame. All see the same.
pub fn views(gpu: &Gpu, options: &BenchOptions, size: [u32; 2]) -> Result<Vec<Views>> {
    let (walk, runners) = set_up(gpu, options, size)?;
    let first = runners.first().context("no method to time")?;
    let group =
        |&count: &usize| (0..count).map(|_| MethodRunner::for_another_view(gpu, first, size)).collect();
    let mut groups: Vec<Vec<MethodRunner>> = COUNTS.iter().map(group).collect::<Result<_>>()?;
    let mut frame_ms = vec![Vec::new(); groups.len()];
    for i in 0..options.warm_up + options.frames {
        trace(gpu, &walk, i)?;
        let frame = MethodFrame::new(walk.gbuffer(), walk.view(i).camera, walk.is_cut(i), &options.settings);
        for turn in 0..groups.len() {
            let which = (turn + i as usize) % groups.len();
            let ms = submit(gpu, &mut groups[which], &frame)?;
            if i >= options.warm_up {
                frame_ms[which].push(ms);
            }
        }
    }
    let report = |(group, frame_ms): (&Vec<MethodRunner>, &Vec<f64>)| Views {
        views: group.len(),
        frame_ms: Percentiles::of(frame_ms),
        memory_bytes: group.iter().flat_map(MethodRunner::memory).map(|allocation| allocation.bytes).sum(),
    };
    Ok(groups.iter().zip(&frame_ms).map(report).collect())
}

fn submit(gpu: &Gpu, views: &mut [MethodRunner], frame: &MethodFrame<'_>) -> Result<f64> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    for view in views {
        view.encode(gpu, &mut encoder, frame)?;
    }
    let commands = encoder.finish();
    let start = Instant::now();
    gpu.queue.submit([commands]);
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).context("waiting for the GPU")?;
    Ok(start.elapsed().as_nanos() as f64 / 1e6)
}

impl fmt::Display for Views {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let megabytes = self.memory_bytes as f64 * 1e-6;
        let name = if self.views == 1 { "view" } else { "views" };
        write!(f, "{} {name}: median {:.3} ms, {megabytes:.2} MB", self.views, self.frame_ms.median)
    }
}
