//! The walkthrough in a window: traces and denoises what the window asks for.

use crate::gbuffer::GBuffer;
use crate::gpu::Gpu;
use crate::gpu_timer::GpuTimer;
use crate::method::{Method, MethodFrame, MethodRunner, output_image};
use crate::scene::{Shown, Tour};
use crate::tracer::{FrameView, ReferenceImage, Sampling, TraceSettings, Tracer, camera_of};
use crate::window::{FrameImages, FrameRequest, FrameSource, ViewMode};
use anyhow::Result;
use quell::Camera;

/// Scenes that a window shows.
pub struct Walkthrough {
    tour: Tour,
    /// One per part of the tour.
    tracers: Vec<Tracer>,
    seed: u32,
    /// Pixels a frame may have; the window's image area is scaled down to it.
    most_pixels: f32,
    shown: Shown,
    frame: u32,
    previous: Option<(Camera, f32)>,
    targets: Option<Targets>,
}

/// Images and methods of one render size.
struct Targets {
    size: [u32; 2],
    gbuffer: GBuffer,
    quell: MethodRunner,
    /// What quell is compared with, since it was last chosen and on screen.
    rival: Option<MethodRunner>,
    /// Whether `rival` saw the previous frame.
    rival_followed: bool,
    debug: wgpu::TextureView,
    /// Whether quell was asked for samples in the previous frame.
    sample_map_is_new: bool,
    reference: ReferenceImage,
    /// What `reference` shows.
    reference_view: Option<(Camera, f32)>,
}

/// A CPU adapter takes about a second for this many pixels.
const CPU_PIXELS: f32 = 320.0 * 180.0;
const GPU_PIXELS: f32 = 1920.0 * 1080.0;

impl Walkthrough {
    pub fn new(gpu: &Gpu, tour: Tour, seed: u32, start_s: f32) -> Result<Self> {
        let on_cpu = gpu.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
        Ok(Self {
            tracers: tour.scenes().map(|scene| Tracer::new(gpu, scene)).collect::<Result<_>>()?,
            seed,
            most_pixels: if on_cpu { CPU_PIXELS } else { GPU_PIXELS },
            shown: tour.at(start_s),
            tour,
            frame: 0,
            previous: None,
            targets: None,
        })
    }

    /// Goes on in time. Who flies about stays in a scene, those who walk come to the next in time.
    fn advance(&mut self, request: &FrameRequest<'_>) -> Shown {
        let part = self.shown.part;
        self.shown.time_s += request.time_step_s;
        if request.free_view.is_none() {
            self.shown = self.tour.at(self.tour.start_s(part) + self.shown.time_s);
        }
        if self.shown.part != part {
            self.previous = None;
        }
        self.shown
    }

    fn render_size(&self, [width, height]: [u32; 2]) -> [u32; 2] {
        let scale = (self.most_pixels / (width as f32 * height as f32)).sqrt().min(1.0);
        [width, height].map(|side| ((side as f32 * scale).round() as u32).max(1))
    }

    /// Images of the wanted size; new ones, without history, where it changed.
    fn targets(&mut self, gpu: &Gpu, size: [u32; 2]) -> Result<Targets> {
        if let Some(targets) = self.targets.take().filter(|targets| targets.size == size) {
            return Ok(targets);
        }
        self.previous = None;
        let [width, height] = size;
        Ok(Targets {
            size,
            gbuffer: GBuffer::new(&gpu.device, width, height),
            quell: MethodRunner::new(gpu, Method::Quell, width, height)?,
            rival: None,
            rival_followed: false,
            debug: output_image(&gpu.device, width, height),
            sample_map_is_new: false,
            reference: ReferenceImage::new(&gpu.device, width, height),
            reference_view: None,
        })
    }
}

impl FrameSource for Walkthrough {
    fn frame(
        &mut self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        request: &FrameRequest<'_>,
        timer: &mut GpuTimer,
    ) -> Result<FrameImages> {
        let size = self.render_size(request.area);
        let mut targets = self.targets(gpu, size)?;
        let Shown { part, time_s } = self.advance(request);
        let tracer = &self.tracers[part];
        let mut camera = camera_of(&self.tour.scene(part).camera(time_s), size[0], size[1]);
        camera.view_from_world = request.free_view.unwrap_or(camera.view_from_world);
        let signals = request.view.signals;
        if targets.gbuffer.split != signals {
            // Only while the denoiser takes them: tracing apart costs time.
            targets.gbuffer = GBuffer::with_split(&gpu.device, size[0], size[1], signals);
            targets.sample_map_is_new = false;
        }
        let view = FrameView { camera, time_s, previous: self.previous };
        let (spp, sampling) = (request.view.spp, request.view.sampling);
        let is_adaptive = sampling == Sampling::Adaptive;
        let settings = TraceSettings {
            spp,
            // Uniform where nobody has asked for anything yet.
            sampling: if is_adaptive && !targets.sample_map_is_new { Sampling::Uniform } else { sampling },
            seed: self.seed,
            frame: self.frame,
            ..TraceSettings::default()
        };
        let timestamps = timer.reserve(&["path tracer"]);
        tracer.encode_timed(gpu, encoder, &view, &settings, &targets.gbuffer, timestamps);

        let restart = request.restart || self.previous.is_none();
        let denoiser_settings = &request.view.settings;
        let debug = request.view.debug.map(|debug| (debug, &targets.debug));
        let timestamps = timer.reserve(targets.quell.passes());
        let frame = MethodFrame::new(&targets.gbuffer, camera, restart, denoiser_settings);
        let sample_budget = is_adaptive.then_some(spp);
        targets.quell.encode(gpu, encoder, &MethodFrame { debug, sample_budget, timestamps, ..frame })?;
        targets.sample_map_is_new = is_adaptive;
        let shows_rival = request.view.shows(ViewMode::Rival);
        if shows_rival {
            let chosen = request.view.rival;
            let kept = targets.rival.take().filter(|runner| runner.method() == chosen);
            let mut rival = match kept {
                Some(runner) => runner,
                None => MethodRunner::new(gpu, chosen, size[0], size[1])?,
            };
            let restart = restart || !targets.rival_followed;
            let timestamps = timer.reserve(rival.passes());
            rival.encode(gpu, encoder, &MethodFrame { restart, timestamps, ..frame })?;
            targets.rival = Some(rival);
        }
        targets.rival_followed = shows_rival;
        let shows_reference = request.view.shows(ViewMode::Reference);
        if shows_reference {
            let shown = Some((camera, time_s));
            if targets.reference_view != shown {
                targets.reference.clear();
                targets.reference_view = shown;
            }
            let settings =
                TraceSettings { seed: !self.seed, spp: 1.0, sampling: Sampling::Uniform, ..settings };
            tracer.accumulate_reference(gpu, encoder, &view, &settings, &targets.reference);
        }
        let images = FrameImages {
            noisy: Some(targets.gbuffer.radiance.clone()),
            rival: targets.rival.as_ref().filter(|_| shows_rival).map(|rival| rival.output().clone()),
            denoised: targets.quell.output().clone(),
            reference: shows_reference.then(|| targets.reference.view().clone()),
            debug: debug.map(|(_, view)| view.clone()),
            view_from_world: camera.view_from_world,
            status: status(
                &self.tour.name,
                size,
                self.tour.start_s(part) + time_s,
                targets.quell.models(),
                shows_reference.then(|| targets.reference.samples()),
            ),
        };
        self.previous = Some((camera, time_s));
        self.frame = self.frame.wrapping_add(1);
        self.targets = Some(targets);
        Ok(images)
    }
}

fn status(
    scene: &str,
    [width, height]: [u32; 2],
    time_s: f32,
    models: Option<u32>,
    reference_spp: Option<u32>,
) -> String {
    let models = models.map_or(String::new(), |models| {
        format!(
            ", {models} models (one per {:.0} pixels)",
            f64::from(width * height) / f64::from(models.max(1))
        )
    });
    let reference =
        reference_spp.map_or(String::new(), |spp| format!(", reference {spp} spp (pause to converge)"));
    format!("{scene}, {width}x{height}, {time_s:.1} s{models}{reference}")
}
