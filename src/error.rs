//! What can go wrong at creation and per frame. Every message names the thing, what was expected and what came.

use crate::Viewport;
use thiserror::Error;

/// What went wrong on the GPU's side.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum DeviceError {
    /// Nothing was created. [`Denoiser::memory`](crate::Denoiser::memory) tells what a denoiser takes; a smaller render size, or
    /// dropping another one, helps.
    #[error("the device is out of memory; nothing was created (a smaller render size takes less)")]
    OutOfMemory,
    /// The device was lost or destroyed: by a driver's reset, say. Everything on it is gone. Create a new device, and on it new
    /// pipelines and a new denoiser; history starts anew. `wgpu::Device::set_device_lost_callback` tells why.
    #[error("the device is lost; create a new one and a new denoiser on it")]
    Lost,
    /// The driver failed, in compiling a pass for example.
    #[error("the device failed: {description}")]
    Failed {
        /// What wgpu says of it.
        description: String,
    },
}

/// Why a [`Denoiser`](crate::Denoiser) or its pipelines could not be created or resized.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CreateError {
    /// A side of the render size is zero.
    #[error("render size is {width}x{height}; both sides must be at least 1 pixel")]
    EmptySize {
        /// Width asked for, in pixels.
        width: u32,
        /// Height asked for, in pixels.
        height: u32,
    },
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The pipelines were compiled on another device.
    #[error(
        "the pipelines are of another device; expected those of the device that was given (after a loss, compile new ones)"
    )]
    OtherDevice,
    /// The device's limits are below what the passes need at this size.
    #[error("device limit `{limit}` is {available}, but quell needs {needed} at {width}x{height}")]
    Limit {
        /// Name of the limit, as in `wgpu::Limits`.
        limit: &'static str,
        /// What is needed.
        needed: u64,
        /// What the device was created with.
        available: u64,
        /// Width asked for, in pixels.
        width: u32,
        /// Height asked for, in pixels.
        height: u32,
    },
}

/// Why a frame was refused. Nothing was recorded and history is as it was.
///
/// A device that is lost is no longer told where errors arrive late, which is in browsers.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum FrameError {
    /// An image does not have the denoiser's render size.
    #[error("image `{image}` is {found_width}x{found_height}, expected the render size {width}x{height}")]
    Size {
        /// Field of [`FrameInputs`](crate::FrameInputs).
        image: &'static str,
        /// Expected width in pixels.
        width: u32,
        /// Expected height in pixels.
        height: u32,
        /// Width that came.
        found_width: u32,
        /// Height that came.
        found_height: u32,
    },
    /// An image ends before the viewport does.
    #[error(
        "image `{image}` is {found_width}x{found_height} and does not hold the viewport of {:?} pixels at {:?}",
        viewport.size, viewport.origin
    )]
    Outside {
        /// Field of [`FrameInputs`](crate::FrameInputs).
        image: &'static str,
        /// The viewport that came.
        viewport: Viewport,
        /// Width that came.
        found_width: u32,
        /// Height that came.
        found_height: u32,
    },
    /// The viewport is empty or larger than what the denoiser was created for.
    #[error("viewport has {:?} pixels at {:?}, expected 1x1 to {largest:?}, the denoiser's render size", viewport.size, viewport.origin)]
    Viewport {
        /// The viewport that came.
        viewport: Viewport,
        /// The denoiser's render size.
        largest: [u32; 2],
    },
    /// The device failed.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// An image has a format outside its row of the contract.
    #[error("image `{image}` has format {found:?}, expected one of {expected:?}{}", told(image))]
    Format {
        /// Field of [`FrameInputs`](crate::FrameInputs).
        image: &'static str,
        /// Formats that work.
        expected: &'static [wgpu::TextureFormat],
        /// Format that came.
        found: wgpu::TextureFormat,
    },
    /// An image was created without a usage that quell needs.
    #[error("image `{image}` has usages {found:?}, {expected:?} is missing")]
    Usage {
        /// Field of [`FrameInputs`](crate::FrameInputs).
        image: &'static str,
        /// Usage that is needed.
        expected: wgpu::TextureUsages,
        /// Usages that came.
        found: wgpu::TextureUsages,
    },
    /// An image is not a single-sampled 2D image of one layer (and of one mip level, where it is written).
    #[error(
        "image `{image}` is {dimension:?} with {layers} layers, {mips} mip levels and {sample_count} samples a pixel, \
         expected a 2D image with 1 of each"
    )]
    Shape {
        /// Field of [`FrameInputs`](crate::FrameInputs).
        image: &'static str,
        /// Dimension that came.
        dimension: wgpu::TextureDimension,
        /// Array layers that came.
        layers: u32,
        /// Mip levels that came; 1 for an image that is only read.
        mips: u32,
        /// Samples per pixel that came.
        sample_count: u32,
    },
    /// An image that is written is also another of the frame's images.
    #[error("image `{image}` is the same texture as `{other}`; it is written, so it must be one of its own")]
    Aliased {
        /// Field of [`FrameInputs`](crate::FrameInputs) that is written.
        image: &'static str,
        /// The other field.
        other: &'static str,
    },
    /// An image that another one belongs to did not come.
    #[error("image `{needed_by}` came without `{image}`, which it belongs to")]
    Missing {
        /// Field of [`FrameInputs`](crate::FrameInputs) that is missing.
        image: &'static str,
        /// The field that came.
        needed_by: &'static str,
    },
    /// A matrix or the jitter of the camera cannot be used.
    #[error("camera `{field}`: {reason}")]
    Camera {
        /// Field of [`Camera`](crate::Camera).
        field: &'static str,
        /// What is wrong with it.
        reason: &'static str,
    },
    /// The time that the caller measured is none.
    #[error("`measured_ms` is {found}, expected a finite number of milliseconds, 0 or more")]
    MeasuredTime {
        /// The value that came.
        found: f32,
    },
    /// A setting lies outside its documented range.
    #[error("setting `{setting}` is {found}, expected {expected}")]
    Setting {
        /// Field of [`Settings`](crate::Settings).
        setting: &'static str,
        /// The range that works.
        expected: &'static str,
        /// The value that came.
        found: f64,
    },
}

/// Where formats depend on what they are said to hold.
fn told(image: &str) -> &'static str {
    match image {
        "depth" => "; others go with another `Conventions::depth`",
        "normal_roughness" => "; others go with another `Conventions::normal_encoding`",
        _ => "",
    }
}
