//! The suite's sequences: walks that are traced, and captures that are read.

use super::ReportOptions;
use super::events::{Event, light_switches};
use crate::capture::{CaptureReader, gbuffer_for, upload};
use crate::gbuffer::{GBuffer, Split};
use crate::gpu::Gpu;
use crate::image::ImageRgb;
use crate::scene::gallery;
use crate::tracer::Sampling;
use crate::walk::{Walk, WalkOptions};
use anyhow::{Context, Result};
use quell::{Camera, Settings};
use std::path::{Path, PathBuf};

/// A sequence of frames.
pub struct Stretch {
    pub name: String,
    /// Where it comes from and how it was made.
    pub source: String,
    pub size: [u32; 2],
    pub frames: u32,
    pub events: Vec<Event>,
    pub settings: Settings,
    origin: Origin,
}

enum Origin {
    Walk { walk: Box<Walk>, referenced: Vec<u32>, spp: u32 },
    Capture { reader: CaptureReader, split: Split, images: Option<Box<GBuffer>> },
}

/// A frame, ready to be denoised.
pub struct Frame<'a> {
    pub gbuffer: &'a GBuffer,
    pub camera: Camera,
    pub restart: bool,
    pub reference: Option<ImageRgb>,
}

/// Samples per pixel of what is traced: the denoiser's case.
const SPP: u32 = 1;
/// Where in the gallery's tour the hall begins, the room that only a far door lights, and where among the reflections the
/// camera passes from a straight line to a circle, in seconds.
const HALL_S: f32 = 8.0;
const DIM_ROOM_S: f32 = 16.0;
const REFLECTIONS_S: f32 = gallery::WALK_S + 5.2;
/// Share of the frames before the lamp goes off: history has to be there, and to be seen to recover.
const BEFORE_SWITCH: f32 = 0.6;

/// The built-in stretches of the gallery: name and start time.
fn gallery_stretches(options: &ReportOptions) -> [(&'static str, f32); 4] {
    let before = (options.frames as f32 * BEFORE_SWITCH) as u32;
    [
        ("Colonnade in the sun", 0.0),
        ("Hall, the lamp goes off", switch_off(options.fps) - before as f32 / options.fps),
        ("Dim room", DIM_ROOM_S),
        ("Reflections", REFLECTIONS_S),
    ]
}

/// The time of the first frame, after the hall is entered, that shows the lamp off.
fn switch_off(fps: f32) -> f32 {
    /// Longer than the lamp's period.
    const SEARCHED_S: f32 = 8.0;
    let times: Vec<f32> = (0..(SEARCHED_S * fps) as u32).map(|i| HALL_S + i as f32 / fps).collect();
    let events = light_switches(&gallery::gallery(), &times);
    let off = events.iter().find(|event| event.label.ends_with("off"));
    off.map_or(HALL_S, |event| times[event.frame as usize])
}

/// Opens all of the suite. What can be wrong with captures shows before anything is traced.
pub fn open(
    gpu: &Gpu,
    options: &ReportOptions,
    captures: Vec<(PathBuf, CaptureReader)>,
) -> Result<Vec<Stretch>> {
    let mut suite = Vec::new();
    if options.gallery {
        for (name, start_s) in gallery_stretches(options) {
            suite.push(Stretch::walk(gpu, options, name, None, start_s)?);
        }
    }
    for scene in &options.scenes {
        suite.push(Stretch::walk(gpu, options, &file_name(scene), Some(scene), 0.0)?);
    }
    suite.extend(
        captures.into_iter().map(|(folder, reader)| Stretch::capture(&folder, reader, options.split)),
    );
    number_equal_names(&mut suite);
    Ok(suite)
}

/// Names stand for stretches, in the report too.
fn number_equal_names(suite: &mut [Stretch]) {
    let names: Vec<String> = suite.iter().map(|stretch| stretch.name.clone()).collect();
    for (i, stretch) in suite.iter_mut().enumerate() {
        let before = names[..i].iter().filter(|name| **name == stretch.name).count();
        if before > 0 {
            stretch.name = format!("{} ({})", stretch.name, before + 1);
        }
    }
}

fn file_name(path: &Path) -> String {
    path.file_name().map_or_else(|| path.display().to_string(), |name| name.to_string_lossy().into_owned())
}

impl Stretch {
    fn walk(
        gpu: &Gpu,
        options: &ReportOptions,
        name: &str,
        scene: Option<&Path>,
        start_s: f32,
    ) -> Result<Self> {
        let ReportOptions { size: [width, height], frames, fps, .. } = *options;
        let scene_file = scene.map(Path::to_owned);
        let walk = Walk::new(
            gpu,
            WalkOptions {
                scene: scene_file,
                width,
                height,
                frames,
                fps,
                start_s,
                spp: SPP as f32,
                sampling: Sampling::Uniform,
                seed: 0,
                jitter: false,
                split: options.split,
            },
        )?;
        let events = frame_events(&walk, frames);
        let referenced = referenced(options, &events)?;
        let spp = options.references.spp;
        let file = scene.map_or("the built-in gallery".to_owned(), |path| path.display().to_string());
        let source = format!(
            "{file} from {start_s:.2} s, {fps} frames per second, {SPP} sample per pixel; references of {spp} samples \
             per pixel"
        );
        Ok(Self {
            name: name.to_owned(),
            source,
            size: [width, height],
            frames,
            events,
            settings: Settings::default(),
            origin: Origin::Walk { walk: Box::new(walk), referenced, spp },
        })
    }

    fn capture(folder: &Path, reader: CaptureReader, split: Split) -> Self {
        let header = *reader.header();
        let cut = |frame: &u32| reader.info(*frame as usize).restart;
        let frames = reader.len() as u32;
        let events = (1..frames).filter(cut).map(|frame| Event { frame, label: "cut".to_owned() });
        Self {
            name: file_name(folder),
            source: format!("the capture {}", folder.display()),
            size: [header.width, header.height],
            frames,
            events: events.collect(),
            settings: Settings::default().with_far(header.far),
            origin: Origin::Capture { reader, split, images: None },
        }
    }

    /// How much there is to do: frames, and samples of references.
    pub fn steps(&self) -> u64 {
        let references = match &self.origin {
            Origin::Walk { referenced, spp, .. } => referenced.len() as u64 * u64::from(*spp),
            Origin::Capture { .. } => 0,
        };
        u64::from(self.frames) + references
    }

    /// Traces or reads a frame, and waits for it. `progress` hears of samples of its reference.
    pub fn frame(&mut self, gpu: &Gpu, index: u32, progress: impl Fn(u32)) -> Result<Frame<'_>> {
        match &mut self.origin {
            Origin::Walk { walk, referenced, spp } => {
                let mut encoder = gpu.device.create_command_encoder(&Default::default());
                walk.trace(gpu, &mut encoder, index);
                gpu.queue.submit([encoder.finish()]);
                gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
                let reference =
                    referenced.contains(&index).then(|| walk.reference(gpu, index, *spp, progress));
                let (gbuffer, camera) = (walk.gbuffer(), walk.view(index).camera);
                let restart = walk.is_cut(index);
                Ok(Frame { gbuffer, camera, restart, reference: reference.transpose()? })
            }
            Origin::Capture { reader, split, images } => {
                let frame = reader.read(index as usize).with_context(|| format!("frame {index}"))?;
                let info = reader.info(index as usize);
                let gbuffer = images.get_or_insert_with(|| Box::new(gbuffer_for(&gpu.device, &frame)));
                gbuffer.split = *split;
                upload(&gpu.device, &gpu.queue, &frame, gbuffer);
                let reference = frame.reference_image();
                Ok(Frame { gbuffer, camera: info.camera(), restart: info.restart, reference })
            }
        }
    }
}

fn frame_events(walk: &Walk, frames: u32) -> Vec<Event> {
    let at = |frame: u32| {
        if walk.is_cut(frame) {
            return vec![Event { frame, label: "cut".to_owned() }];
        }
        let [(_, before_s), (scene, time_s)] = [frame - 1, frame].map(|frame| walk.scene_at(frame));
        let switches = light_switches(scene, &[before_s, time_s]);
        switches.into_iter().map(|event| Event { frame, ..event }).collect()
    };
    (1..frames).flat_map(at).collect()
}

/// Frames to trace references of: those asked for, or pairs spread over the stretch and those about its events.
fn referenced(options: &ReportOptions, events: &[Event]) -> Result<Vec<u32>> {
    let mut chosen = options.references.chosen(options.frames)?;
    if options.references.frames.is_none() {
        let about = |event: &Event| event.frame - 1..(event.frame + 3).min(options.frames);
        chosen.extend(events.iter().flat_map(about));
        chosen.sort_unstable();
        chosen.dedup();
    }
    Ok(chosen)
}
