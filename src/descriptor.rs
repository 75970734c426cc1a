//! What is fixed when a denoiser is created, and what a device must have for it.

use crate::layout;

/// How to create a [`Denoiser`](crate::Denoiser).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct DenoiserDescriptor {
    /// Render size in pixels, or the largest of them, where frames come with a [`Viewport`](crate::Viewport). At least 1x1.
    pub width: u32,
    /// See [`width`](Self::width).
    pub height: u32,
}

impl DenoiserDescriptor {
    /// For a render size in pixels.
    pub const fn new(width: u32, height: u32) -> Self {
        Self { width, height }
    }

    /// What `wgpu::DeviceDescriptor::required_limits` must be at least: WebGPU's defaults up to 5120x2880 and beyond, more only
    /// where the size asks for it. Join it with your own by `Limits::or_better_values_from`.
    pub fn required_limits(&self) -> wgpu::Limits {
        let needs = layout::Needs::new(self);
        let mut limits = wgpu::Limits::default();
        limits.max_texture_dimension_2d = limits.max_texture_dimension_2d.max(needs.side);
        limits.max_storage_buffer_binding_size = limits.max_storage_buffer_binding_size.max(needs.buffer);
        limits.max_buffer_size = limits.max_buffer_size.max(needs.buffer);
        limits
    }
}

/// Features that a device must be created with: none.
pub const REQUIRED_FEATURES: wgpu::Features = wgpu::Features::empty();

/// Features that quell makes use of where the device has them: `TIMESTAMP_QUERY`, for budgets of time
/// ([`Budget::Milliseconds`](crate::Budget)) and [`Timestamps`](crate::Timestamps), and `PIPELINE_CACHE`, for
/// [`Pipelines::with_cache`](crate::Pipelines::with_cache). Ask for those that the adapter has:
/// `adapter.features() & OPTIONAL_FEATURES`.
pub const OPTIONAL_FEATURES: wgpu::Features =
    wgpu::Features::TIMESTAMP_QUERY.union(wgpu::Features::PIPELINE_CACHE);
