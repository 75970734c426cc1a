//! The walk without a window: pictures, a contact sheet, metrics.

use crate::contact_sheet::ContactSheet;
use crate::gbuffer::Split;
use crate::gpu::Gpu;
use crate::image::ImageRgb;
use crate::method::{Method, MethodFrame, MethodRunner};
use crate::peers::{Antialias, PeerFrame};
use crate::quality::{HEADINGS, MeanReport, QualityRecorder, QualityReport, columns, median, write_json};
use crate::tracer::Sampling;
use crate::walk::{References, Walk, WalkOptions};
use anyhow::{Context, Result, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use quell::Settings;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::Instant;

/// What to render and where to.
#[derive(Debug, Clone)]
pub struct RenderOptions {
    pub walk: WalkOptions,
    pub references: References,
    /// Side by side, in this order; none twice.
    pub methods: Vec<Method>,
    /// Whether each method's output goes through temporal antialiasing; needs a walk with jitter.
    pub antialias: bool,
    /// Folder for the results, created where needed.
    pub out: PathBuf,
}

/// What `metrics.json` holds.
#[derive(Debug, Serialize)]
pub struct RenderReport {
    pub scene: String,
    pub spp: f32,
    pub sampling: Sampling,
    pub reference_spp: u32,
    pub seed: u32,
    pub jitter: bool,
    pub antialias: bool,
    /// What quell got apart.
    pub split: Split,
    /// Median milliseconds of the path tracer and of each method, from submission until the GPU is done.
    pub wall_ms: BTreeMap<String, f64>,
    /// Quality of each method on the same samples; empty without references.
    pub methods: Vec<QualityReport>,
}

/// Frames on the contact sheet.
const SHEET_FRAMES: u32 = 6;
/// What is rendered where nothing else is asked for.
pub const METHODS: [Method; 3] = [Method::None, Method::Accumulate, Method::Quell];

/// A progress bar that is silent where standard error is no terminal.
pub fn progress_bar(steps: u64, what: &'static str) -> ProgressBar {
    let style = ProgressStyle::with_template("{msg} {wide_bar} {pos}/{len} {eta}");
    ProgressBar::new(steps)
        .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        .with_message(what)
}

/// Folder for the pictures of a method.
fn folder_of(method: Method) -> &'static str {
    match method {
        Method::None => "noisy",
        Method::Quell => "denoised",
        other => other.name(),
    }
}

/// What a method's pictures are called on the contact sheet.
fn label_of(method: Method) -> &'static str {
    match method {
        Method::Accumulate => "accumulated",
        other => other.name(),
    }
}

/// Renders a walk. Leaves a folder of PNGs per method (`noisy/` without denoising, `denoised/` by quell, the others by
/// their names), `reference/`, `contact_sheet.png` and `metrics.json` in `out`.
pub fn render(gpu: &Gpu, options: &RenderOptions) -> Result<RenderReport> {
    let walk = Walk::new(gpu, options.walk.clone())?;
    let WalkOptions { width, height, frames, spp, sampling, seed, jitter, split, .. } = options.walk;
    let chosen = options.references.chosen(frames)?;
    ensure!(
        sampling != Sampling::Adaptive || options.methods.contains(&Method::Quell),
        "adaptive sampling needs quell among the methods: it says where the samples go"
    );
    ensure!(
        jitter || !options.antialias,
        "antialiasing needs jitter: without, every frame shows the same steps"
    );
    let folder = |name: &str| -> Result<PathBuf> {
        let path = options.out.join(name);
        std::fs::create_dir_all(&path)
            .with_context(|| format!("{}: cannot create the folder", path.display()))?;
        Ok(path)
    };
    let methods = &options.methods;
    let folders = methods.iter().map(|&method| folder(folder_of(method))).collect::<Result<Vec<_>>>()?;

    let settings = Settings::default();
    let mut runners = Vec::new();
    for &method in methods {
        runners.push(MethodRunner::new(gpu, method, width, height)?);
    }
    let antialias = || options.antialias.then(|| Antialias::new(&gpu.device, width, height));
    let mut antialias: Vec<_> = methods.iter().map(|_| antialias()).collect();
    let mut quality: Vec<_> = methods.iter().map(|_| QualityRecorder::new()).collect();
    let mut sheet = ContactSheet::new();
    let mut times = WallTimes::default();
    let reference_steps = chosen.len() as u64 * u64::from(options.references.spp);
    let progress = progress_bar(u64::from(frames) + reference_steps, "rendering");
    for i in 0..frames {
        times.measure(gpu, TRACER, |encoder| {
            walk.trace(gpu, encoder, i);
            Ok(())
        })?;
        let sample_budget = (sampling == Sampling::Adaptive).then_some(spp);
        let frame = MethodFrame {
            sample_budget,
            ..MethodFrame::new(walk.gbuffer(), walk.view(i).camera, walk.is_cut(i), &settings)
        };
        for (runner, antialias) in runners.iter_mut().zip(&mut antialias) {
            times.measure(gpu, runner.method().name(), |encoder| {
                runner.encode(gpu, encoder, &frame).with_context(|| format!("frame {i}"))?;
                Ok(())
            })?;
            if let Some(antialias) = antialias {
                let peer_frame = PeerFrame {
                    camera: frame.camera,
                    restart: frame.restart,
                    far: settings.far,
                    max_history: settings.max_history,
                };
                times.measure(gpu, ANTIALIAS, |encoder| {
                    antialias.encode(gpu, encoder, walk.gbuffer(), runner.output(), &peer_frame);
                    Ok(())
                })?;
            }
        }

        let shown = |(runner, antialias): (&MethodRunner, &Option<Antialias>)| {
            let image = antialias.as_ref().map_or(runner.output(), Antialias::output);
            ImageRgb::read_back(gpu, image.texture())
        };
        let images = runners.iter().zip(&antialias).map(shown).collect::<Result<Vec<_>>>()?;
        let name = format!("frame_{i:04}.png");
        for (image, folder) in images.iter().zip(&folders) {
            image.write_png(&folder.join(&name))?;
        }
        let reference = if chosen.contains(&i) {
            let image = walk.reference(gpu, i, options.references.spp, |n| progress.inc(n.into()))?;
            image.write_png(&folder("reference")?.join(&name))?;
            Some(image)
        } else {
            None
        };
        if on_sheet(i, frames, &chosen) {
            for (column, (image, &method)) in images.iter().zip(methods).enumerate() {
                let label = match method {
                    Method::None => format!("{spp} spp"),
                    method => label_of(method).to_owned(),
                };
                let frame = if column == 0 { format!("frame {i}: ") } else { String::new() };
                sheet.add(frame + &label, image);
            }
            if let Some(reference) = &reference {
                sheet.add(format!("reference, {} spp", options.references.spp), reference);
            }
        }
        let reflective = match reference {
            Some(_) => walk.gbuffer().reflective(gpu, settings.far)?,
            None => vec![],
        };
        for (quality, image) in quality.iter_mut().zip(images) {
            quality
                .add(i as usize, image, reference.clone(), &reflective)
                .with_context(|| format!("metrics of frame {i}"))?;
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    let columns = methods.len() as u32 + u32::from(!chosen.is_empty());
    sheet.write_png(&options.out.join("contact_sheet.png"), columns)?;

    let adapter = gpu.description();
    let finish = |(quality, method): (QualityRecorder, Method)| {
        quality.finish(walk.scene_name(), method.name(), &adapter, [width, height])
    };
    let report = RenderReport {
        scene: walk.scene_name().to_owned(),
        spp,
        sampling,
        reference_spp: options.references.spp,
        seed,
        jitter,
        antialias: options.antialias,
        split,
        wall_ms: times.medians(),
        methods: quality.into_iter().zip(methods.iter().copied()).filter_map(finish).collect(),
    };
    write_json(&report, &options.out.join("metrics.json"))?;
    Ok(report)
}

/// Frames with a reference where there are any, so that rows are complete; some spread over the walk otherwise.
fn on_sheet(i: u32, frames: u32, chosen: &[u32]) -> bool {
    if !chosen.is_empty() {
        let step = chosen.len().div_ceil(SHEET_FRAMES as usize);
        return chosen.iter().rev().step_by(step).any(|&frame| frame == i);
    }
    let shown = SHEET_FRAMES.min(frames);
    (1..=shown).any(|k| frames * k / shown - 1 == i)
}

impl RenderReport {
    /// What was measured, for a terminal.
    pub fn summary(&self) -> String {
        use std::fmt::Write;
        let mut out = String::new();
        if let Some(first) = self.methods.first() {
            let camera = match (self.jitter, self.antialias) {
                (true, true) => ", jittered and antialiased",
                (true, false) => ", jittered",
                _ => "",
            };
            let _ = writeln!(
                out,
                "{}: {}x{}, {} spp {}{}, means of {} frames against {} spp, on {}",
                self.scene,
                first.width,
                first.height,
                self.spp,
                self.sampling.name(),
                camera,
                first.frames.len(),
                self.reference_spp,
                first.adapter
            );
            let _ = write!(out, "{:<12}{HEADINGS}", "method");
        }
        for method in &self.methods {
            let MeanReport { metrics, tpsnr_db } = &method.mean;
            let _ = write!(out, "{:<12}{}", method.method, columns(metrics, *tpsnr_db));
        }
        if let (Some(tracer), Some(quell)) =
            (self.wall_ms.get(TRACER), self.wall_ms.get(Method::Quell.name()))
        {
            let _ = writeln!(
                out,
                "median wall time of a frame: path tracer {tracer:.1} ms, quell {quell:.1} ms ({:.2} of the tracer)",
                quell / tracer
            );
        }
        out
    }
}

const TRACER: &str = "path tracer";
const ANTIALIAS: &str = "antialias";

/// Wall times of submissions, waited for one by one. Not a benchmark: it includes what submitting and waiting costs.
#[derive(Default)]
struct WallTimes {
    samples: BTreeMap<&'static str, Vec<f64>>,
}

impl WallTimes {
    fn measure(
        &mut self,
        gpu: &Gpu,
        what: &'static str,
        record: impl FnOnce(&mut wgpu::CommandEncoder) -> Result<()>,
    ) -> Result<()> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        record(&mut encoder)?;
        let start = Instant::now();
        gpu.queue.submit([encoder.finish()]);
        gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
        self.samples.entry(what).or_default().push(start.elapsed().as_secs_f64() * 1e3);
        Ok(())
    }

    fn medians(self) -> BTreeMap<String, f64> {
        let medians = self.samples.into_iter();
        medians.filter_map(|(what, samples)| Some((what.to_owned(), median(samples)?))).collect()
    }
}
