//! The denoiser: owns passes, history and scratch. [`Denoiser::encode`] is the frame, top to bottom.

use crate::gpu::{FrameUniforms, Recorder, buffer, flags, image, words};
use crate::history::History;
use crate::layout::{GridSizes, LEVEL_WORDS, LEVELS};
use crate::passes::{
    Pipelines, accumulate::AccumulateViews, change::ChangeViews, compose::ComposeViews,
    debug_view::DebugViewViews, fit::FitViews, innovation::InnovationViews, moments::MomentsViews,
    predict::PredictViews, prepare::PrepareViews, reproject::ReprojectViews,
};
use crate::statistics::StatisticsReader;
use crate::{
    Allocation, Camera, CreateError, DenoiserDescriptor, FrameError, FrameInputs, FrameOutputs, HistoryMode,
    Settings, Statistics, Windows, layout,
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
}

/// What lives for one frame only.
#[derive(Debug)]
struct Scratch {
    signal: TextureView,
    reprojected: TextureView,
    reprojected_noise: TextureView,
    prediction: TextureView,
    mix_weight: TextureView,
    regions: Moments,
    innovations: Buffer,
    tiles: Moments,
    models: Buffer,
    /// Radius of each tile's model's window; 0 for no model.
    windows: Buffer,
    coverage: Buffer,
    centre_list: Buffer,
    /// Per level: arguments of an indirect dispatch, number of models.
    levels: Buffer,
    /// Stand in for optional inputs that did not come.
    no_float: TextureView,
    no_uint: TextureView,
}

/// Moments of a grid of tiles or regions.
#[derive(Debug)]
struct Moments {
    means: Buffer,
    squares_low: Buffer,
    squares_high: Buffer,
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
        *self = Self::with_pipelines(device, descriptor, self.pipelines())?;
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
        let uniforms = self.uniforms(inputs, settings, previous);
        // A buffer of its own per frame: several frames may be recorded before one submission.
        let frame = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("quell frame"),
            size: size_of::<FrameUniforms>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        queue.write_buffer(&frame, 0, bytemuck::bytes_of(&uniforms));
        let Scratch { windows, coverage, levels, .. } = &self.scratch;
        for buffer in [windows, coverage, levels] {
            encoder.clear_buffer(buffer, 0, None);
        }
        self.record(&mut Recorder { device, encoder, frame: &frame, timestamps: inputs.timestamps }, inputs);

        self.statistics.record(device, encoder, &self.scratch.levels, self.frames);

        self.history.swap();
        self.previous_camera = Some(inputs.camera);
        self.frames = self.frames.wrapping_add(1);
        Ok(FrameOutputs { restarted: previous.is_none() })
    }

    /// The frame, pass by pass.
    fn record(&self, recorder: &mut Recorder<'_>, inputs: &FrameInputs<'_>) {
        let Scratch { signal, reprojected, reprojected_noise, prediction, mix_weight, .. } = &self.scratch;
        let Scratch { regions, innovations, tiles, models, windows, coverage, centre_list, levels, .. } =
            &self.scratch;
        let (current, previous) = (self.history.current(), self.history.previous());
        let (guide, history, noise) = (&current.guide, &current.mean, &current.noise);
        let FrameInputs { radiance, albedo, normal_roughness, depth, motion, output, .. } = *inputs;
        let emission = inputs.emission.unwrap_or(&self.scratch.no_float);
        let surface_id = inputs.surface_id.unwrap_or(&self.scratch.no_uint);
        let sample_count = inputs.sample_count.unwrap_or(&self.scratch.no_uint);
        let passes = &self.pipelines;

        passes.prepare.record(
            recorder,
            &PrepareViews {
                radiance,
                albedo,
                normal_roughness,
                depth,
                surface_id,
                emission,
                sample_count,
                signal,
                guide,
            },
            self.size,
        );
        passes.reproject.record(
            recorder,
            &ReprojectViews {
                guide,
                motion,
                previous_guide: &previous.guide,
                previous_history: &previous.mean,
                previous_noise: &previous.noise,
                reprojected,
                reprojected_noise,
            },
            self.size,
        );
        passes.change.record(
            recorder,
            &ChangeViews {
                signal,
                guide,
                reprojected,
                reprojected_noise,
                tile_means: &regions.means,
                tile_squares_low: &regions.squares_low,
                tile_squares_high: &regions.squares_high,
            },
            self.size,
        );
        passes.innovation.record(
            recorder,
            &InnovationViews {
                tile_means: &regions.means,
                tile_squares_low: &regions.squares_low,
                tile_squares_high: &regions.squares_high,
                innovations,
            },
            layout::regions(self.size),
        );
        passes.accumulate.record(
            recorder,
            &AccumulateViews { signal, guide, reprojected, reprojected_noise, innovations, history, noise },
            self.size,
        );
        passes.moments.record(
            recorder,
            &MomentsViews {
                guide,
                history,
                noise,
                tile_means: &tiles.means,
                tile_squares_low: &tiles.squares_low,
                tile_squares_high: &tiles.squares_high,
            },
            self.size,
        );
        passes.fit.record(
            recorder,
            &FitViews {
                tile_means: &tiles.means,
                tile_squares_low: &tiles.squares_low,
                tile_squares_high: &tiles.squares_high,
                centre_list,
                levels,
                models,
                windows,
                coverage,
            },
            layout::tiles(self.size),
        );
        passes.predict.record(
            recorder,
            &PredictViews { guide, history, noise, models, windows, prediction },
            self.size,
        );
        passes.compose.record(
            recorder,
            &ComposeViews {
                guide,
                prediction,
                history,
                noise,
                radiance,
                albedo,
                emission,
                output,
                mix_weight,
            },
            self.size,
        );
        if let Some((_, debug)) = inputs.debug {
            passes.debug_view.record(
                recorder,
                &DebugViewViews { guide, motion, prediction, history, mix_weight, models, windows, debug },
                self.size,
            );
        }
    }

    fn uniforms(
        &self,
        inputs: &FrameInputs<'_>,
        settings: &Settings,
        previous: Option<Camera>,
    ) -> FrameUniforms {
        let flag = |set: bool, bit: u32| if set { bit } else { 0 };
        let motion_depth = inputs.motion.texture().format() == TextureFormat::Rgba16Float;
        let mut uniforms = FrameUniforms {
            far: settings.far,
            size: self.size,
            tiles: layout::tiles(self.size),
            regions: layout::regions(self.size),
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
                | flag(settings.windows == Windows::RingError, flags::RING_ERROR),
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
        let float = TextureFormat::R32Float;
        let half_rgba = TextureFormat::Rgba16Float;
        let tile_count = layout::count(layout::tiles(size));
        let tiles = GridSizes::of(layout::MODELS, tile_count);
        let regions = GridSizes::of(layout::INNOVATIONS, layout::count(layout::regions(size)));
        Self {
            signal: image(device, "quell signal", size, half_rgba),
            reprojected: image(device, "quell reprojected", size, half_rgba),
            reprojected_noise: image(device, "quell reprojected noise", size, half_rgba),
            prediction: image(device, "quell prediction", size, half_rgba),
            mix_weight: image(device, "quell mix weight", size, float),
            regions: Moments::new(device, "quell region", regions),
            innovations: buffer(device, "quell innovations", regions.models),
            tiles: Moments::new(device, "quell tile", tiles),
            models: buffer(device, "quell models", tiles.models),
            windows: words(device, "quell windows", tile_count, BufferUsages::COPY_DST),
            coverage: words(device, "quell coverage", tile_count, BufferUsages::COPY_DST),
            centre_list: buffer(device, "quell centre list", tile_count),
            levels: words(
                device,
                "quell levels",
                u64::from(LEVEL_WORDS) * LEVELS as u64,
                BufferUsages::INDIRECT | BufferUsages::COPY_DST | BufferUsages::COPY_SRC,
            ),
            no_float: image(device, "quell no image", [1, 1], float),
            no_uint: image(device, "quell no image", [1, 1], TextureFormat::R32Uint),
        }
    }
}

impl Scratch {
    fn memory(&self) -> Vec<Allocation> {
        let Self { signal, reprojected, reprojected_noise, prediction, mix_weight, .. } = self;
        let Self { regions, innovations, tiles, models, windows, coverage, centre_list, .. } = self;
        vec![
            Allocation::of_image("signal", signal),
            Allocation::of_image("reprojected", reprojected),
            Allocation::of_image("reprojected_noise", reprojected_noise),
            Allocation::of_image("prediction", prediction),
            Allocation::of_image("mix_weight", mix_weight),
            regions.memory("region_moments"),
            Allocation::of_buffer("innovations", innovations),
            tiles.memory("tile_moments"),
            Allocation::of_buffer("models", models),
            Allocation::of_buffer("windows", windows),
            Allocation::of_buffer("coverage", coverage),
            Allocation::of_buffer("centre_list", centre_list),
        ]
    }
}

impl Moments {
    fn memory(&self, name: &'static str) -> Allocation {
        let bytes = self.means.size() + self.squares_low.size() + self.squares_high.size();
        Allocation { name, bytes }
    }

    fn new(device: &wgpu::Device, of: &str, sizes: GridSizes) -> Self {
        Self {
            means: buffer(device, &format!("{of} means"), sizes.means),
            squares_low: buffer(device, &format!("{of} squares low"), sizes.half_squares),
            squares_high: buffer(device, &format!("{of} squares high"), sizes.half_squares),
        }
    }
}
