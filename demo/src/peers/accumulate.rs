//! Plain temporal accumulation with reprojection: what history alone gives, without a spatial filter.

use super::frame::{FrameUniform, PeerFrame};
use super::{allocations, shaders, views};
use crate::compute::{Binding, Pass, timestamp_writes};
use crate::gbuffer::{GBuffer, image};
use crate::gpu::Gpu;
use quell::{Allocation, Timestamps};
use wgpu::TextureFormat::{Rg32Uint, Rgba16Float, Rgba32Float};

/// History ping-pong of one accumulator, and its pipeline.
#[derive(Debug)]
pub struct Accumulate {
    pass: Pass,
    frame: FrameUniform,
    /// Mean radiance and count, then surfaces; `[parity]` is written this frame, the other one read.
    history: [(wgpu::TextureView, wgpu::TextureView); 2],
    output: wgpu::TextureView,
    parity: usize,
}

impl Accumulate {
    pub const PASSES: [&str; 1] = ["accumulate"];

    pub fn new(device: &wgpu::Device, width: u32, height: u32) -> Self {
        use Binding::{Integers, Store, Texels, Uniform};
        let image = |label, format| image(device, label, [width, height], format);
        let history = || (image("accumulate mean", Rgba32Float), image("accumulate surface", Rg32Uint));
        let bindings = [
            Uniform,
            Texels,   // radiance
            Texels,   // normal_roughness
            Texels,   // depth
            Texels,   // motion
            Integers, // surface_id
            Integers, // sample_count
            Texels,   // prev_mean
            Integers, // prev_surface
            Store(Rgba32Float),
            Store(Rg32Uint),
            Store(Rgba16Float),
        ];
        Self {
            pass: shaders::pass(device, "accumulate", &bindings, &[]),
            frame: FrameUniform::new(device),
            history: [history(), history()],
            output: image("accumulate output", Rgba16Float),
            parity: 0,
        }
    }

    /// What it holds on the GPU besides its inputs and output.
    pub fn memory(&self) -> Vec<Allocation> {
        let (mean, surface) = &self.history[0];
        allocations(&[("mean", mean, 2), ("surface", surface, 2)])
    }

    /// The mean radiance of the last frame that was encoded, `Rgba16Float`.
    pub fn output(&self) -> &wgpu::TextureView {
        &self.output
    }

    /// Records one frame. Submit `encoder` before the next call: the parameters are written through the queue.
    pub fn encode(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        gbuffer: &GBuffer,
        frame: &PeerFrame,
        timestamps: Option<Timestamps<'_>>,
    ) {
        self.frame.update(gpu, gbuffer, frame);
        self.parity ^= 1;
        let (mean, surface) = &self.history[self.parity];
        let (prev_mean, prev_surface) = &self.history[self.parity ^ 1];
        let resources = views(
            self.frame.binding(),
            &[
                &gbuffer.radiance,
                &gbuffer.normal_roughness,
                &gbuffer.depth,
                &gbuffer.motion,
                &gbuffer.surface_id,
                &gbuffer.sample_count,
                prev_mean,
                prev_surface,
                mean,
                surface,
                &self.output,
            ],
        );
        let size = [gbuffer.width, gbuffer.height];
        self.pass.run(&gpu.device, encoder, &resources, size, timestamp_writes(timestamps, 0));
    }
}
