//! The methods that a sequence can be denoised with, behind one call.

use crate::gbuffer::{GBuffer, Split, image};
use crate::gpu::Gpu;
use crate::peers::{Accumulate, Bmfr, PeerFrame, Svgf};
use anyhow::{Context, Result, bail};
use quell::{
    Allocation, Camera, Conventions, DebugView, Denoiser, DenoiserDescriptor, FrameInputs, HistoryMode,
    MotionUnit, PassProfiler, RequiredInputs, SampleMap, Settings, Statistics, Timestamps,
};

/// How to denoise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Method {
    /// The denoiser of this project
    Quell,
    /// Spatiotemporal variance-guided filtering (Schied et al. 2017)
    Svgf,
    /// Blockwise multi-order feature regression (Koskela et al. 2019)
    Bmfr,
    /// Plain temporal accumulation with reprojection
    Accumulate,
    /// No denoising: the noisy input with invalid values repaired
    None,
}

impl Method {
    /// As on the command line and in metrics.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quell => "quell",
            Self::Svgf => "svgf",
            Self::Bmfr => "bmfr",
            Self::Accumulate => "accumulate",
            Self::None => "none",
        }
    }
}

/// Luminance that counts as dark in pictures that are tonemapped without exposure; as in the relative MSE of images.
const DARK_LEVEL: f32 = 0.1;

/// One frame to denoise.
#[derive(Debug, Clone, Copy)]
pub struct MethodFrame<'a> {
    pub gbuffer: &'a GBuffer,
    pub camera: Camera,
    /// A cut: drop history.
    pub restart: bool,
    /// All methods use `far` and `max_history`. `conventions` are ignored: the G-buffer has its own.
    pub settings: &'a Settings,
    /// Which of the G-buffer's split images quell gets, where there are any. The others take combined radiance.
    pub split: Split,
    /// Quell alone draws debug views; the others leave the image untouched.
    pub debug: Option<(DebugView, &'a wgpu::TextureView)>,
    /// Quell asks for as many samples per pixel, in the mean, in the next frame ([`GBuffer::sample_map`]).
    pub sample_budget: Option<f32>,
    /// Pass `i` of [`MethodRunner::passes`] writes its begin to `first_query + 2 i` and its end to the query after it.
    pub timestamps: Option<Timestamps<'a>>,
    /// What times quell's passes instead; the others have none.
    pub profiler: Option<&'a dyn PassProfiler>,
    /// As [`FrameInputs::measured_ms`].
    pub measured_ms: Option<f32>,
}

impl<'a> MethodFrame<'a> {
    /// A frame with the split of its images, without debug view, sample map, timing and measured time.
    pub fn new(gbuffer: &'a GBuffer, camera: Camera, restart: bool, settings: &'a Settings) -> Self {
        Self {
            gbuffer,
            camera,
            restart,
            settings,
            split: gbuffer.split,
            debug: None,
            sample_budget: None,
            timestamps: None,
            profiler: None,
            measured_ms: None,
        }
    }
}

/// A method with its history, for one sequence of one size.
#[derive(Debug)]
pub struct MethodRunner {
    method: Method,
    state: State,
}

#[derive(Debug)]
enum State {
    // All boxed: each is large, and they differ.
    Quell { denoiser: Box<Denoiser>, output: wgpu::TextureView },
    Svgf(Box<Svgf>),
    Bmfr(Box<Bmfr>),
    Accumulate(Box<Accumulate>),
}

impl MethodRunner {
    /// Creates pipelines and history for frames of `width` x `height` pixels.
    pub fn new(gpu: &Gpu, method: Method, width: u32, height: u32) -> Result<Self> {
        let state = match method {
            Method::Quell => State::Quell {
                denoiser: Box::new(
                    Denoiser::new(&gpu.device, &DenoiserDescriptor::new(width, height))
                        .context("cannot create the denoiser")?,
                ),
                output: output_image(&gpu.device, width, height),
            },
            Method::Svgf => State::Svgf(Box::new(Svgf::new(&gpu.device, width, height))),
            Method::Bmfr => State::Bmfr(Box::new(Bmfr::new(&gpu.device, width, height))),
            // No denoising is accumulation that restarts with every frame.
            Method::Accumulate | Method::None => {
                State::Accumulate(Box::new(Accumulate::new(&gpu.device, width, height)))
            }
        };
        Ok(Self { method, state })
    }

    /// quell for another camera: with the pipelines of `other`, which is quell too, and a history of its own.
    pub fn for_another_view(gpu: &Gpu, other: &Self, [width, height]: [u32; 2]) -> Result<Self> {
        let State::Quell { denoiser, .. } = &other.state else {
            bail!("{} has no pipelines to share", other.method.name());
        };
        let descriptor = DenoiserDescriptor::new(width, height);
        let denoiser = Denoiser::with_pipelines(&gpu.device, &descriptor, denoiser.pipelines())
            .context("cannot create the denoiser of another view")?;
        let output = output_image(&gpu.device, width, height);
        Ok(Self { method: Method::Quell, state: State::Quell { denoiser: Box::new(denoiser), output } })
    }

    pub fn method(&self) -> Method {
        self.method
    }

    /// The denoised radiance of the last frame: `Rgba16Float`, scene-linear. The same view for every frame.
    pub fn output(&self) -> &wgpu::TextureView {
        match &self.state {
            State::Quell { output, .. } => output,
            State::Svgf(svgf) => svgf.output(),
            State::Bmfr(bmfr) => bmfr.output(),
            State::Accumulate(accumulate) => accumulate.output(),
        }
    }

    /// Linear models of a recent frame, where the method has any; see [`Denoiser::statistics`].
    pub fn models(&mut self) -> Option<u32> {
        self.statistics().map(|statistics| statistics.models())
    }

    /// What a recent frame came to, where the method tells; see [`Denoiser::statistics`].
    pub fn statistics(&mut self) -> Option<Statistics> {
        match &mut self.state {
            State::Quell { denoiser, .. } => denoiser.statistics(),
            State::Svgf(_) | State::Bmfr(_) | State::Accumulate(_) => None,
        }
    }

    /// The passes of a frame, in the order they run; quell's sample map and debug view have nothing to do in most frames.
    pub fn passes(&self) -> &'static [&'static str] {
        match &self.state {
            State::Quell { .. } => &quell::PASSES,
            State::Svgf(_) => &Svgf::PASSES,
            State::Bmfr(_) => &Bmfr::PASSES,
            State::Accumulate(_) => &Accumulate::PASSES,
        }
    }

    /// What the method holds on the GPU besides its inputs and output.
    pub fn memory(&self) -> Vec<Allocation> {
        match &self.state {
            State::Quell { denoiser, .. } => denoiser.memory().allocations().copied().collect(),
            State::Svgf(svgf) => svgf.memory(),
            State::Bmfr(bmfr) => bmfr.memory(),
            State::Accumulate(accumulate) => accumulate.memory(),
        }
    }

    /// Records the passes of one frame and returns [`output`](Self::output). Submit before the next call.
    pub fn encode(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        frame: &MethodFrame<'_>,
    ) -> Result<&wgpu::TextureView> {
        let MethodFrame { gbuffer, timestamps, .. } = *frame;
        let peer_frame = PeerFrame {
            camera: frame.camera,
            restart: frame.restart || self.method == Method::None,
            far: frame.settings.far,
            max_history: frame.settings.max_history,
        };
        match &mut self.state {
            State::Quell { denoiser, output } => {
                let lobes = gbuffer.lobes.as_ref().filter(|_| frame.split == Split::Full);
                let sample_map = frame.sample_budget.map(|samples_per_pixel| {
                    SampleMap::new(&gbuffer.sample_map, samples_per_pixel).with_dark_level(DARK_LEVEL)
                });
                let mut inputs = FrameInputs::new(RequiredInputs {
                    radiance: lobes.map_or(&gbuffer.radiance, |lobes| &lobes.rest),
                    albedo: &gbuffer.albedo,
                    normal_roughness: &gbuffer.normal_roughness,
                    depth: &gbuffer.depth,
                    motion: &gbuffer.motion,
                    output,
                    camera: frame.camera,
                })
                .with_history(if frame.restart { HistoryMode::Restart } else { HistoryMode::Continue })
                .with_surface_id(&gbuffer.surface_id)
                .with_emission(&gbuffer.emission)
                .with_sample_count(&gbuffer.sample_count)
                .with_specular(lobes.map(|lobes| &lobes.specular))
                .with_specular_albedo(lobes.and(gbuffer.specular_albedo.as_ref()))
                .with_hit_distance(gbuffer.hit_distance.as_ref().filter(|_| frame.split != Split::None))
                .with_debug(frame.debug)
                .with_sample_map(sample_map)
                .with_measured_ms(frame.measured_ms);
                inputs.profiler = frame.profiler.or(timestamps.as_ref().map(|timestamps| timestamps as _));
                let conventions = Conventions::default().with_motion_unit(MotionUnit::Pixels);
                let settings = frame.settings.with_conventions(conventions);
                denoiser.encode(&gpu.device, &gpu.queue, encoder, &inputs, &settings)?;
            }
            State::Svgf(svgf) => svgf.encode(gpu, encoder, gbuffer, &peer_frame, timestamps),
            State::Bmfr(bmfr) => bmfr.encode(gpu, encoder, gbuffer, &peer_frame, timestamps),
            State::Accumulate(accumulate) => {
                accumulate.encode(gpu, encoder, gbuffer, &peer_frame, timestamps);
            }
        }
        Ok(self.output())
    }
}

/// An image that a method can write its result or a debug view to.
pub fn output_image(device: &wgpu::Device, width: u32, height: u32) -> wgpu::TextureView {
    image(device, "output", [width, height], wgpu::TextureFormat::Rgba16Float)
}
