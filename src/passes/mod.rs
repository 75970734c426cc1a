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
use std::sync::OnceLock;

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

/// The kernels that are compiled anew for the specular signal.
pub const SPECULAR_KERNELS: [&KernelDescriptor; 4] =
    [&reproject::DESCRIPTOR, &accumulate::DESCRIPTOR, &predict::DESCRIPTOR, &compose::DESCRIPTOR];

/// All passes, compiled; those of the specular signal, and those that use hit distances, when they are first needed.
/// Denoisers of several cameras can share one set.
#[derive(Debug)]
pub struct Pipelines {
    pub(crate) signal: SignalPasses,
    specular: OnceLock<SignalPasses>,
    reflections: OnceLock<SignalPasses>,
    pub(crate) sample_map: sample_map::SampleMap,
    pub(crate) debug_view: debug_view::DebugView,
}

/// What denoises one signal.
#[derive(Debug)]
pub(crate) struct SignalPasses {
    pub reproject: reproject::Reproject,
    pub innovation: innovation::Innovation,
    pub accumulate: accumulate::Accumulate,
    pub fit: fit::Fit,
    pub predict: predict::Predict,
    pub compose: compose::Compose,
}

impl Pipelines {
    /// Compiles all passes that every frame needs. Needs no optional feature and no more than WebGPU's default limits.
    pub fn new(device: &wgpu::Device) -> Self {
        Self {
            signal: SignalPasses {
                reproject: reproject::Reproject::new(device),
                innovation: innovation::Innovation::new(device),
                accumulate: accumulate::Accumulate::new(device),
                fit: fit::Fit::new(device),
                predict: predict::Predict::new(device),
                compose: compose::Compose::new(device),
            },
            specular: OnceLock::new(),
            reflections: OnceLock::new(),
            sample_map: sample_map::SampleMap::new(device),
            debug_view: debug_view::DebugView::new(device),
        }
    }

    /// What denoises the specular signal; compiled by the first call.
    pub(crate) fn specular(&self, device: &wgpu::Device) -> &SignalPasses {
        self.specular.get_or_init(|| SignalPasses {
            reproject: reproject::Reproject::specular(device),
            innovation: self.signal.innovation.clone(),
            accumulate: accumulate::Accumulate::specular(device),
            fit: self.signal.fit.clone(),
            predict: predict::Predict::specular(device),
            compose: compose::Compose::specular(device),
        })
    }

    /// What denoises radiance in one with hit distances; compiled by the first call.
    pub(crate) fn reflections(&self, device: &wgpu::Device) -> &SignalPasses {
        self.reflections.get_or_init(|| SignalPasses {
            reproject: reproject::Reproject::with_reflections(device),
            innovation: self.signal.innovation.clone(),
            accumulate: self.signal.accumulate.clone(),
            fit: self.signal.fit.clone(),
            predict: self.signal.predict.clone(),
            compose: self.signal.compose.clone(),
        })
    }
}
