//! The window: shows what a [`FrameSource`] renders, with a panel, a free camera and GPU times.

mod app;
mod controls;
mod display;
mod free_flight;
mod panel;
mod running;
mod ui_layer;
mod view_state;

pub use app::run;
pub use display::{DisplayPass, Shown, letterbox};
pub use free_flight::{FlightInput, FreeFlight};
pub use view_state::{ViewMode, ViewState};

use crate::gpu::Gpu;
use crate::gpu_timer::GpuTimer;
use glam::Mat4;
use thiserror::Error;

/// Renders the frames that a window shows.
pub trait FrameSource {
    /// Records everything of one frame into `encoder`, which the window submits. Must not wait for the GPU.
    fn frame(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &FrameRequest<'_>,
        timer: &mut GpuTimer,
    ) -> anyhow::Result<FrameImages>;
}

/// What the window wants of a frame.
#[derive(Debug)]
pub struct FrameRequest<'a> {
    pub view: &'a ViewState,
    /// How far scene time moves, seconds; 0 while paused.
    pub time_step_s: f32,
    /// View from world of the free camera; none on the source's own path.
    pub free_view: Option<Mat4>,
    /// Drop all history.
    pub restart: bool,
    /// Pixels of the window that are left for the image, at least 1 each.
    pub area: [u32; 2],
}

/// The images of a frame, all of one size, scene-linear, in a format that can be loaded as float. An image that is
/// missing is replaced by `denoised`.
#[derive(Debug, Clone)]
pub struct FrameImages {
    pub noisy: Option<wgpu::TextureView>,
    /// Of `ViewState::rival`.
    pub rival: Option<wgpu::TextureView>,
    pub denoised: wgpu::TextureView,
    pub reference: Option<wgpu::TextureView>,
    /// Where `ViewState::debug` is set.
    pub debug: Option<wgpu::TextureView>,
    /// View from world that the frame was rendered with; free flight starts here.
    pub view_from_world: Mat4,
    /// One line for the panel.
    pub status: String,
}

/// How the window opens.
#[derive(Debug, Clone)]
pub struct WindowOptions {
    pub title: String,
    /// Size in logical pixels.
    pub size: [u32; 2],
    /// Speed of free flight, scene units per second.
    pub speed: f32,
    /// Close after so many frames; for tests and measurements.
    pub max_frames: Option<u64>,
    /// What is shown at first.
    pub view: ViewState,
}

impl Default for WindowOptions {
    fn default() -> Self {
        Self {
            title: "quell".to_owned(),
            size: [1280, 720],
            speed: 2.0,
            max_frames: None,
            view: ViewState::default(),
        }
    }
}

/// Why a window could not be opened or go on.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WindowError {
    /// There is nothing to open a window on. The caller may go on without one.
    #[error("no display to open a window on ({0})")]
    NoDisplay(String),
    /// The GPU cannot present here, or the source failed.
    #[error(transparent)]
    Failed(#[from] anyhow::Error),
}
