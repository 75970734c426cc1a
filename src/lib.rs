//! quell is a real-time temporal denoiser for low-spp path-traced frames, as compute passes on [`wgpu`].
//!
//! A renderer gives it noisy radiance and what it knows of the first hits (albedo, normal, depth, motion); quell gives
//! denoised radiance back. One call integrates it: [`Denoiser::encode`] records passes into the caller's encoder. It never
//! submits, blocks or maps; it needs no optional GPU feature and no more than WebGPU's default limits.
//!
//! ```no_run
//! # fn frame(device: &wgpu::Device, queue: &wgpu::Queue, camera: quell::Camera, images: [&wgpu::TextureView; 6])
//! # -> Result<(), Box<dyn std::error::Error>> {
//! # let [radiance, albedo, normal_roughness, depth, motion, output] = images;
//! use quell::{Denoiser, DenoiserDescriptor, FrameInputs, RequiredInputs, Settings};
//!
//! // Once, and again (or `resize`) when the render size changes:
//! let mut denoiser = Denoiser::new(device, &DenoiserDescriptor::new(1920, 1080))?;
//!
//! // Every frame:
//! let mut encoder = device.create_command_encoder(&Default::default());
//! // ... record the path tracer, then:
//! let inputs = FrameInputs::new(RequiredInputs {
//!     radiance,         // noisy, scene-linear
//!     albedo,           // at the first hit
//!     normal_roughness, // world space
//!     depth,            // linear
//!     motion,           // to the previous frame, in UV
//!     output,           // Rgba16Float
//!     camera,
//! });
//! let settings = Settings::default(); // other units, axes and encodings: `Settings::conventions`
//! denoiser.encode(device, queue, &mut encoder, &inputs, &settings)?;
//! queue.submit([encoder.finish()]);
//! # Ok(())
//! # }
//! ```
//!
//! # A frame, step by step
//!
//! The method is sparse linear prediction: few linear models per frame, each fitted to the pixels of a window, predict all
//! pixels. It follows Moon, Iglesias-Guitian, Yoon and Mitchell, "Adaptive Rendering with Linear Predictions" (SIGGRAPH
//! 2015), carried into real time. Each pass is a file in `src/passes/` and a WGSL file of the same name in `shaders/`; what
//! they share is in `shaders/include/`. `src/recording.rs` has them in order. Two passes take several kernels: `fit` places centres
//! by `centres`, under a budget by `gains` and `choose`; `sample_map` counts by `sample_gains` and `sample_rate`. `check` is apart:
//! it is that of [`InputCheck`].
//!
//! 1. **reproject** repairs the inputs (NaN, infinity, negative radiance, zero albedo), takes emission out and divides
//!    by 0.1 + 0.9 albedo, so that what is filtered is close to irradiance; and packs the surface of each pixel into a
//!    *guide*. Then it fetches the pixel's history from where motion says its surface was. Every tap must belong to the
//!    same surface: its id, its normal and its distance from the surface's tangent plane decide. Where all twelve taps do,
//!    the fetch is bicubic (Catmull-Rom) and stays sharp. What the new samples differ by from this history is summed into
//!    moments per tile of 8x8 pixels.
//! 2. **innovation** asks whether the light changed: that difference is regressed on the surface's features over windows of
//!    40x40 pixels; what noise would explain as well is not believed.
//! 3. **accumulate** moves the history by the predicted change and lowers its confidence as a Kalman filter would, so that a
//!    light that was switched leaves no ghost. Glossy surfaces forget as fast as their view turns. Then this frame's
//!    samples, weighted by their number, join the temporal mean. Beside it ride the scatter of one sample, and deviations
//!    that take the same path as the mean but with alternating signs: their squares tell how noisy the mean still is, after
//!    all blending and resampling. In the end it sums, per tile, the weighted first and second moments of features (normal,
//!    position, 1/albedo, surface id, roughness, pixel position) and colour.
//! 4. **fit** places centres coarse to fine, each where no model reaches well yet. At a centre, a window of tiles
//!    grows, and the size whose model has the least predicted error is kept. A model is a ridge regression, whose ridge is
//!    a prior: steep slopes must be earned by samples. A few thousand numbers go in, no pixel is read twice, and the
//!    result is exactly that of recursive least squares over the pixels. Under a [`Budget`] the coarsest level is always
//!    fitted; finer models go where they are expected to gain most, and elsewhere those of earlier frames are kept while
//!    they hold.
//! 5. **compose** predicts every pixel by the models whose windows hold it, blended by tents and by how well they fit, and compares
//!    the prediction with the temporal mean. What they differ by, smoothly and beyond the mean's noise, is the
//!    models' error; it decides how the two are mixed: smooth where the models hold, sharp where no feature explains what is
//!    seen, such as a shadow's edge. Then albedo and emission come back.
//! 6. **sample_map**, on request, turns the expected error into samples per pixel for the next frame, under an average.
//! 7. **debug_view** shows one of these steps, on request.
//!
//! Where [`FrameInputs::specular`] is given, there are two signals, one after the other through the same passes and
//! scratch: first the rest, then the specular radiance, to which `compose` adds the rest. Each has its own albedo, history
//! and models. The specular history follows what is seen in the surface: by the hit distance and the surface's curvature,
//! `reproject` steps to where the half vector was the normal for the previous eye, and takes only taps that showed
//! something as far away; `accumulate` looks in 7x7 pixels for histories that are off in the mean, because what moves in a
//! mirror is smaller than the innovation's windows. With [`FrameInputs::hit_distance`] alone, the samples of each tile
//! choose between the two histories.
//!
//! Each image is read where it is made, and packed into words in between: 55 bytes a pixel are held, 171 are moved in a
//! frame (`tests/cost.md`).
//!
//! On a still view the result converges to the converged image, because the mean's noise falls and the mix follows.
//!
//! # Integration notes
//!
//! - **Colour**: everything is scene-linear. Denoise before exposure, bloom and tonemapping.
//! - **Conventions**: [`Conventions`] tell how you write depth (linear, distance, depth buffer), motion (unit, direction, jitter)
//!   and normals (encoding, space) down, and which way your cameras look.
//! - **Motion**: by default `uv_prev = uv + motion`, y down: the vector points to where
//!   the surface *was*. The debug views [`DebugView::Motion`] and [`DebugView::HistoryLength`] show at once when it is wrong:
//!   history is then black wherever the camera moves.
//! - **Wrong inputs**: [`InputCheck`] says in words which input looks wrong, from some tens of frames.
//! - **Cuts**: say [`HistoryMode::Restart`]. **Resizes**: [`Denoiser::resize`]. **Dynamic resolution**, or images that hold more
//!   than the frame: [`FrameInputs::viewport`].
//! - **Several cameras**: one [`Denoiser`] each, with shared [`Pipelines`].
//! - **Samples**: give [`FrameInputs::sample_count`] where pixels get different numbers of them; those without any are
//!   predicted. A [`SampleMap`] receives what the next frame should be traced with, down to a sixteenth of a sample per
//!   pixel.
//! - **Time**: a [`Budget`] limits the models of a frame, or chooses their number by the frame's time.
//! - **Anti-aliasing**: the output lies where [`Camera::jitter_px`] says, so its edges step from frame to frame as the G-buffer's
//!   do; history is kept without jitter. TAA or an upscaler goes after quell, usually after tonemapping, and takes quell's
//!   output, your motion and the same jitter. Inside quell it would be a second history of the image, before the tonemapping
//!   that it should follow.
//! - **Reflections**: give [`FrameInputs::specular`] and [`FrameInputs::hit_distance`] where the renderer has them; each
//!   alone helps.
//! - **Limits of this version**: in one signal without hit distances, what mirrors show is blurred and noisier while the camera
//!   moves, because glossy surfaces forget as fast as their view turns; a change of the light that is small against the
//!   noise of a few hundred samples is not noticed in one frame and fades in over [`Settings::max_history`] samples.

#![warn(missing_docs)]

mod budget;
mod camera;
#[doc(hidden)]
pub mod check;
mod conventions;
mod denoiser;
mod descriptor;
mod error;
mod frame;
#[doc(hidden)]
pub mod gpu;
mod guides;
mod inputs;
#[doc(hidden)]
pub mod layout;
mod memory;
mod pacing;
#[doc(hidden)]
pub mod passes;
mod profiler;
mod readback;
mod recording;
mod scratch;
mod settings;
mod signal;
mod statistics;
mod validation;

pub use camera::Camera;
pub use check::{Evidence, Finding, InputCheck, Mistake, Untold};
pub use conventions::{
    Conventions, DepthEncoding, Handedness, MotionDirection, MotionUnit, NormalEncoding, NormalSpace,
};
pub use denoiser::Denoiser;
pub use descriptor::{DenoiserDescriptor, OPTIONAL_FEATURES, REQUIRED_FEATURES};
pub use error::{CreateError, DeviceError, FrameError};
pub use frame::{DebugView, FrameOutputs, HistoryMode, Notice};
pub use inputs::{FrameInputs, RequiredInputs, SampleMap, Viewport};
pub use memory::{Allocation, Memory};
pub use passes::Pipelines;
pub use profiler::{PassProfiler, PassTimestamps, Timestamps};
pub use settings::{Budget, Centres, SAVINGS, Settings, Windows};
pub use statistics::Statistics;

/// The version of glam that [`Camera`] is made of.
pub use glam;
/// The version of wgpu that quell is made for.
pub use wgpu;

/// The passes of a frame in the order they run; also their labels and timestamp order. Those of the specular signal have nothing
/// to do where it is not given.
pub const PASSES: [&str; 12] = [
    "reproject",
    "innovation",
    "accumulate",
    "fit",
    "compose",
    "specular reproject",
    "specular innovation",
    "specular accumulate",
    "specular fit",
    "specular compose",
    "sample_map",
    "debug_view",
];
/// How many of [`PASSES`] each signal has: first those of the radiance, then those of the specular signal.
pub(crate) const SIGNAL_PASSES: usize = 5;

/// Compiles the README's example.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
