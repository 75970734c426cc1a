//! One frame: what its passes are told, and which run on what.

use crate::denoiser::{Previous, Specular};
use crate::gpu::{FrameUniforms, Recorder, flags};
use crate::guides::Guides;
use crate::passes::{
    Pipelines, SignalPasses, accumulate::AccumulateViews, compose::ComposeViews, debug_view::DebugViewViews,
    fit::FitViews, innovation::InnovationViews, reproject::ReprojectViews, sample_map::SampleMapViews,
};
use crate::scratch::Scratch;
use crate::settings::{BILINEAR_HISTORY, SPARSE_MOMENTS};
use crate::signal::Signal;
use crate::{Camera, DebugView, FrameInputs, SampleMap, Settings, Viewport, Windows, layout};
use bytemuck::Zeroable;
use wgpu::{TextureFormat, TextureView};

/// A frame that was checked and whose resources are there.
pub(crate) struct Recording<'a> {
    pub pipelines: &'a Pipelines,
    pub guides: &'a Guides,
    /// The radiance, or what of it did not leave the first hit through the specular lobe.
    pub signal: &'a Signal,
    pub passes: &'a SignalPasses,
    /// Where the radiance came apart.
    pub specular: Option<(&'a Specular, &'a SignalPasses)>,
    pub scratch: &'a Scratch,
    pub inputs: &'a FrameInputs<'a>,
    pub settings: &'a Settings,
    pub viewport: Viewport,
    /// Right-handed.
    pub camera: Camera,
    /// The frame whose history is continued.
    pub previous: Option<Previous>,
    /// How many models may be fitted.
    pub limit: Option<u32>,
    /// How many of the [`SAVINGS`](crate::SAVINGS) are taken.
    pub savings: u32,
}

/// What of the caller's images belongs to one of the signals.
struct SignalImages<'a> {
    radiance: &'a TextureView,
    albedo: &'a TextureView,
    emission: &'a TextureView,
    rest: &'a TextureView,
    output: &'a TextureView,
}

impl Recording<'_> {
    /// The frame: its one signal, or one after the other the two that it came apart in; then what is made on request.
    pub fn record(&self, recorder: &mut Recorder<'_>) {
        let inputs = self.inputs;
        let Scratch { no_float, sample_histogram, reprojected_noise: error, .. } = &self.scratch;
        let FrameInputs { radiance, albedo, output, .. } = *inputs;
        let emission = inputs.emission.unwrap_or(no_float);
        recorder.encoder.clear_buffer(sample_histogram, 0, None);
        let combined = SignalImages { radiance, albedo, emission, rest: no_float, output };
        let mut shown = Some(self.signal);
        if let (Some(radiance), Some((Specular { signal, rest }, passes))) = (inputs.specular, self.specular)
        {
            let of_rest = SignalImages { output: rest, ..combined };
            self.record_signal(recorder, self.passes, self.signal, &of_rest);
            shown = Some(signal);
            if self.shows_rest() {
                self.record_debug_view(recorder, self.signal);
                shown = None;
            }
            recorder.is_specular = true;
            let albedo = inputs.specular_albedo.unwrap_or(no_float);
            let of_specular = SignalImages { radiance, albedo, emission: no_float, rest, output };
            self.record_signal(recorder, passes, signal, &of_specular);
        } else {
            self.record_signal(recorder, self.passes, self.signal, &combined);
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
                self.viewport.size,
            ),
            None => recorder.skip_pass("sample_map"),
        }
        if let Some(signal) = shown {
            self.record_debug_view(recorder, signal);
        }
    }

    /// One signal, pass by pass.
    fn record_signal(
        &self,
        recorder: &mut Recorder<'_>,
        passes: &SignalPasses,
        signal_state: &Signal,
        images: &SignalImages<'_>,
    ) {
        let Scratch { signal, reprojected, reprojected_noise, moments, innovations, .. } = &self.scratch;
        let Scratch { coverage, centre_list, histogram, no_float, no_uint, .. } = &self.scratch;
        let Signal { history, noise, models, windows, kept, levels } = signal_state;
        let (prediction, mix_weight, error) = (reprojected, signal, reprojected_noise);
        let (guide, previous_guide) = (self.guides.current(), self.guides.previous());
        let inputs = self.inputs;
        let FrameInputs { normal_roughness, depth, motion, .. } = *inputs;
        let SignalImages { radiance, albedo, emission, rest, output } = *images;
        let roughness = inputs.roughness.unwrap_or(no_float);
        let surface_id = inputs.surface_id.unwrap_or(no_uint);
        let sample_count = inputs.sample_count.unwrap_or(no_uint);
        let hit_distance = inputs.hit_distance.unwrap_or(no_float);
        let size = self.viewport.size;
        let is_alike =
            |previous: Previous| previous.was_limited == self.limit.is_some() && previous.size == size;

        signal_state.clear(recorder.encoder, self.previous.is_some_and(is_alike));
        for buffer in [coverage, histogram] {
            recorder.encoder.clear_buffer(buffer, 0, None);
        }
        passes.reproject.record(
            recorder,
            &ReprojectViews {
                radiance,
                albedo,
                normal_roughness,
                roughness,
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
            size,
        );
        passes.innovation.record(
            recorder,
            &InnovationViews { moments, innovations },
            layout::innovation_centres(size, self.saves(SPARSE_MOMENTS)),
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
            size,
        );
        passes.fit.record(
            recorder,
            &FitViews { moments, centre_list, levels, models, windows, coverage, kept, histogram },
            layout::tiles(size),
            self.limit.is_some(),
        );
        passes.compose.record(
            recorder,
            &ComposeViews {
                guide,
                models,
                windows,
                history,
                noise,
                albedo,
                emission,
                rest,
                output,
                error,
                prediction,
                mix_weight,
            },
            size,
        );
    }

    /// Shows an inner image of the signal that was recorded last.
    fn record_debug_view(&self, recorder: &mut Recorder<'_>, signal_state: &Signal) {
        let Some((_, debug)) = self.inputs.debug else {
            return recorder.skip_pass("debug_view");
        };
        let Signal { history, noise, models, windows, .. } = signal_state;
        let Scratch { signal: mix_weight, reprojected: prediction, reprojected_noise: error, .. } =
            &self.scratch;
        let (guide, motion) = (self.guides.current(), self.inputs.motion);
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
            self.viewport.size,
        );
    }

    /// What the frame's passes are told, the `index`-th.
    pub fn uniforms(&self, index: u32) -> FrameUniforms {
        let Self { inputs, settings, previous, limit, .. } = *self;
        let Viewport { origin, size } = self.viewport;
        let conventions = settings.conventions;
        let flag = |set: bool, bit: u32| if set { bit } else { 0 };
        let four_channels = [TextureFormat::Rgba16Float, TextureFormat::Rgba32Float];
        let motion_depth =
            conventions.motion_has_depth && four_channels.contains(&inputs.motion.texture().format());
        let wants_error =
            inputs.sample_map.is_some() || matches!(inputs.debug, Some((DebugView::OutputError, _)));
        let mut uniforms = FrameUniforms {
            far: settings.far,
            size,
            origin,
            tiles: layout::tiles(size),
            index,
            firefly_limit: settings.firefly_limit,
            max_history: settings.max_history,
            flags: inputs.flags()
                | flag(previous.is_some(), flags::HISTORY)
                | flag(motion_depth, flags::MOTION_DEPTH)
                | flag(settings.mix_temporal_mean, flags::MIX)
                | flag(self.saves(BILINEAR_HISTORY), flags::BILINEAR)
                | flag(self.saves(SPARSE_MOMENTS), flags::SPARSE)
                | flag(settings.innovation, flags::INNOVATION)
                | flag(limit.is_some(), flags::LIMITED)
                | flag(settings.windows == Windows::RingError, flags::RING_ERROR)
                | flag(wants_error, flags::ERROR)
                | flag(inputs.debug.is_some(), flags::DEBUG),
            sample_budget: inputs.sample_map.map_or(0.0, |map| map.samples_per_pixel),
            dark_level: inputs.sample_map.map_or(0.0, |map| map.dark_level),
            model_limit: self.model_limit().unwrap_or(u32::MAX),
            debug_view: inputs.debug.map_or(0, |(view, _)| view as u32),
            ..FrameUniforms::zeroed()
        };
        let (before, previous_size) =
            previous.map_or((self.camera, size), |previous| (previous.camera, previous.size));
        uniforms.set_cameras(&self.camera, &before, previous_size);
        uniforms.set_windows(settings.windows, settings.centres);
        conventions.enter(&mut uniforms, self.camera.clip_from_view);
        uniforms
    }

    /// How many models each signal may have.
    fn model_limit(&self) -> Option<u32> {
        self.limit.map(|limit| limit / self.inputs.signals())
    }

    /// Whether one of the savings is taken.
    fn saves(&self, saving: u32) -> bool {
        saving < self.savings
    }

    /// Where the models of each signal are counted.
    pub fn levels(&self) -> [Option<&wgpu::Buffer>; 2] {
        [Some(&self.signal.levels), self.specular.map(|(specular, _)| &specular.signal.levels)]
    }

    /// Whether the debug view is of the first of two signals. What the output is off by is known after the second.
    fn shows_rest(&self) -> bool {
        let is_of_one = |(view, _)| view != DebugView::OutputError;
        !self.settings.debug_specular && self.inputs.debug.is_some_and(is_of_one)
    }
}
