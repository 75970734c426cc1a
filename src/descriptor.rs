//! What is fixed when a denoiser is created.

/// How to create a [`Denoiser`](crate::Denoiser).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DenoiserDescriptor {
    /// Render size in pixels: every image of a frame has exactly this size. At least 1x1.
    pub width: u32,
    /// See [`width`](Self::width).
    pub height: u32,
}
