//! quell: a real-time temporal denoiser for low-spp path-traced frames, on wgpu.

mod denoiser;
mod descriptor;
mod error;
mod frame;
#[doc(hidden)]
pub mod gpu;
mod history;
#[doc(hidden)]
pub mod layout;
#[doc(hidden)]
pub mod passes;
mod settings;

pub use denoiser::Denoiser;
pub use descriptor::DenoiserDescriptor;
pub use error::{CreateError, FrameError};
pub use frame::{Camera, DebugView, FrameInputs, FrameOutputs, HistoryMode, Timestamps};
pub use passes::Pipelines;
pub use settings::Settings;

/// The passes of a frame in the order they run; also their labels and timestamp order.
pub const PASSES: [&str; 8] =
    ["prepare", "reproject", "accumulate", "moments", "fit", "predict", "compose", "debug_view"];
