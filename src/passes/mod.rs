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

use crate::DeviceError;
use crate::gpu::{Compiler, KernelDescriptor, catch, check_alive};
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
    cache: Option<wgpu::PipelineCache>,
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
    ///
    /// # Errors
    /// The driver could not compile them, or the device is lost.
    pub fn new(device: &wgpu::Device) -> Result<Self, DeviceError> {
        Self::with_cache(device, None)
    }

    /// As [`Pipelines::new`], with what the driver compiled in an earlier run of the program; what it lacks joins it. Store
    /// `wgpu::PipelineCache::get_data` after the first frames, because some passes are compiled when they are first needed.
    /// Needs `Features::PIPELINE_CACHE`.
    ///
    /// # Errors
    /// As [`Pipelines::new`].
    pub fn with_cache(
        device: &wgpu::Device,
        cache: Option<&wgpu::PipelineCache>,
    ) -> Result<Self, DeviceError> {
        check_alive(device)?;
        let compiler = Compiler { device, cache };
        catch(device, || Self {
            signal: SignalPasses {
                reproject: reproject::Reproject::new(compiler),
                innovation: innovation::Innovation::new(compiler),
                accumulate: accumulate::Accumulate::new(compiler),
                fit: fit::Fit::new(compiler),
                predict: predict::Predict::new(compiler),
                compose: compose::Compose::new(compiler),
            },
            specular: OnceLock::new(),
            reflections: OnceLock::new(),
            sample_map: sample_map::SampleMap::new(compiler),
            debug_view: debug_view::DebugView::new(compiler),
            cache: cache.cloned(),
        })
    }

    /// What denoises the specular signal; compiled by the first call.
    pub(crate) fn specular(&self, device: &wgpu::Device) -> Result<&SignalPasses, DeviceError> {
        self.variant(device, &self.specular, |compiler| SignalPasses {
            reproject: reproject::Reproject::specular(compiler),
            innovation: self.signal.innovation.clone(),
            accumulate: accumulate::Accumulate::specular(compiler),
            fit: self.signal.fit.clone(),
            predict: predict::Predict::specular(compiler),
            compose: compose::Compose::specular(compiler),
        })
    }

    /// What denoises radiance in one with hit distances; compiled by the first call.
    pub(crate) fn reflections(&self, device: &wgpu::Device) -> Result<&SignalPasses, DeviceError> {
        self.variant(device, &self.reflections, |compiler| SignalPasses {
            reproject: reproject::Reproject::with_reflections(compiler),
            innovation: self.signal.innovation.clone(),
            accumulate: self.signal.accumulate.clone(),
            fit: self.signal.fit.clone(),
            predict: self.signal.predict.clone(),
            compose: self.signal.compose.clone(),
        })
    }

    /// What failed to compile is not kept.
    fn variant<'a>(
        &'a self,
        device: &wgpu::Device,
        compiled: &'a OnceLock<SignalPasses>,
        compile: impl FnOnce(Compiler<'_>) -> SignalPasses,
    ) -> Result<&'a SignalPasses, DeviceError> {
        if let Some(passes) = compiled.get() {
            return Ok(passes);
        }
        let passes = catch(device, || compile(Compiler { device, cache: self.cache.as_ref() }))?;
        Ok(compiled.get_or_init(|| passes))
    }
}
