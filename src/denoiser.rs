//! The denoiser: owns passes, history and scratch. [`Denoiser::encode`] is the frame, top to bottom.

use crate::gpu::{FrameUniforms, Recorder, flags, image};
use crate::guides::Guides;
use crate::pacing::Pacing;
use crate::passes::{
    Pipelines, SignalPasses, accumulate::AccumulateViews, compose::ComposeViews, debug_view::DebugViewViews,
    fit::FitViews, innovation::InnovationViews, predict::PredictViews, reproject::ReprojectViews,
    sample_map::SampleMapViews,
};
use crate::scratch::Scratch;
use crate::signal::Signal;
use crate::statistics::StatisticsReader;
use crate::{
    Allocation, Budget, Camera, Centres, CreateError, DebugView, DenoiserDescriptor, FrameError, FrameInputs,
    FrameOutputs, HistoryMode, Notice, SampleMap, Settings, Statistics, Windows, layout,
};
use bytemuck::Zeroable;
use std::sync::Arc;
use wgpu::{TextureFormat, TextureView};

/// Denoises what one camera sees at one render size. Owns history and scratch; the caller owns every input, the output
/// and the encoder.
#[derive(Debug)]
pub struct Denoiser {
    size: [u32; 2],
    pipelines: Arc<Pipelines>,
    guides: Guides,
    /// The radiance, or what of it did not leave the first hit through the specular lobe.
    signal: Signal,
    /// Once a frame's specular radiance came apart.
    specular: Option<Specular>,
    scratch: Scratch,
    /// Camera of the last recorded frame; none before the first.
    previous_camera: Option<Camera>,
    frames: u32,
    statistics: StatisticsReader,
    /// While the budget is one of time.
    pacing: Option<Pacing>,
    was_noticed: bool,
    /// Whether the last recorded frame had a limit, so that its models may be kept.
    was_limited: bool,
    /// Whether the last recorded frame had two signals; their histories mean something else than that of one.
    was_split: bool,
}

/// What the specular signal needs of its own.
#[derive(Debug)]
struct Specular {
    signal: Signal,
    /// What the other signal came to, with its expected error in w.
    rest: TextureView,
}

/// What of the caller's images belongs to one of the signals.
struct SignalImages<'a> {
    radiance: &'a TextureView,
    albedo: &'a TextureView,
    emission: &'a TextureView,
    rest: &'a TextureView,
    output: &'a TextureView,
}

impl Denoiser {
    /// Compiles the passes and creates history and scratch for one render size.
    ///
    /// # Errors
    /// An empty size, or device limits too low for it; nothing is created then.
    pub fn new(device: &wgpu::Device, descriptor: &DenoiserDescriptor) -> Result<Self, CreateError> {
        layout::check(device, descriptor)?;
        Self::with_pipelines(device, descriptor, Arc::new(Pipelines::new(device)))
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
        let size = [descriptor.width, descriptor.height];
        Ok(Self {
            size,
            pipelines,
            guides: Guides::new(device, size),
            signal: Signal::new(device, size),
            specular: None,
            scratch: Scratch::new(device, size),
            previous_camera: None,
            frames: 0,
            statistics: StatisticsReader::default(),
            pacing: None,
            was_noticed: false,
            was_limited: false,
            was_split: false,
        })
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

    /// What the denoiser holds on the GPU, by resource; small constant ones are left out.
    pub fn memory(&self) -> Vec<Allocation> {
        let signal = self.signal.memory(["history", "noise", "models", "windows", "kept"]);
        let specular = self.specular.as_ref().map_or(vec![], |specular| {
            let names = [
                "specular_history",
                "specular_noise",
                "specular_models",
                "specular_windows",
                "specular_kept",
            ];
            let rest = Allocation::of_image("rest", &specular.rest);
            [specular.signal.memory(names), vec![rest]].concat()
        });
        [signal, self.guides.memory(), self.scratch.memory(), specular].concat()
    }

    /// Changes the render size. History is dropped; the next frame starts without.
    ///
    /// # Errors
    /// As [`Denoiser::new`]; the denoiser then stays as it was.
    pub fn resize(
        &mut self,
        device: &wgpu::Device,
        descriptor: &DenoiserDescriptor,
    ) -> Result<(), CreateError> {
        let resized = Self::with_pipelines(device, descriptor, self.pipelines())?;
        *self = Self { was_noticed: self.was_noticed, ..resized };
        Ok(())
    }

    /// Records the passes that denoise one frame. Never submits, polls, blocks or maps; the frame is done when the caller's
    /// submission is. Frames must be submitted in the order they were recorded.
    ///
    /// # Errors
    /// An input that does not keep the contract. Nothing was recorded then, and history is as it was.
    pub fn encode(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        encoder: &mut wgpu::CommandEncoder,
        inputs: &FrameInputs<'_>,
        settings: &Settings,
    ) -> Result<FrameOutputs, FrameError> {
        inputs.check(self.size, settings)?;
        let is_split = inputs.specular.is_some();
        let continues = inputs.history == HistoryMode::Continue && is_split == self.was_split;
        let previous = self.previous_camera.filter(|_| continues);
        let (limit, notice) = self.limit(device, queue, inputs, settings);
        if is_split && self.specular.is_none() {
            self.specular = Some(Specular::new(device, self.size));
        }
        if let Some(pacing) = &self.pacing {
            pacing.begin(encoder);
        }
        let uniforms = self.uniforms(inputs, settings, previous, limit);
        let frame = &uniform_buffer(device, queue, &uniforms);
        let timestamps = inputs.timestamps;
        let mut recorder = Recorder { device, encoder, frame, timestamps, is_specular: false };
        self.record(&mut recorder, inputs, settings, uniforms.flags);
        if let Some(pacing) = &mut self.pacing {
            pacing.end(device, encoder, self.frames);
        }
        let specular = self.specular.as_ref().filter(|_| is_split);
        let levels = [Some(&self.signal.levels), specular.map(|specular| &specular.signal.levels)];
        self.statistics.record(device, encoder, levels, self.frames, limit);

        self.guides.swap();
        self.previous_camera = Some(inputs.camera);
        self.frames = self.frames.wrapping_add(1);
        self.was_limited = limit.is_some();
        self.was_split = is_split;
        Ok(FrameOutputs { restarted: previous.is_none(), notice })
    }

    /// How many models the frame may fit, and what there is to say of it.
    fn limit(
        &mut self,
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        inputs: &FrameInputs<'_>,
        settings: &Settings,
    ) -> (Option<u32>, Option<Notice>) {
        let budget = if settings.centres == Centres::Adaptive { settings.budget } else { Budget::Unlimited };
        let Budget::Milliseconds(target_ms) = budget else {
            self.pacing = None;
            return (if let Budget::Models(most) = budget { Some(most) } else { None }, None);
        };
        let statistics = self.statistics.latest();
        let pacing = self.pacing.get_or_insert_with(|| Pacing::new(device, self.size, self.frames));
        let limit = pacing.limit(queue, inputs, statistics, target_ms, self.frames);
        let notice = pacing.notice().filter(|_| !self.was_noticed);
        self.was_noticed |= notice.is_some();
        (Some(limit), notice)
    }

    /// The frame: its one signal, or one after the other the two that it came apart in; then what is made on request.
    fn record(&self, recorder: &mut Recorder<'_>, inputs: &FrameInputs<'_>, settings: &Settings, flags: u32) {
        let Scratch { no_float, sample_histogram, reprojected_noise: error, .. } = &self.scratch;
        let FrameInputs { radiance, albedo, output, .. } = *inputs;
        let emission = inputs.emission.unwrap_or(no_float);
        recorder.encoder.clear_buffer(sample_histogram, 0, None);
        let combined = SignalImages { radiance, albedo, emission, rest: no_float, output };
        let mut shown = Some(&self.signal);
        if let (Some(radiance), Some(Specular { signal, rest })) = (inputs.specular, &self.specular) {
            let of_rest = SignalImages { output: rest, ..combined };
            self.record_signal(recorder, inputs, flags, &self.pipelines.signal, &self.signal, &of_rest);
            shown = Some(signal);
            if shows_rest(inputs, settings) {
                self.record_debug_view(recorder, inputs, &self.signal);
                shown = None;
            }
            recorder.is_specular = true;
            let albedo = inputs.specular_albedo.unwrap_or(no_float);
            let of_specular = SignalImages { radiance, albedo, emission: no_float, rest, output };
            let passes = self.pipelines.specular(recorder.device);
            self.record_signal(recorder, inputs, flags, passes, signal, &of_specular);
        } else {
            let passes = match inputs.hit_distance {
                Some(_) => self.pipelines.reflections(recorder.device),
                None => &self.pipelines.signal,
            };
            self.record_signal(recorder, inputs, flags, passes, &self.signal, &combined);
            crate::PASSES[crate::SIGNAL_PASSES..2 * crate::SIGNAL_PASSES]
                .iter()
                .for_each(|name| recorder.skip_pass(name));
        }
        match inputs.sample_map {
            Some(SampleMap { view: samples, .. }) => self.pipelines.sample_map.record(
                recorder,
                &SampleMapViews {
                    guide: self.guides.current(),
                    motion: inputs.motion,
                    history: &self.signal.history,
                    error,
                    sample_histogram,
                    samples,
                },
                self.size,
            ),
            None => recorder.skip_pass("sample_map"),
        }
        if let Some(signal) = shown {
            self.record_debug_view(recorder, inputs, signal);
        }
    }

    /// One signal, pass by pass.
    fn record_signal(
        &self,
        recorder: &mut Recorder<'_>,
        inputs: &FrameInputs<'_>,
        flags: u32,
        passes: &SignalPasses,
        signal_state: &Signal,
        images: &SignalImages<'_>,
    ) {
        let Scratch { signal, reprojected, reprojected_noise, moments, innovations, .. } = &self.scratch;
        let Scratch { coverage, centre_list, histogram, no_float, no_uint, .. } = &self.scratch;
        let Signal { history, noise, models, windows, kept, levels } = signal_state;
        let (prediction, mix_weight, error) = (reprojected, signal, reprojected_noise);
        let (guide, previous_guide) = (self.guides.current(), self.guides.previous());
        let FrameInputs { normal_roughness, depth, motion, .. } = *inputs;
        let SignalImages { radiance, albedo, emission, rest, output } = *images;
        let surface_id = inputs.surface_id.unwrap_or(no_uint);
        let sample_count = inputs.sample_count.unwrap_or(no_uint);
        let hit_distance = inputs.hit_distance.unwrap_or(no_float);
        let is_limited = flags & flags::LIMITED != 0;
        let keeps_models = is_limited && self.was_limited && flags & flags::HISTORY != 0;

        signal_state.clear(recorder.encoder, keeps_models);
        for buffer in [coverage, histogram] {
            recorder.encoder.clear_buffer(buffer, 0, None);
        }
        passes.reproject.record(
            recorder,
            &ReprojectViews {
                radiance,
                albedo,
                normal_roughness,
                depth,
                motion,
                surface_id,
                emission,
                sample_count,
                hit_distance,
                previous_guide,
                history,
                noise,
                guide,
                signal,
                reprojected,
                reprojected_noise,
                moments,
            },
            self.size,
        );
        passes.innovation.record(
            recorder,
            &InnovationViews { moments, innovations },
            layout::innovation_centres(self.size),
        );
        passes.accumulate.record(
            recorder,
            &AccumulateViews {
                signal,
                guide,
                sample_count,
                reprojected,
                reprojected_noise,
                innovations,
                history,
                noise,
                moments,
            },
            self.size,
        );
        passes.fit.record(
            recorder,
            &FitViews { moments, centre_list, levels, models, windows, coverage, kept, histogram },
            layout::tiles(self.size),
            is_limited,
        );
        passes.predict.record(recorder, &PredictViews { guide, models, windows, prediction }, self.size);
        passes.compose.record(
            recorder,
            &ComposeViews {
                guide,
                prediction,
                history,
                noise,
                albedo,
                emission,
                rest,
                output,
                error,
                mix_weight,
            },
            self.size,
        );
    }

    /// Shows an inner image of the signal that was recorded last.
    fn record_debug_view(
        &self,
        recorder: &mut Recorder<'_>,
        inputs: &FrameInputs<'_>,
        signal_state: &Signal,
    ) {
        let Some((_, debug)) = inputs.debug else {
            return recorder.skip_pass("debug_view");
        };
        let Signal { history, noise, models, windows, .. } = signal_state;
        let Scratch { signal: mix_weight, reprojected: prediction, reprojected_noise: error, .. } =
            &self.scratch;
        let (guide, motion) = (self.guides.current(), inputs.motion);
        self.pipelines.debug_view.record(
            recorder,
            &DebugViewViews {
                guide,
                motion,
                prediction,
                history,
                noise,
                mix_weight,
                error,
                models,
                windows,
                debug,
            },
            self.size,
        );
    }

    fn uniforms(
        &self,
        inputs: &FrameInputs<'_>,
        settings: &Settings,
        previous: Option<Camera>,
        limit: Option<u32>,
    ) -> FrameUniforms {
        let flag = |set: bool, bit: u32| if set { bit } else { 0 };
        let motion_depth = inputs.motion.texture().format() == TextureFormat::Rgba16Float;
        let wants_error =
            inputs.sample_map.is_some() || matches!(inputs.debug, Some((DebugView::OutputError, _)));
        let signals = if inputs.specular.is_some() { 2 } else { 1 };
        let mut uniforms = FrameUniforms {
            far: settings.far,
            size: self.size,
            tiles: layout::tiles(self.size),
            index: self.frames,
            firefly_limit: settings.firefly_limit,
            motion_scale: settings.motion_scale,
            max_history: settings.max_history,
            flags: flag(previous.is_some(), flags::HISTORY)
                | flag(inputs.surface_id.is_some(), flags::SURFACE_ID)
                | flag(inputs.emission.is_some(), flags::EMISSION)
                | flag(inputs.sample_count.is_some(), flags::SAMPLE_COUNT)
                | flag(motion_depth, flags::MOTION_DEPTH)
                | flag(settings.mix_temporal_mean, flags::MIX)
                | flag(settings.innovation, flags::INNOVATION)
                | flag(limit.is_some(), flags::LIMITED)
                | flag(inputs.specular.is_some(), flags::SPLIT)
                | flag(inputs.specular_albedo.is_some(), flags::SPECULAR_ALBEDO)
                | flag(inputs.hit_distance.is_some(), flags::HIT_DISTANCE)
                | flag(settings.windows == Windows::RingError, flags::RING_ERROR)
                | flag(wants_error, flags::ERROR)
                | flag(matches!(inputs.debug, Some((DebugView::MixWeight, _))), flags::SHOW_MIX),
            sample_budget: inputs.sample_map.map_or(0.0, |map| map.samples_per_pixel),
            dark_level: inputs.sample_map.map_or(0.0, |map| map.dark_level),
            model_limit: limit.map_or(u32::MAX, |limit| limit / signals),
            debug_view: inputs.debug.map_or(0, |(view, _)| view as u32),
            ..FrameUniforms::zeroed()
        };
        uniforms.set_cameras(&inputs.camera, &previous.unwrap_or(inputs.camera));
        uniforms.set_windows(settings.windows, settings.centres);
        uniforms
    }
}

impl Specular {
    fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let rest = image(device, "quell rest", size, TextureFormat::Rgba16Float);
        Self { signal: Signal::new(device, size), rest }
    }
}

/// Whether the debug view is of the first of two signals. What the output is off by is known after the second.
fn shows_rest(inputs: &FrameInputs<'_>, settings: &Settings) -> bool {
    !settings.debug_specular && inputs.debug.is_some_and(|(view, _)| view != DebugView::OutputError)
}

/// A buffer of its own per frame: several frames may be recorded before one submission.
fn uniform_buffer(device: &wgpu::Device, queue: &wgpu::Queue, uniforms: &FrameUniforms) -> wgpu::Buffer {
    let frame = device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("quell frame"),
        size: size_of::<FrameUniforms>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    queue.write_buffer(&frame, 0, bytemuck::bytes_of(uniforms));
    frame
}
