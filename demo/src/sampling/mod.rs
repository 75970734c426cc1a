//! What it is worth to choose where samples go: the same walk at the same number of samples, placed in different ways.

mod args;

pub use args::SamplingArgs;

use crate::capture::CaptureReader;
use crate::correlation::spearman;
use crate::gbuffer::Split;
use crate::gpu::Gpu;
use crate::image::{ImageRgb, luminance, write_png_rgb8};
use crate::method::{Method, MethodFrame, MethodRunner, output_image};
use crate::quality::{FrameReport, MeanReport, QualityRecorder, write_json};
use crate::render::progress_bar;
use crate::still::shades;
use crate::table::aligned;
use crate::tracer::Sampling;
use crate::walk::{Walk, WalkOptions};
use anyhow::{Context, Result, ensure};
use quell::{DebugView, Settings};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// What to compare.
#[derive(Debug, Clone)]
pub struct SamplingOptions {
    /// A capture of the walk: its size, frames and references.
    pub capture: PathBuf,
    /// The scene that was recorded; the built-in gallery without.
    pub scene: Option<PathBuf>,
    /// Scene time of the first frame, seconds.
    pub start_s: f32,
    /// Samples per pixel, in the mean.
    pub spp: Vec<f32>,
    /// Walks with independent noise over which all figures are averaged, 1 and up.
    pub runs: u32,
    pub seed: u32,
    /// What quell gets apart.
    pub split: Split,
    /// Folder for `sampling.md`, `sampling.json` and pictures, created where needed.
    pub out: PathBuf,
}

/// By what, where and with how many samples a walk is made.
type Way = (Method, Sampling, f32);

/// Frames after the cut with which the walk begins that are told apart.
const CUT_FRAMES: usize = 4;
/// What all denoisers are compared with.
const BASELINE: Way = (Method::Svgf, Sampling::Uniform, 1.0);
/// Pixels on a side of the squares over which expected and true errors are averaged.
const SQUARE: usize = 8;

/// What one way of sampling came to.
#[derive(Debug, Clone, Serialize)]
pub struct SamplingRow {
    pub method: &'static str,
    pub sampling: Sampling,
    pub spp: f32,
    /// Samples per pixel that were traced, where no sky is seen.
    pub traced_spp: f64,
    /// Means over the frames right after the cut.
    pub after_cut: MeanReport,
    /// Means over the later frames.
    pub walk: MeanReport,
    /// Rank correlation of expected with true errors, averaged over frames; quell alone expects any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error_correlation: Option<f64>,
}

/// What `sampling.json` holds.
#[derive(Debug, Serialize)]
pub struct SamplingReport {
    pub scene: String,
    pub adapter: String,
    pub size: [u32; 2],
    pub frames: usize,
    pub runs: u32,
    pub rows: Vec<SamplingRow>,
}

/// Denoises the walk once for each way of sampling, and writes what came of it.
pub fn sampling(gpu: &Gpu, options: &SamplingOptions) -> Result<SamplingReport> {
    let capture = CaptureReader::open(&options.capture)?;
    let header = *capture.header();
    let references = References::read(&capture)?;
    std::fs::create_dir_all(&options.out)
        .with_context(|| format!("{}: cannot create the folder", options.out.display()))?;

    let ways = options.spp.iter().flat_map(|&spp| {
        let checkerboard = (spp == 0.5).then_some(Sampling::Checkerboard);
        let ways = [Some(Sampling::Uniform), checkerboard, Some(Sampling::Adaptive)];
        ways.into_iter().flatten().map(move |sampling| (Method::Quell, sampling, spp))
    });
    let ways: Vec<Way> = std::iter::once(BASELINE).chain(ways).collect();
    let mut tallies = vec![Tally::default(); ways.len()];
    let mut scene = String::new();
    let progress = progress_bar(u64::from(options.runs) * (ways.len() * capture.len()) as u64, "sampling");
    for run in 0..options.runs {
        let walk = Walk::new(
            gpu,
            WalkOptions {
                scene: options.scene.clone(),
                width: header.width,
                height: header.height,
                frames: capture.len() as u32,
                fps: header.frame_time_s.recip(),
                start_s: options.start_s,
                spp: 1.0,
                sampling: Sampling::Uniform,
                seed: options.seed.wrapping_add(run),
                jitter: false,
                split: options.split,
            },
        )?;
        ensure_same_walk(&capture, &walk)?;
        scene = walk.scene_name().to_owned();
        for (&way, tally) in ways.iter().zip(&mut tallies) {
            let mut run = Run::new(gpu, &walk, way, tally)?;
            for i in 0..capture.len() {
                run.frame(i, references.of(i)).with_context(|| format!("frame {i}"))?;
                progress.inc(1);
            }
            run.write_pictures(&options.out)?;
            let frames = run.quality.into_frames();
            tally.frames.extend(frames);
        }
    }
    progress.finish_and_clear();
    let report = SamplingReport {
        scene,
        adapter: gpu.description(),
        size: [header.width, header.height],
        frames: capture.len(),
        runs: options.runs,
        rows: ways.iter().zip(tallies).map(|(&way, tally)| tally.row(way)).collect(),
    };
    write_json(&report, &options.out.join("sampling.json"))?;
    let path = options.out.join("sampling.md");
    std::fs::write(&path, report.table()).with_context(|| format!("{}: cannot write", path.display()))?;
    Ok(report)
}

/// Frames with a reference.
struct References(Vec<(usize, ImageRgb)>);

impl References {
    fn read(capture: &CaptureReader) -> Result<Self> {
        let mut found = Vec::new();
        for i in 0..capture.len() {
            found.extend(capture.read(i)?.reference_image().map(|image| (i, image)));
        }
        let (cut, walk): (Vec<usize>, Vec<usize>) =
            found.iter().map(|&(i, _)| i).partition(|&i| i < CUT_FRAMES);
        ensure!(
            !cut.is_empty() && !walk.is_empty(),
            "the capture has {} references among its first {CUT_FRAMES} frames and {} among the later ones; both need one \
             (see `record --reference-frames`)",
            cut.len(),
            walk.len()
        );
        Ok(Self(found))
    }

    fn of(&self, frame: usize) -> Option<&ImageRgb> {
        self.0.iter().find(|&&(i, _)| i == frame).map(|(_, image)| image)
    }
}

fn ensure_same_walk(capture: &CaptureReader, walk: &Walk) -> Result<()> {
    for i in 0..capture.len() {
        let (recorded, walked) = (capture.info(i).camera(), walk.view(i as u32).camera);
        let is_same = recorded.view_from_world.abs_diff_eq(walked.view_from_world, 1e-3)
            && recorded.clip_from_view.abs_diff_eq(walked.clip_from_view, 1e-3);
        ensure!(
            is_same,
            "frame {i} of the capture was recorded with another camera than that of scene {}: was it another scene, or another \
             --start?",
            walk.scene_name()
        );
    }
    Ok(())
}

/// What all runs of a way came to.
#[derive(Debug, Clone, Default)]
struct Tally {
    /// Samples and pixels that see no sky.
    traced: [f64; 2],
    frames: Vec<FrameReport>,
    correlations: Vec<f64>,
}

/// One walk in one way, frame by frame.
struct Run<'a> {
    gpu: &'a Gpu,
    walk: &'a Walk,
    runner: MethodRunner,
    sampling: Sampling,
    spp: f32,
    debug: wgpu::TextureView,
    tally: &'a mut Tally,
    quality: QualityRecorder,
    last: Option<ImageRgb>,
}

impl<'a> Run<'a> {
    fn new(gpu: &'a Gpu, walk: &'a Walk, (method, sampling, spp): Way, tally: &'a mut Tally) -> Result<Self> {
        let (width, height) = (walk.gbuffer().width, walk.gbuffer().height);
        Ok(Self {
            gpu,
            walk,
            runner: MethodRunner::new(gpu, method, width, height)?,
            sampling,
            spp,
            debug: output_image(&gpu.device, width, height),
            tally,
            quality: QualityRecorder::new(),
            last: None,
        })
    }

    fn frame(&mut self, i: usize, reference: Option<&ImageRgb>) -> Result<()> {
        let Self { gpu, walk, .. } = *self;
        let (settings, index) = (Settings::default(), i as u32);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        walk.trace_with(gpu, &mut encoder, index, self.spp, self.sampling);
        let frame = MethodFrame {
            sample_budget: (self.sampling == Sampling::Adaptive).then_some(self.spp),
            debug: Some((DebugView::OutputError, &self.debug)),
            ..MethodFrame::new(walk.gbuffer(), walk.view(index).camera, walk.is_cut(index), &settings)
        };
        self.runner.encode(gpu, &mut encoder, &frame)?;
        gpu.queue.submit([encoder.finish()]);
        self.count_samples()?;
        let image = ImageRgb::read_back(gpu, self.runner.output().texture())?;
        if let Some(reference) = reference
            && self.runner.method() == Method::Quell
        {
            let expected = ImageRgb::read_back(gpu, self.debug.texture())?;
            self.tally.correlations.extend(error_correlation(&expected, &image, reference));
        }
        self.last = Some(image.clone());
        self.quality.add(i, image, reference.cloned(), &[])?;
        Ok(())
    }

    fn count_samples(&mut self) -> Result<()> {
        let gbuffer = self.walk.gbuffer();
        let samples = self.gpu.read_texture(gbuffer.sample_count.texture())?;
        let depth = self.gpu.read_texture(gbuffer.depth.texture())?;
        let (samples, depth): (Vec<u32>, Vec<f32>) =
            (bytemuck::pod_collect_to_vec(&samples), bytemuck::pod_collect_to_vec(&depth));
        for (&samples, _) in samples.iter().zip(&depth).filter(|(_, depth)| depth.is_finite()) {
            self.tally.traced[0] += f64::from(samples);
            self.tally.traced[1] += 1.0;
        }
        Ok(())
    }

    fn name(&self) -> String {
        format!("{}_{}_{}", self.runner.method().name(), self.sampling.name(), self.spp)
    }

    /// The last frame, and the samples that it asks for.
    fn write_pictures(&self, out: &Path) -> Result<()> {
        let name = self.name();
        if let Some(image) = &self.last {
            image.write_png(&out.join(format!("{name}.png")))?;
        }
        if self.sampling == Sampling::Adaptive {
            let gbuffer = self.walk.gbuffer();
            let samples = self.gpu.read_texture(gbuffer.sample_map.texture())?;
            let samples: Vec<u32> = bytemuck::pod_collect_to_vec(&samples);
            let path = out.join(format!("{name}_map.png"));
            write_png_rgb8(&path, gbuffer.width, gbuffer.height, &shades(&samples))?;
        }
        Ok(())
    }
}

impl Tally {
    fn row(self, (method, sampling, spp): Way) -> SamplingRow {
        let mean = |is_wanted: fn(usize) -> bool| {
            let frames = self.frames.iter().filter(move |report| is_wanted(report.frame));
            MeanReport::of(frames.map(|report| (report.metrics, report.tpsnr_db)))
        };
        let count = self.correlations.len() as f64;
        SamplingRow {
            method: method.name(),
            sampling,
            spp,
            traced_spp: self.traced[0] / self.traced[1].max(1.0),
            after_cut: mean(|i| i < CUT_FRAMES),
            walk: mean(|i| i >= CUT_FRAMES),
            error_correlation: (count > 0.0).then(|| self.correlations.iter().sum::<f64>() / count),
        }
    }
}

/// Spearman's correlation of expected and true squared errors of luminance, as means over squares of pixels.
fn error_correlation(expected: &ImageRgb, image: &ImageRgb, reference: &ImageRgb) -> Option<f64> {
    let [width, height] = [image.width, image.height].map(|side| side as usize);
    let columns = width / SQUARE;
    let mut sums = vec![[0.0; 2]; columns * (height / SQUARE)];
    for (i, ((expected, image), reference)) in
        expected.pixels.iter().zip(&image.pixels).zip(&reference.pixels).enumerate()
    {
        let (x, y) = (i % width / SQUARE, i / width / SQUARE);
        if x < columns && y < height / SQUARE {
            let sum = &mut sums[y * columns + x];
            sum[0] += f64::from(expected[0]).powi(2);
            sum[1] += (luminance(*image) - luminance(*reference)).powi(2);
        }
    }
    // Where nothing is expected there is only sky.
    let sums: Vec<_> = sums.into_iter().filter(|sum| sum[0] > 0.0).collect();
    let side = |side: usize| sums.iter().map(|sum| sum[side]).collect::<Vec<_>>();
    spearman(&side(0), &side(1))
}

impl SamplingReport {
    /// A table for a terminal, which is Markdown.
    pub fn table(&self) -> String {
        let headings = [
            "method",
            "sampling",
            "spp",
            "traced",
            "rMSE",
            "FLIP",
            "PSNR",
            "tPSNR",
            "cut rMSE",
            "cut FLIP",
            "cut PSNR",
            "error corr.",
        ];
        let number =
            |value: Option<f64>, digits: usize| value.map_or("-".to_owned(), |v| format!("{v:.digits$}"));
        let row = |row: &SamplingRow| {
            let (walk, cut) = (&row.walk.metrics, &row.after_cut.metrics);
            vec![
                row.method.to_owned(),
                row.sampling.name().to_owned(),
                row.spp.to_string(),
                number(Some(row.traced_spp), 3),
                number(Some(walk.relative_mse), 4),
                number(Some(walk.flip), 4),
                number(Some(walk.psnr_db), 2),
                number(row.walk.tpsnr_db, 2),
                number(Some(cut.relative_mse), 4),
                number(Some(cut.flip), 4),
                number(Some(cut.psnr_db), 2),
                number(row.error_correlation, 2),
            ]
        };
        let mut rows = vec![headings.map(str::to_owned).to_vec()];
        rows.extend(self.rows.iter().map(row));
        let [width, height] = self.size;
        format!(
            "{}, {width}x{height}, {} walks of {} frames, on {}\n\n{}",
            self.scene,
            self.runs,
            self.frames,
            self.adapter,
            aligned(&rows, 2)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expected_errors_follow_true_ones_or_do_not() {
        let image = ImageRgb::from_fn(64, 64, |x, y| [(x / 8 + y) as f32; 3]);
        let black = ImageRgb::new(64, 64);
        assert!(error_correlation(&image, &image, &black).unwrap() > 0.999);
        let turned = ImageRgb::from_fn(64, 64, |x, y| [(80 - x / 8 - y) as f32; 3]);
        assert!(error_correlation(&turned, &image, &black).unwrap() < -0.999);
    }
}
