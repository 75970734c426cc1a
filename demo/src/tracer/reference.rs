//! The mean of many frames' radiance.

use super::passes::Passes;
use crate::gbuffer::image;
use crate::gpu::Gpu;
use anyhow::{Context, Result};
use std::sync::Mutex;
use wgpu::util::DeviceExt;

/// Accumulated radiance of one view. Two images in turn, since WebGPU has no image of four floats that a pass can
/// both read and write.
#[derive(Debug)]
pub struct ReferenceImage {
    means: [wgpu::TextureView; 2],
    state: Mutex<State>,
}

#[derive(Debug, Clone, Copy, Default)]
struct State {
    samples: u32,
    /// Which of `means` holds the latest.
    latest: usize,
}

impl ReferenceImage {
    pub fn new(device: &wgpu::Device, width: u32, height: u32) -> Self {
        let mean = || image(device, "reference", [width, height], wgpu::TextureFormat::Rgba32Float);
        Self { means: [mean(), mean()], state: Mutex::default() }
    }

    /// Forgets what was accumulated.
    pub fn clear(&self) {
        *self.state() = State::default();
    }

    /// Samples per pixel recorded so far.
    pub fn samples(&self) -> u32 {
        self.state().samples
    }

    /// `Rgba32Float`: mean radiance, number of samples in w. Changes place with every call that accumulates.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.means[self.state().latest]
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [u32; 2] {
        let size = self.means[0].texture().size();
        [size.width, size.height]
    }

    /// Mean radiance per pixel, rows from the top. Waits for the GPU.
    ///
    /// # Errors
    /// Where nothing was accumulated, or reading back fails.
    pub fn resolve(&self, gpu: &Gpu) -> Result<Vec<[f32; 3]>> {
        anyhow::ensure!(self.samples() > 0, "the reference has no samples yet");
        let bytes = gpu.read_texture(self.view().texture()).context("reading a reference back")?;
        let texels = bytes.chunks_exact(16).map(bytemuck::pod_read_unaligned::<[f32; 4]>);
        Ok(texels.map(|[r, g, b, _]| [r, g, b]).collect())
    }

    pub(super) fn add(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        passes: &Passes,
        radiance: &wgpu::TextureView,
        spp: u32,
    ) {
        let mut state = self.state();
        let is_first = u32::from(state.samples == 0);
        let parameters = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("accumulate"),
            contents: bytemuck::cast_slice(&[spp, is_first]),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let next = 1 - state.latest;
        passes.accumulate(
            gpu,
            encoder,
            radiance,
            [&self.means[state.latest], &self.means[next]],
            &parameters,
        );
        *state = State { samples: state.samples + spp, latest: next };
    }

    fn state(&self) -> std::sync::MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}
