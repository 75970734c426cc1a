//! The passes of a frame, one file each with a WGSL file of the same name in `shaders/`.

pub mod accumulate;
pub mod centres;
pub mod check;
pub mod choose;
pub mod compose;
pub mod debug_view;
pub mod fit;
pub mod gains;
pub mod innovation;
pub mod reproject;
pub mod sample_gains;
pub mod sample_map;
pub mod sample_rate;

use crate::gpu::{
    Compiler, Constants, DECODING, KernelDescriptor, REFLECTIONS, SPECULAR, catch, check_alive,
};
use crate::{CreateError, DeviceError};
use std::sync::OnceLock;

/// All kernels in the order they run; `centres`, `gains` and `choose` run within the pass `fit`, `sample_gains` and `sample_rate`
/// within `sample_map`. Without `check`, which is none of the denoiser's.
pub const ALL: [&KernelDescriptor; 12] = [
    &reproject::DESCRIPTOR,
    &innovation::DESCRIPTOR,
    &accumulate::DESCRIPTOR,
    &centres::DESCRIPTOR,
    &gains::DESCRIPTOR,
    &choose::DESCRIPTOR,
    &fit::DESCRIPTOR,
    &compose::DESCRIPTOR,
    &sample_gains::DESCRIPTOR,
    &sample_rate::DESCRIPTOR,
    &sample_map::DESCRIPTOR,
    &debug_view::DESCRIPTOR,
];

/// The kernels that are compiled anew for the specular signal.
pub const SPECULAR_KERNELS: [&KernelDescriptor; 3] =
    [&reproject::DESCRIPTOR, &accumulate::DESCRIPTOR, &compose::DESCRIPTOR];

/// All passes, compiled; those that few frames need, when they are first needed: for the specular signal, for hit distances, for
/// conventions other than quell's own. Denoisers of several cameras can share one set.
#[derive(Debug)]
pub struct Pipelines {
    signal: SignalPasses,
    /// By variant, then by whether conventions are others.
    variants: [[OnceLock<SignalPasses>; 2]; 3],
    pub(crate) sample_map: sample_map::SampleMap,
    pub(crate) debug_view: debug_view::DebugView,
    cache: Option<wgpu::PipelineCache>,
    device: wgpu::Device,
}

/// What passes are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Variant {
    /// The radiance in one, or what of it is not specular.
    Radiance,
    /// The specular signal.
    Specular,
    /// The radiance in one with hit distances.
    Reflections,
}

/// What denoises one signal.
#[derive(Debug, Clone)]
pub(crate) struct SignalPasses {
    pub reproject: reproject::Reproject,
    pub innovation: innovation::Innovation,
    pub accumulate: accumulate::Accumulate,
    pub fit: fit::Fit,
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
                reproject: reproject::Reproject::new(compiler, &[]),
                innovation: innovation::Innovation::new(compiler),
                accumulate: accumulate::Accumulate::new(compiler),
                fit: fit::Fit::new(compiler),
                compose: compose::Compose::new(compiler),
            },
            variants: Default::default(),
            sample_map: sample_map::SampleMap::new(compiler),
            debug_view: debug_view::DebugView::new(compiler),
            cache: cache.cloned(),
            device: device.clone(),
        })
    }

    /// Refuses another device than the one they were compiled on, of the same instance.
    pub(crate) fn check_device(&self, device: &wgpu::Device) -> Result<(), CreateError> {
        if self.device == *device { Ok(()) } else { Err(CreateError::OtherDevice) }
    }

    /// What denoises one signal, where `decodes` tells whether conventions are other than quell's own; compiled by the first call.
    pub(crate) fn signal(
        &self,
        device: &wgpu::Device,
        variant: Variant,
        decodes: bool,
    ) -> Result<&SignalPasses, DeviceError> {
        if variant == Variant::Radiance && !decodes {
            return Ok(&self.signal);
        }
        let compiled = &self.variants[variant as usize][usize::from(decodes)];
        if let Some(passes) = compiled.get() {
            return Ok(passes);
        }
        let compiler = Compiler { device, cache: self.cache.as_ref() };
        // What failed to compile is not kept.
        let passes = catch(device, || self.compile(compiler, variant, decodes))?;
        Ok(compiled.get_or_init(|| passes))
    }

    /// Compiles what differs from the passes that every frame needs.
    fn compile(&self, compiler: Compiler<'_>, variant: Variant, decodes: bool) -> SignalPasses {
        let of_signal: &Constants = match variant {
            Variant::Radiance => &[],
            Variant::Specular => SPECULAR,
            Variant::Reflections => REFLECTIONS,
        };
        let of_conventions = if decodes { DECODING } else { &[] };
        let reproject = reproject::Reproject::new(compiler, &[of_signal, of_conventions].concat());
        let plain = SignalPasses { reproject, ..self.signal.clone() };
        if variant != Variant::Specular {
            return plain;
        }
        SignalPasses {
            accumulate: accumulate::Accumulate::specular(compiler),
            compose: compose::Compose::specular(compiler),
            ..plain
        }
    }
}
