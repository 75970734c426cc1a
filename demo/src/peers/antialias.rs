//! Temporal antialiasing of what a method makes of a jittered camera: one way to do what the denoiser leaves to its user.

use super::frame::{FrameUniform, PeerFrame};
use super::{shaders, views};
use crate::compute::{Binding, Pass};
use crate::gbuffer::{GBuffer, image};
use crate::gpu::Gpu;
use wgpu::TextureFormat::Rgba16Float;

/// A pipeline and the history of one sequence.
#[derive(Debug)]
pub struct Antialias {
    pass: Pass,
    frame: FrameUniform,
    /// `[parity]` is written this frame, the other one read.
    outputs: [wgpu::TextureView; 2],
    parity: usize,
}

impl Antialias {
    pub fn new(device: &wgpu::Device, width: u32, height: u32) -> Self {
        use Binding::{Store, Texels, Uniform};
        // Image, motion, depth, prev_output.
        let bindings = [Uniform, Texels, Texels, Texels, Texels, Store(Rgba16Float)];
        let output = || image(device, "antialiased", [width, height], Rgba16Float);
        Self {
            pass: shaders::pass(device, "antialias", &bindings, &[]),
            frame: FrameUniform::new(device),
            outputs: [output(), output()],
            parity: 0,
        }
    }

    /// The last frame that was encoded: `Rgba16Float`, scene-linear; alpha is its own. Frames take turns with two images.
    pub fn output(&self) -> &wgpu::TextureView {
        &self.outputs[self.parity]
    }

    /// Records one frame: `image` is denoised, of the size and camera of `gbuffer`. Submit `encoder` before the next call: the
    /// parameters are written through the queue.
    pub fn encode(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        gbuffer: &GBuffer,
        image: &wgpu::TextureView,
        frame: &PeerFrame,
    ) {
        self.frame.update(gpu, gbuffer, frame);
        let previous = self.parity;
        self.parity ^= 1;
        let images = [image, &gbuffer.motion, &gbuffer.depth, &self.outputs[previous], self.output()];
        let resources = views(self.frame.binding(), &images);
        self.pass.run(&gpu.device, encoder, &resources, [gbuffer.width, gbuffer.height], None);
    }
}
