//! A walk through a scene: which frame shows what, and tracing it.

use crate::gbuffer::{GBuffer, Split};
use crate::gpu::Gpu;
use crate::halton;
use crate::image::ImageRgb;
use crate::scene::{Scene, Shown, Tour, gallery, gltf};
use crate::tracer::{FrameView, ReferenceImage, Sampling, TraceSettings, Tracer, camera_of};
use anyhow::{Result, ensure};
use std::path::{Path, PathBuf};

/// What to walk through and how to trace it.
#[derive(Debug, Clone)]
pub struct WalkOptions {
    /// A glTF file; the built-in gallery without.
    pub scene: Option<PathBuf>,
    pub width: u32,
    pub height: u32,
    pub frames: u32,
    /// Frames per second of scene time.
    pub fps: f32,
    /// Scene time of the first frame, seconds.
    pub start_s: f32,
    /// Samples per pixel, in the mean; above 0.
    pub spp: f32,
    /// Where they go; with [`Sampling::Adaptive`] the frame after a cut is sampled uniformly.
    pub sampling: Sampling,
    pub seed: u32,
    /// Whether samples lie elsewhere in the pixel in every frame, and all over it in references.
    pub jitter: bool,
    /// What is traced apart. It changes neither the paths nor combined radiance.
    pub split: Split,
}

/// Loads a scene, or builds the gallery's tour. Says on standard error what of a file is not shown.
pub fn load_scene(path: Option<&Path>) -> Result<Tour> {
    let Some(path) = path else {
        return Ok(gallery::tour());
    };
    let scene = gltf::load(path)?;
    scene.notes.iter().for_each(|note| eprintln!("note: {}: {note}", path.display()));
    Ok(Tour::of(scene))
}

/// Scene time, or a tour's, of frame `index`.
fn time_s(options: &WalkOptions, index: u32) -> f32 {
    options.start_s + index as f32 / options.fps
}

/// Samples of a reference that go into one submit: drivers end work that takes seconds.
const REFERENCE_BATCH_SPP: u32 = 4;
/// Keeps a reference's random numbers apart from those of the frames it is compared with.
const REFERENCE_SEED: u32 = 0x5eed_0000;

/// Scenes on the GPU, and the images their frames are traced into.
#[derive(Debug)]
pub struct Walk {
    options: WalkOptions,
    tour: Tour,
    /// One per part of the tour; none for those that no frame shows.
    tracers: Vec<Option<Tracer>>,
    gbuffer: GBuffer,
}

impl Walk {
    /// Loads the scene and uploads what of it the walk's frames show.
    pub fn new(gpu: &Gpu, options: WalkOptions) -> Result<Self> {
        let largest = gpu.device.limits().max_texture_dimension_2d;
        let (width, height) = (options.width, options.height);
        ensure!(
            (1..=largest).contains(&width) && (1..=largest).contains(&height),
            "size {width}x{height}: both sides must be 1 to {largest} pixels"
        );
        let tour = load_scene(options.scene.as_deref())?;
        let is_shown = |part| (0..options.frames).any(|index| tour.at(time_s(&options, index)).part == part);
        let tracer = |(part, scene)| is_shown(part).then(|| Tracer::new(gpu, scene)).transpose();
        let tracers = tour.scenes().enumerate().map(tracer).collect::<Result<_>>()?;
        let gbuffer = GBuffer::with_split(&gpu.device, width, height, options.split);
        Ok(Self { options, tour, tracers, gbuffer })
    }

    pub fn scene_name(&self) -> &str {
        &self.tour.name
    }

    /// The scene that frame `index` shows, and its time there.
    pub fn scene_at(&self, index: u32) -> (&Scene, f32) {
        let Shown { part, time_s } = self.shown(index);
        (self.tour.scene(part), time_s)
    }

    /// Whether frame `index` continues none: the first, and those where another scene begins.
    pub fn is_cut(&self, index: u32) -> bool {
        index == 0 || self.shown(index).part != self.shown(index - 1).part
    }

    fn shown(&self, index: u32) -> Shown {
        self.tour.at(time_s(&self.options, index))
    }

    /// The images of the frame that was traced last.
    pub fn gbuffer(&self) -> &GBuffer {
        &self.gbuffer
    }

    /// What frame `index` shows.
    pub fn view(&self, index: u32) -> FrameView {
        let at = |index: u32| {
            let (scene, time_s) = self.scene_at(index);
            let pose = scene.camera(time_s);
            let mut camera = camera_of(&pose, self.options.width, self.options.height);
            if self.options.jitter {
                camera.jitter_px = halton::jitter_px(index);
            }
            (camera, time_s)
        };
        let (camera, time_s) = at(index);
        let previous = (!self.is_cut(index)).then(|| at(index - 1));
        FrameView { camera, time_s, previous }
    }

    /// The tracer of the scene that frame `index` shows.
    ///
    /// Panics for a frame outside the walk that shows a scene which no frame in it does.
    fn tracer(&self, index: u32) -> &Tracer {
        self.tracers[self.shown(index).part].as_ref().expect("the frame lies in the walk")
    }

    /// Records the tracing of frame `index` into [`gbuffer`](Self::gbuffer).
    pub fn trace(&self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, index: u32) {
        self.trace_with(gpu, encoder, index, self.options.spp, self.options.sampling);
    }

    /// [`trace`](Self::trace) with other samples.
    pub fn trace_with(
        &self,
        gpu: &Gpu,
        encoder: &mut wgpu::CommandEncoder,
        index: u32,
        spp: f32,
        sampling: Sampling,
    ) {
        let seed = self.options.seed;
        // After a cut nobody has asked for anything yet.
        let is_blind = self.is_cut(index) && sampling == Sampling::Adaptive;
        let sampling = if is_blind { Sampling::Uniform } else { sampling };
        let settings = TraceSettings { spp, sampling, seed, frame: index, ..TraceSettings::default() };
        self.tracer(index).encode(gpu, encoder, &self.view(index), &settings, &self.gbuffer);
    }

    /// Frame `index` traced with `spp` samples per pixel, with jitter each elsewhere in the pixel. Waits for the GPU; `progress`
    /// hears of samples as they are done.
    pub fn reference(&self, gpu: &Gpu, index: u32, spp: u32, progress: impl Fn(u32)) -> Result<ImageRgb> {
        let WalkOptions { width, height, seed, jitter, .. } = self.options;
        let image = ReferenceImage::new(&gpu.device, width, height);
        let mut view = self.view(index);
        // The samples of a batch share their place in the pixel.
        let batch_spp = if jitter { 1 } else { REFERENCE_BATCH_SPP };
        let offsets = halton::offsets_px(spp);
        while image.samples() < spp {
            let batch = batch_spp.min(spp - image.samples());
            if jitter {
                view.camera.jitter_px = offsets[image.samples() as usize];
            }
            let settings = TraceSettings {
                spp: batch as f32,
                seed: seed ^ REFERENCE_SEED,
                frame: index.wrapping_mul(0x1_0001).wrapping_add(image.samples()),
                ..TraceSettings::default()
            };
            let mut encoder = gpu.device.create_command_encoder(&Default::default());
            self.tracer(index).accumulate_reference(gpu, &mut encoder, &view, &settings, &image);
            gpu.queue.submit([encoder.finish()]);
            gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
            progress(batch);
        }
        Ok(ImageRgb { width, height, pixels: image.resolve(gpu)? })
    }
}

/// Which frames get a reference.
#[derive(Debug, Clone, Default)]
pub struct References {
    /// Samples per pixel; 0 for no references.
    pub spp: u32,
    /// Frames by number; without, four pairs of neighbours spread over the walk (pairs, so that change can be measured).
    pub frames: Option<Vec<u32>>,
}

impl References {
    /// The chosen frames of a walk of `count`, in order.
    pub fn chosen(&self, count: u32) -> Result<Vec<u32>> {
        if self.spp == 0 {
            return Ok(Vec::new());
        }
        let mut chosen = match &self.frames {
            Some(frames) => frames.clone(),
            None => (1..=4)
                .map(|i| (count * i / 4).max(1))
                .flat_map(|end| [end.saturating_sub(2), end - 1])
                .collect(),
        };
        if let Some(beyond) = chosen.iter().find(|&&frame| frame >= count) {
            anyhow::bail!("reference frame {beyond}: the walk has {count} frames, numbered from 0");
        }
        chosen.sort_unstable();
        chosen.dedup();
        Ok(chosen)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_are_pairs_within_the_walk() {
        let references = References { spp: 16, frames: None };
        assert_eq!(references.chosen(40).unwrap(), [8, 9, 18, 19, 28, 29, 38, 39]);
        for count in 1..20 {
            assert!(references.chosen(count).unwrap().iter().all(|&frame| frame < count));
        }
        assert!(References::default().chosen(40).unwrap().is_empty());
    }

    #[test]
    fn chosen_references_are_sorted_and_checked() {
        let references = References { spp: 1, frames: Some(vec![7, 3, 7]) };
        assert_eq!(references.chosen(8).unwrap(), [3, 7]);
        let message = references.chosen(7).unwrap_err().to_string();
        assert!(message.contains("frame 7") && message.contains("7 frames"), "{message}");
    }
}
