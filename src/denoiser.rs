//! The denoiser: owns passes, history and scratch. [`Denoiser::encode`] is the frame, top to bottom.

use crate::budget::Plan;
use crate::gpu::{Recorder, catch, check_alive, image, uniform_buffer};
use crate::guides::Guides;
use crate::pacing::{self, Pacing};
use crate::passes::{Pipelines, Variant};
use crate::recording::Recording;
use crate::scratch::Scratch;
use crate::signal::Signal;
use crate::statistics::StatisticsReader;
use crate::{
    Allocation, Budget, Camera, Centres, CreateError, DenoiserDescriptor, DeviceError, FrameError,
    FrameInputs, FrameOutputs, HistoryMode, Memory, Notice, Settings, Statistics, layout,
};
use std::sync::Arc;
use wgpu::{TextureFormat, TextureView};

/// Denoises what one camera sees at one render size. Owns history and scratch; the caller owns every input, the output
/// and the encoder.
pub struct Denoiser {
    size: [u32; 2],
    pipelines: Arc<Pipelines>,
    guides: Guides,
    /// The radiance, or what of it did not leave the first hit through the specular lobe.
    signal: Signal,
    /// Once a frame's specular radiance came apart.
    specular: Option<Specular>,
    scratch: Scratch,
    /// The last recorded frame; none before the first.
    previous: Option<Previous>,
    frames: u32,
    statistics: StatisticsReader,
    /// While the budget is one of time.
    pacing: Option<Pacing>,
    was_noticed: bool,
}

/// What is remembered of a recorded frame, besides images.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Previous {
    /// Right-handed.
    pub camera: Camera,
    /// In pixels.
    pub size: [u32; 2],
    /// Whether the models had a limit, so that they may be kept, and with them their windows.
    pub was_limited: bool,
    /// Whether there were two signals; their histories mean something else than that of one.
    pub was_split: bool,
}

/// What a frame may do, and what there is to say of it.
struct Planned {
    /// Models that may be fitted; none: as many as are needed.
    limit: Option<u32>,
    savings: u32,
    notice: Option<Notice>,
}

/// What the specular signal needs of its own.
#[derive(Debug)]
pub(crate) struct Specular {
    pub signal: Signal,
    /// What the other signal came to, with its expected error in w.
    pub rest: TextureView,
}

impl Denoiser {
    /// Compiles the passes and creates history and scratch for one render size.
    ///
    /// # Errors
    /// An empty size, device limits too low for it, pipelines of another device, or a device that has no memory left, was lost or failed; nothing is created
    /// then.
    pub fn new(device: &wgpu::Device, descriptor: &DenoiserDescriptor) -> Result<Self, CreateError> {
        layout::check(device, descriptor)?;
        #[cfg_attr(
            target_arch = "wasm32",
            expect(
                clippy::arc_with_non_send_sync,
                reason = "wgpu's types stay on their thread in a browser"
            )
        )]
        let pipelines = Arc::new(Pipelines::new(device)?);
        Self::with_pipelines(device, descriptor, pipelines)
    }

    /// As [`Denoiser::new`], with the pipelines of another denoiser on the same device: for several cameras, two eyes or a
    /// split screen.
    ///
    /// # Errors
    /// As [`Denoiser::new`].
    pub fn with_pipelines(
        device: &wgpu::Device,
        descriptor: &DenoiserDescriptor,
        pipelines: Arc<Pipelines>,
    ) -> Result<Self, CreateError> {
        layout::check(device, descriptor)?;
        check_alive(device)?;
        pipelines.check_device(device)?;
        let size = [descriptor.width, descriptor.height];
        Ok(catch(device, || Self {
            size,
            pipelines,
            guides: Guides::new(device, size),
            signal: Signal::new(device, size),
            specular: None,
            scratch: Scratch::new(device, size),
            previous: None,
            frames: 0,
            statistics: StatisticsReader::default(),
            pacing: None,
            was_noticed: false,
        })?)
    }

    /// The compiled passes, to share with [`Denoiser::with_pipelines`].
    pub fn pipelines(&self) -> Arc<Pipelines> {
        Arc::clone(&self.pipelines)
    }

    /// Render size in pixels: width, height.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// What the newest frame came to of which the GPU's answer has arrived: some frames old, none before the first.
    /// Never blocks. Answers arrive while the caller submits or polls the device.
    pub fn statistics(&mut self) -> Option<Statistics> {
        self.statistics.latest()
    }

    /// What the denoiser holds on the GPU, by kind and resource. The frames' own small buffers are left out.
    pub fn memory(&self) -> Memory {
        let mut memory = Memory::default();
        self.signal.add_memory(&mut memory, ["history", "noise", "models", "windows", "kept"]);
        self.guides.add_memory(&mut memory);
        self.scratch.add_memory(&mut memory);
        if let Some(Specular { signal, rest }) = &self.specular {
            let names = [
                "specular_history",
                "specular_noise",
                "specular_models",
                "specular_windows",
                "specular_kept",
            ];
            signal.add_memory(&mut memory, names);
            memory.scratch.push(Allocation::of_image("rest", rest));
        }
        memory
    }

    /// Changes the render size, the largest where frames come with a viewport. History is dropped; the next frame starts without.
    /// To change it in every frame, give [`FrameInputs::viewport`] instead. Nothing happens where the size is the same.
    ///
    /// # Errors
    /// As [`Denoiser::new`]; the denoiser then stays as it was.
    pub fn resize(
        &mut self,
        device: &wgpu::Device,
        descriptor: &DenoiserDescriptor,
    ) -> Result<(), CreateError> {
        if [descriptor.width, descriptor.height] == self.size {
            return Ok(());
        }
        let resized = Self::with_pipelines(device, descriptor, self.pipelines())?;
        *self = Self { was_noticed: self.was_noticed, ..resized };
        Ok(())
    }

    /// Records the passes that denoise one frame. Never submits, polls, blocks or maps; the frame is done when the caller's
    /// submission is. Frames must be submitted in the order they were recorded.
    ///
    /// # Errors
    /// An input that does not keep the contract, or a device that is lost or has no memory left. Nothing was recorded then, and
    /// history is as it was: go on with motion from the last frame that was denoised, or by [`HistoryMode::Restart`].
    pub fn encode(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &FrameInputs<'_>,
        settings: &Settings,
    ) -> Result<FrameOutputs, FrameError> {
        let viewport = inputs.check(self.size, settings)?;
        let camera = settings.conventions.right_handed(&inputs.camera);
        let is_split = inputs.specular.is_some();
        let continues = inputs.history == HistoryMode::Continue;
        let previous = self.previous.filter(|previous| continues && previous.was_split == is_split);
        if is_split && self.specular.is_none() {
            self.specular = Some(catch(device, || Specular::new(device, self.size))?);
        }
        let Planned { limit, savings, notice } =
            self.plan(device, queue, inputs, settings, viewport.size, previous.is_none())?;
        let decodes = settings.conventions.decodes();
        let specular = match &self.specular {
            Some(specular) if is_split => {
                Some((specular, self.pipelines.signal(device, Variant::Specular, decodes)?))
            }
            _ => None,
        };
        let follows_reflections = inputs.hit_distance.is_some() && !is_split;
        let variant = if follows_reflections { Variant::Reflections } else { Variant::Radiance };
        let passes = self.pipelines.signal(device, variant, decodes)?;
        let recording = Recording {
            pipelines: &self.pipelines,
            guides: &self.guides,
            signal: &self.signal,
            passes,
            specular,
            scratch: &self.scratch,
            inputs,
            settings,
            viewport,
            camera,
            previous,
            limit,
            savings,
        };
        let uniforms = recording.uniforms(self.frames);
        let frame = &uniform_buffer(device, "quell frame", bytemuck::bytes_of(&uniforms))?;
        if let Some(pacing) = &self.pacing {
            pacing.begin(encoder);
        }
        recording.record(&mut Recorder {
            device,
            encoder,
            frame,
            profiler: inputs.profiler,
            is_specular: false,
        });
        let levels = recording.levels();
        if let Some(pacing) = &mut self.pacing {
            pacing.end(device, encoder, self.frames);
        }
        self.statistics.record(device, encoder, levels, (self.frames, limit, savings));

        self.guides.swap();
        self.previous =
            Some(Previous { camera, size: viewport.size, was_limited: limit.is_some(), was_split: is_split });
        self.was_noticed |= notice.is_some();
        self.frames = self.frames.wrapping_add(1);
        Ok(FrameOutputs { restarted: previous.is_none(), notice })
    }

    /// What the frame may do. `restarts` says that it has no history.
    fn plan(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        inputs: &FrameInputs<'_>,
        settings: &Settings,
        size: [u32; 2],
        restarts: bool,
    ) -> Result<Planned, DeviceError> {
        let budget = if settings.centres == Centres::Adaptive { settings.budget } else { Budget::Unlimited };
        let Budget::Milliseconds(target_ms) = budget else {
            self.pacing = None;
            let limit = if let Budget::Models(most) = budget { Some(most) } else { None };
            return Ok(Planned { limit, savings: settings.savings, notice: None });
        };
        let statistics = self.statistics.latest();
        let bounds = pacing::bounds(settings, size, inputs.signals());
        let mut pacing = match self.pacing.take() {
            Some(pacing) => pacing,
            None => catch(device, || Pacing::new(device, bounds, self.frames))?,
        };
        if restarts {
            pacing.restart(self.frames);
        }
        let Plan { models, savings } =
            pacing.plan(queue, inputs, statistics, (bounds, target_ms), self.frames);
        let notice = pacing.notice().filter(|_| !self.was_noticed);
        self.pacing = Some(pacing);
        Ok(Planned { limit: Some(models), savings, notice })
    }
}

impl std::fmt::Debug for Denoiser {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Denoiser")
            .field("size", &self.size)
            .field("frames", &self.frames)
            .field("is_split", &self.specular.is_some())
            .finish_non_exhaustive()
    }
}

impl Specular {
    fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let rest = image(device, "quell rest", size, TextureFormat::Rgba16Float);
        Self { signal: Signal::new(device, size), rest }
    }
}
