//! The denoiser: owns passes, history and scratch. [`Denoiser::encode`] is the frame, top to bottom.

use crate::gpu::{FrameUniforms, Recorder, buffer, flags, image, words};
use crate::history::History;
use crate::layout::{BUCKETS, LEVELS, LEVELS_WORDS, SAMPLE_BUCKETS};
use crate::pacing::Pacing;
use crate::passes::{
    Pipelines, accumulate::AccumulateViews, compose::ComposeViews, debug_view::DebugViewViews, fit::FitViews,
    innovation::InnovationViews, predict::PredictViews, reproject::ReprojectViews,
    sample_map::SampleMapViews,
};
use crate::statistics::StatisticsReader;
use crate::{
    Allocation, Budget, Camera, Centres, CreateError, DebugView, DenoiserDescriptor, FrameError, FrameInputs,
    FrameOutputs, HistoryMode, Notice, SampleMap, Settings, Statistics, Windows, layout,
};
use bytemuck::Zeroable;
use std::sync::Arc;
use wgpu::{Buffer, BufferUsages, TextureFormat, TextureView};

/// Denoises what one camera sees at one render size. Owns history and scratch; the caller owns every input, the output
/// and the encoder.
#[derive(Debug)]
pub struct Denoiser {
    size: [u32; 2],
    pipelines: Arc<Pipelines>,
    history: History,
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
}

/// What lives for one frame only, or for less: what is dead lends its memory to what comes after.
#[derive(Debug)]
struct Scratch {
    /// Later, where a debug view shows it, the mix weight.
    signal: TextureView,
    /// Later the prediction.
    reprojected: TextureView,
    /// Later, where somebody asks for it, the output's expected error.
    reprojected_noise: TextureView,
    /// Per tile: of the change of the light, later of the temporal means.
    moments: Buffer,
    innovations: Buffer,
    /// One per tile. Under a budget they outlive the frame.
    models: Buffer,
    /// The window of each tile's model and its age; 0 for no model.
    windows: Buffer,
    coverage: Buffer,
    centre_list: Buffer,
    /// Per level: arguments of an indirect dispatch, number of models; then the number of models that were kept.
    levels: Buffer,
    /// `windows` of the frame before, later what they come to in this one. Used under a budget only, as the next.
    kept: Buffer,
    /// Per level: tiles by what a model would gain them.
    histogram: Buffer,
    /// How many pixels are worth how much to sample, and what that is in samples.
    sample_histogram: Buffer,
    /// Stand in for optional inputs that did not come.
    no_float: TextureView,
    no_uint: TextureView,
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
            history: History::new(device, size),
            scratch: Scratch::new(device, size),
            previous_camera: None,
            frames: 0,
            statistics: StatisticsReader::default(),
            pacing: None,
            was_noticed: false,
            was_limited: false,
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
        self.history.memory().into_iter().chain(self.scratch.memory()).collect()
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
        let previous = self.previous_camera.filter(|_| inputs.history == HistoryMode::Continue);
        let (limit, notice) = self.limit(device, queue, inputs, settings);
        let uniforms = self.uniforms(inputs, settings, previous, limit);
        // A buffer of its own per frame: several frames may be recorded before one submission.
        let frame = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("quell frame"),
            size: size_of::<FrameUniforms>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&frame, 0, bytemuck::bytes_of(&uniforms));
        if let Some(pacing) = &self.pacing {
            pacing.begin(encoder);
        }
        self.clear(encoder, previous.is_some(), limit.is_some());
        let timestamps = inputs.timestamps;
        self.record(&mut Recorder { device, encoder, frame: &frame, timestamps }, inputs, limit.is_some());
        if let Some(pacing) = &mut self.pacing {
            pacing.end(device, encoder, self.frames);
        }
        self.statistics.record(device, encoder, &self.scratch.levels, self.frames, limit);

        self.history.swap();
        self.previous_camera = Some(inputs.camera);
        self.frames = self.frames.wrapping_add(1);
        self.was_limited = limit.is_some();
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

    /// Clears what passes count in, and hands the models of the frame before on where they may be kept.
    fn clear(&self, encoder: &mut wgpu::CommandEncoder, has_history: bool, is_limited: bool) {
        let Scratch { windows, coverage, levels, kept, histogram, sample_histogram, .. } = &self.scratch;
        if is_limited {
            if has_history && self.was_limited {
                encoder.copy_buffer_to_buffer(windows, 0, kept, 0, kept.size());
            } else {
                encoder.clear_buffer(kept, 0, None);
            }
            encoder.clear_buffer(histogram, 0, None);
        }
        for buffer in [windows, coverage, levels, sample_histogram] {
            encoder.clear_buffer(buffer, 0, None);
        }
    }

    /// The frame, pass by pass.
    fn record(&self, recorder: &mut Recorder<'_>, inputs: &FrameInputs<'_>, is_limited: bool) {
        let Scratch { signal, reprojected, reprojected_noise, moments, innovations, models, .. } =
            &self.scratch;
        let Scratch { windows, coverage, centre_list, levels, kept, histogram, .. } = &self.scratch;
        let Scratch { sample_histogram, no_float, no_uint, .. } = &self.scratch;
        let (prediction, mix_weight, error) = (reprojected, signal, reprojected_noise);
        let History { mean: history, noise, .. } = &self.history;
        let (guide, previous_guide) = (self.history.guide(), self.history.previous_guide());
        let FrameInputs { radiance, albedo, normal_roughness, depth, motion, output, .. } = *inputs;
        let emission = inputs.emission.unwrap_or(no_float);
        let surface_id = inputs.surface_id.unwrap_or(no_uint);
        let sample_count = inputs.sample_count.unwrap_or(no_uint);
        let passes = &self.pipelines;

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
            &ComposeViews { guide, prediction, history, noise, albedo, emission, output, error, mix_weight },
            self.size,
        );
        match inputs.sample_map {
            Some(SampleMap { view: samples, .. }) => passes.sample_map.record(
                recorder,
                &SampleMapViews { guide, motion, history, error, sample_histogram, samples },
                self.size,
            ),
            None => recorder.skip_pass("sample_map"),
        }
        if let Some((_, debug)) = inputs.debug {
            passes.debug_view.record(
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
        } else {
            recorder.skip_pass("debug_view");
        }
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
                | flag(settings.windows == Windows::RingError, flags::RING_ERROR)
                | flag(wants_error, flags::ERROR)
                | flag(matches!(inputs.debug, Some((DebugView::MixWeight, _))), flags::SHOW_MIX),
            sample_budget: inputs.sample_map.map_or(0.0, |map| map.samples_per_pixel),
            dark_level: inputs.sample_map.map_or(0.0, |map| map.dark_level),
            model_limit: limit.unwrap_or(u32::MAX),
            debug_view: inputs.debug.map_or(0, |(view, _)| view as u32),
            ..FrameUniforms::zeroed()
        };
        uniforms.set_cameras(&inputs.camera, &previous.unwrap_or(inputs.camera));
        uniforms.set_windows(settings.windows, settings.centres);
        uniforms
    }
}

impl Scratch {
    fn new(device: &wgpu::Device, size: [u32; 2]) -> Self {
        let tiles = layout::count(layout::tiles(size));
        Self {
            signal: image(device, "quell signal", size, TextureFormat::R32Uint),
            reprojected: image(device, "quell reprojected", size, TextureFormat::Rg32Uint),
            reprojected_noise: image(device, "quell reprojected noise", size, TextureFormat::R32Uint),
            moments: buffer(device, "quell moments", layout::moments(tiles)),
            innovations: buffer(
                device,
                "quell innovations",
                layout::models(layout::count(layout::innovation_centres(size))),
            ),
            models: buffer(device, "quell models", layout::models(tiles)),
            windows: words(device, "quell windows", tiles, BufferUsages::COPY_DST | BufferUsages::COPY_SRC),
            coverage: words(device, "quell coverage", tiles, BufferUsages::COPY_DST),
            centre_list: buffer(device, "quell centre list", tiles),
            levels: words(
                device,
                "quell levels",
                u64::from(LEVELS_WORDS),
                BufferUsages::INDIRECT | BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
            ),
            kept: words(device, "quell kept", tiles, BufferUsages::COPY_DST),
            histogram: words(
                device,
                "quell histogram",
                u64::from(BUCKETS) * LEVELS as u64,
                BufferUsages::COPY_DST,
            ),
            sample_histogram: words(
                device,
                "quell sample histogram",
                SAMPLE_BUCKETS + 1,
                BufferUsages::COPY_DST,
            ),
            no_float: image(device, "quell no image", [1, 1], TextureFormat::R32Float),
            no_uint: image(device, "quell no image", [1, 1], TextureFormat::R32Uint),
        }
    }

    fn memory(&self) -> Vec<Allocation> {
        vec![
            Allocation::of_image("signal", &self.signal),
            Allocation::of_image("reprojected", &self.reprojected),
            Allocation::of_image("reprojected_noise", &self.reprojected_noise),
            Allocation::of_buffer("moments", &self.moments),
            Allocation::of_buffer("innovations", &self.innovations),
            Allocation::of_buffer("models", &self.models),
            Allocation::of_buffer("windows", &self.windows),
            Allocation::of_buffer("coverage", &self.coverage),
            Allocation::of_buffer("centre_list", &self.centre_list),
            Allocation::of_buffer("kept", &self.kept),
        ]
    }
}
