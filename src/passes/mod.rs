//! The passes of a frame, one file each with a WGSL file of the same name in `shaders/`.

pub mod accumulate;
pub mod centres;
pub mod change;
pub mod compose;
pub mod debug_view;
pub mod fit;
pub mod innovation;
pub mod moments;
pub mod predict;
pub mod prepare;
pub mod reproject;

use crate::gpu::KernelDescriptor;

/// All kernels in the order they run; `centres` runs within the pass `fit`.
pub const ALL: [&KernelDescriptor; 11] = [
    &prepare::DESCRIPTOR,
    &reproject::DESCRIPTOR,
    &change::DESCRIPTOR,
    &innovation::DESCRIPTOR,
    &accumulate::DESCRIPTOR,
    &moments::DESCRIPTOR,
    &centres::DESCRIPTOR,
    &fit::DESCRIPTOR,
    &predict::DESCRIPTOR,
    &compose::DESCRIPTOR,
    &debug_view::DESCRIPTOR,
];

/// All passes, compiled. Immutable: denoisers of several cameras can share one set.
#[derive(Debug)]
pub struct Pipelines {
    pub(crate) prepare: prepare::Prepare,
    pub(crate) reproject: reproject::Reproject,
    pub(crate) change: change::Change,
    pub(crate) innovation: innovation::Innovation,
    pub(crate) accumulate: accumulate::Accumulate,
    pub(crate) moments: moments::Moments,
    pub(crate) fit: fit::Fit,
    pub(crate) predict: predict::Predict,
    pub(crate) compose: compose::Compose,
    pub(crate) debug_view: debug_view::DebugView,
}

impl Pipelines {
    /// Compiles all passes. Needs no optional feature and no more than WebGPU's default limits.
    pub fn new(device: &wgpu::Device) -> Self {
        Self {
            prepare: prepare::Prepare::new(device),
            reproject: reproject::Reproject::new(device),
            change: change::Change::new(device),
            innovation: innovation::Innovation::new(device),
            accumulate: accumulate::Accumulate::new(device),
            moments: moments::Moments::new(device),
            fit: fit::Fit::new(device),
            predict: predict::Predict::new(device),
            compose: compose::Compose::new(device),
            debug_view: debug_view::DebugView::new(device),
        }
    }
}
