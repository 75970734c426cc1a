//! One stretch through all methods.

use super::clock::Clock;
use super::error_map::{ErrorMaps, crops, lasting_errors};
use super::events::telling_frames;
use super::numbers::{MethodNumbers, MethodReport, ShownFrame, StretchReport, is_denoiser};
use super::stretch::{Frame, Stretch};
use crate::gpu::Gpu;
use crate::image::ImageRgb;
use crate::method::{Method, MethodFrame, MethodRunner};
use crate::quality::{QualityRecorder, median};
use anyhow::{Context, Result, ensure};
use indicatif::ProgressBar;

/// What came of a stretch.
pub struct Measured {
    pub report: StretchReport,
    /// One per [`StretchReport::shown`].
    pub pictures: Vec<Pictures>,
    pub clock: &'static str,
}

/// The images of a frame as shown, tightly packed 8-bit RGB.
pub struct Pictures {
    /// Per method, as in the report.
    pub methods: Vec<Vec<u8>>,
    pub reference: Vec<u8>,
    pub errors: ErrorMaps,
}

/// Images of one frame, before it is known which frames are shown.
struct Kept {
    frame: u32,
    methods: Vec<Vec<u8>>,
    reference: Vec<u8>,
}

/// Denoises all frames by all methods, and measures those that have a reference.
pub fn measure(
    gpu: &Gpu,
    stretch: &mut Stretch,
    methods: &[Method],
    progress: &ProgressBar,
) -> Result<Measured> {
    let [width, height] = stretch.size;
    let runner = |&method: &Method| MethodRunner::new(gpu, method, width, height);
    let mut runners = methods.iter().map(runner).collect::<Result<Vec<_>>>()?;
    let mut clock = Clock::new(gpu, runners.iter().map(|runner| runner.passes().len()).max().unwrap_or(1));
    let mut times = vec![Vec::new(); runners.len()];
    let mut quality: Vec<_> = runners.iter().map(|_| QualityRecorder::new()).collect();
    let mut kept = Vec::new();
    let settings = stretch.settings;
    for i in 0..stretch.frames {
        let Frame { gbuffer, camera, restart, reference } =
            stretch.frame(gpu, i, |samples| progress.inc(samples.into()))?;
        let frame = MethodFrame::new(gbuffer, camera, restart, &settings);
        let mut images = Vec::new();
        for (runner, times) in runners.iter_mut().zip(&mut times) {
            times.push(clock.run(gpu, runner, &frame).with_context(|| format!("frame {i}"))?);
            images.push(ImageRgb::read_back(gpu, runner.output().texture())?);
        }
        let mut reflective = Vec::new();
        if let Some(reference) = &reference {
            reflective = gbuffer.reflective(gpu, settings.far)?;
            kept.push(Kept {
                frame: i,
                methods: images.iter().map(ImageRgb::to_display_rgb8).collect(),
                reference: reference.to_display_rgb8(),
            });
        }
        for ((quality, image), method) in quality.iter_mut().zip(images).zip(methods) {
            quality
                .add(i as usize, image, reference.clone(), &reflective)
                .with_context(|| format!("metrics of frame {i}, {}", method.name()))?;
        }
        progress.inc(1);
    }
    ensure!(
        !kept.is_empty(),
        "no frame has a reference (expected `reference.R .G .B` in some), so nothing can be measured"
    );

    let adapter = gpu.description();
    let mut reports = Vec::new();
    for ((runner, quality), times) in runners.iter().zip(quality).zip(times) {
        let name = runner.method().name();
        let report = quality.finish(&stretch.source, name, &adapter, stretch.size);
        let bytes: u64 = runner.memory().iter().map(|allocation| allocation.bytes).sum();
        // Both are there, since there is a frame with a reference.
        let (Some(report), Some(ms)) = (report, median(times)) else { continue };
        let memory_mb = bytes as f64 * 1e-6;
        let numbers = MethodNumbers { method: name, quality: report.mean, ms, memory_mb };
        reports.push(MethodReport { numbers, frames: report.frames });
    }
    let measured: Vec<u32> = kept.iter().map(|kept| kept.frame).collect();
    let telling = telling_frames(&measured, &stretch.events, hardest(&measured, &reports));
    let (shown, pictures) = pictures(kept, &telling, stretch.size, methods);
    let report = StretchReport {
        name: stretch.name.clone(),
        source: stretch.source.clone(),
        width,
        height,
        frames: stretch.frames,
        events: stretch.events.clone(),
        shown,
        methods: reports,
    };
    Ok(Measured { report, pictures, clock: clock.description() })
}

/// The measured frame of the lowest PSNR, in the denoisers' mean.
fn hardest(measured: &[u32], reports: &[MethodReport]) -> Option<u32> {
    let psnr_sum = |i: usize| -> f64 {
        let denoisers = reports.iter().filter(|report| is_denoiser(report.numbers.method));
        denoisers.filter_map(|report| report.frames.get(i)).map(|frame| frame.metrics.psnr_db).sum()
    };
    let sums = measured.iter().enumerate().map(|(i, &frame)| (frame, psnr_sum(i)));
    sums.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(frame, _)| frame)
}

/// The `telling` frames with their error maps.
fn pictures(
    kept: Vec<Kept>,
    telling: &[(u32, String)],
    size: [u32; 2],
    methods: &[Method],
) -> (Vec<ShownFrame>, Vec<Pictures>) {
    let denoisers: Vec<bool> = methods.iter().map(|method| is_denoiser(method.name())).collect();
    let shown = kept.into_iter().filter_map(|kept| {
        let (frame, label) = telling.iter().find(|(frame, _)| *frame == kept.frame)?.clone();
        let Kept { methods, reference, .. } = kept;
        let errors = ErrorMaps::new(&methods, &reference, size, &denoisers);
        let crops = crops(&lasting_errors(&methods, &reference, size[0], &denoisers), size);
        Some((ShownFrame { frame, label, crops }, Pictures { methods, reference, errors }))
    });
    shown.unzip()
}
