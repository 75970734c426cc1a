//! A profiler as engines have one: quell's passes become its scopes, timed on the CPU as they are recorded and, where the device
//! has timestamps, on the GPU. Those of CPU adapters do not wait for compute passes, so single passes mean little there.

use quell::{PASSES, PassProfiler, PassTimestamps};
use std::cell::RefCell;
use std::time::{Duration, Instant};
use wgpu::{CommandEncoder, QuerySet};

/// For the passes of one denoiser in one frame.
#[derive(Debug)]
pub struct Profiler {
    /// Scope `i` has queries `2 i` and `2 i + 1`.
    queries: Option<QuerySet>,
    scopes: RefCell<Vec<Scope>>,
}

#[derive(Debug, Clone, Copy)]
pub struct Scope {
    pub name: &'static str,
    pub recording: Duration,
    pub gpu_ms: Option<f64>,
    began: Instant,
}

impl PassProfiler for Profiler {
    fn begin(&self, pass: &'static str, _: &mut CommandEncoder) -> Option<PassTimestamps> {
        let mut scopes = self.scopes.borrow_mut();
        let first = 2 * scopes.len() as u32;
        scopes.push(Scope { name: pass, recording: Duration::ZERO, gpu_ms: None, began: Instant::now() });
        let query_set = self.queries.clone()?;
        Some(PassTimestamps { query_set, begin: Some(first), end: Some(first + 1) })
    }

    fn end(&self, _: &'static str, _: &mut CommandEncoder) {
        if let Some(scope) = self.scopes.borrow_mut().last_mut() {
            scope.recording = scope.began.elapsed();
        }
    }
}

impl Profiler {
    pub fn new(device: &wgpu::Device) -> Self {
        let has_timestamps = device.features().contains(wgpu::Features::TIMESTAMP_QUERY);
        let queries = has_timestamps.then(|| {
            device.create_query_set(&wgpu::QuerySetDescriptor {
                label: Some("profiler"),
                ty: wgpu::QueryType::Timestamp,
                count: 2 * PASSES.len() as u32,
            })
        });
        Self { queries, scopes: RefCell::default() }
    }

    /// What the frame's scopes took. Submits and waits, which an engine would leave to later frames.
    pub fn read(&self, device: &wgpu::Device, queue: &wgpu::Queue) -> anyhow::Result<Vec<Scope>> {
        let mut scopes = self.scopes.take();
        let Some(queries) = self.queries.as_ref().filter(|_| !scopes.is_empty()) else {
            return Ok(scopes);
        };
        let count = 2 * scopes.len() as u32;
        let buffer = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("profiler"),
            size: u64::from(count) * u64::from(wgpu::QUERY_SIZE),
            usage: wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let mut encoder = device.create_command_encoder(&Default::default());
        encoder.resolve_query_set(queries, 0..count, &buffer, 0);
        queue.submit([encoder.finish()]);
        let bytes = crate::download(device, queue, &buffer)?;
        let ticks: Vec<u64> = bytemuck::pod_collect_to_vec(&bytes);
        let ms_per_tick = f64::from(queue.get_timestamp_period()) * 1e-6;
        for (scope, pair) in scopes.iter_mut().zip(ticks.chunks_exact(2)) {
            scope.gpu_ms = Some(pair[1].saturating_sub(pair[0]) as f64 * ms_per_tick);
        }
        Ok(scopes)
    }
}
