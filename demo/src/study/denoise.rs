//! Denoising the still image in different ways.

use crate::gbuffer::GBuffer;
use crate::gpu::Gpu;
use crate::image::ImageRgb;
use crate::method::{Method, MethodFrame, MethodRunner, output_image};
use anyhow::{Context, Result};
use quell::{Camera, DebugView, Settings};
use std::time::Instant;

/// A denoiser for one image without history.
#[derive(Debug)]
pub struct StillDenoiser<'a> {
    gpu: &'a Gpu,
    gbuffer: &'a GBuffer,
    camera: Camera,
    runner: MethodRunner,
    debug: wgpu::TextureView,
}

impl<'a> StillDenoiser<'a> {
    pub fn new(gpu: &'a Gpu, gbuffer: &'a GBuffer, camera: Camera) -> Result<Self> {
        let (width, height) = (gbuffer.width, gbuffer.height);
        Ok(Self {
            gpu,
            gbuffer,
            camera,
            runner: MethodRunner::new(gpu, Method::Quell, width, height)?,
            debug: output_image(&gpu.device, width, height),
        })
    }

    /// Denoises what the tracer wrote last. Returns the milliseconds from submission until the GPU is done.
    pub fn run(&mut self, settings: &Settings, debug: Option<DebugView>) -> Result<f64> {
        let mut frame = MethodFrame::new(self.gbuffer, self.camera, true, settings);
        frame.debug = debug.map(|view| (view, &self.debug));
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.runner.encode(self.gpu, &mut encoder, &frame)?;
        let start = Instant::now();
        self.gpu.queue.submit([encoder.finish()]);
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
        Ok(start.elapsed().as_secs_f64() * 1e3)
    }

    /// The denoised image, and the number of models it was made with.
    pub fn denoised(&mut self, settings: &Settings) -> Result<(ImageRgb, u32)> {
        self.run(settings, None)?;
        let models = self.runner.models().context("the denoiser gave no statistics of a finished frame")?;
        Ok((ImageRgb::read_back(self.gpu, self.runner.output().texture())?, models))
    }

    pub fn debug_view(&mut self, settings: &Settings, view: DebugView) -> Result<ImageRgb> {
        self.run(settings, Some(view))?;
        ImageRgb::read_back(self.gpu, self.debug.texture())
    }
}
