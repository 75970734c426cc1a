//! The passes of a frame, one file each with a WGSL file of the same name in `shaders/`.

pub mod accumulate;
pub mod centres;
pub mod choose;
pub mod compose;
pub mod debug_view;
pub mod fit;
pub mod gains;
pub mod innovation;
pub mod predict;
pub mod reproject;
pub mod sample_gains;
pub mod sample_map;
pub mod sample_rate;

use crate::gpu::KernelDescriptor;

/// All kernels in the order they run; `centres`, `gains` and `choose` run within the pass `fit`, `sample_gains` and `sample_rate`
/// within `sample_map`.
pub const ALL: [&KernelDescriptor; 13] = [
    &reproject::DESCRIPTOR,
    &innovation::DESCRIPTOR,
    &accumulate::DESCRIPTOR,
    &centres::DESCRIPTOR,
    &gains::DESCRIPTOR,
    &choose::DESCRIPTOR,
    &fit::DESCRIPTOR,
    &predict::DESCRIPTOR,
    &compose::DESCRIPTOR,
    &sample_gains::DESCRIPTOR,
    &sample_rate::DESCRIPTOR,
    &sample_map::DESCRIPTOR,
    &debug_view::DESCRIPTOR,
];

/// All passes, compiled. Immutable: denoisers of several cameras can share one set.
#[derive(Debug)]
pub struct Pipelines {
    pub(crate) reproject: reproject::Reproject,
    pub(crate) innovation: innovation::Innovation,
    pub(crate) accumulate: accumulate::Accumulate,
    pub(crate) fit: fit::Fit,
    pub(crate) predict: predict::Predict,
    pub(crate) compose: compose::Compose,
    pub(crate) sample_map: sample_map::SampleMap,
    pub(crate) debug_view: debug_view::DebugView,
}

impl Pipelines {
    /// Compiles all passes. Needs no optional feature and no more than WebGPU's default limits.
    pub fn new(device: &wgpu::Device) -> Self {
        Self {
            reproject: reproject::Reproject::new(device),
            innovation: innovation::Innovation::new(device),
            accumulate: accumulate::Accumulate::new(device),
            fit: fit::Fit::new(device),
            predict: predict::Predict::new(device),
            compose: compose::Compose::new(device),
            sample_map: sample_map::SampleMap::new(device),
            debug_view: debug_view::DebugView::new(device),
        }
    }
}
