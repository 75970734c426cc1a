//! Replaying a capture through a method.

use crate::capture::{CaptureReader, MANIFEST, gbuffer_for, upload};
use crate::gbuffer::Split;
use crate::gpu::Gpu;
use crate::image::ImageRgb;
use crate::method::{Method, MethodFrame, MethodRunner};
use crate::quality::{QualityRecorder, QualityReport};
use crate::settings_args::SettingsArgs;
use anyhow::{Context, Result, ensure};
use std::path::{Path, PathBuf};

/// What to replay, how, and where to.
#[derive(Debug, Clone)]
pub struct ReplayOptions {
    /// Folder of the capture.
    pub capture: PathBuf,
    /// Folder for `frame_<number>.exr` and `.png`, created where needed, and `metrics.json`.
    pub out: PathBuf,
    pub method: Method,
    pub settings: SettingsArgs,
    /// What quell gets apart, of what the capture has.
    pub split: Split,
}

/// Denoises every frame of a capture and writes the results. Returns the metrics where the capture has references.
pub fn replay(options: &ReplayOptions) -> Result<Option<QualityReport>> {
    // Everything that can be wrong with the arguments comes before the GPU is touched.
    let capture = CaptureReader::open(&options.capture)?;
    prepare_folder(&options.out)?;
    let metrics_path = options.out.join("metrics.json");

    let gpu = Gpu::new()?;
    let header = *capture.header();
    let settings = options.settings.settings(header.far);
    let mut runner = MethodRunner::new(&gpu, options.method, header.width, header.height)?;
    let mut gbuffer = None;
    let mut quality = QualityRecorder::new();
    let progress = indicatif::ProgressBar::new(capture.len() as u64);
    for i in 0..capture.len() {
        let frame = capture.read(i)?;
        let info = capture.info(i);
        let gbuffer = gbuffer.get_or_insert_with(|| gbuffer_for(&gpu.device, &frame));
        upload(&gpu.device, &gpu.queue, &frame, gbuffer);

        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let inputs = MethodFrame {
            split: options.split,
            ..MethodFrame::new(gbuffer, info.camera(), info.restart, &settings)
        };
        let output = runner.encode(&gpu, &mut encoder, &inputs).with_context(|| format!("frame {i}"))?;
        gpu.queue.submit([encoder.finish()]);

        let image = ImageRgb::read_back(&gpu, output.texture())?;
        image.write_exr(&options.out.join(format!("frame_{i:04}.exr")))?;
        image.write_png(&options.out.join(format!("frame_{i:04}.png")))?;
        quality.add_models(runner.models());
        let reference = frame.reference_image();
        let reflective = match reference {
            Some(_) => gbuffer.reflective(&gpu, header.far)?,
            None => vec![],
        };
        quality.add(i, image, reference, &reflective).with_context(|| format!("metrics of frame {i}"))?;
        progress.inc(1);
    }
    progress.finish_and_clear();
    let source = options.capture.display().to_string();
    let size = [header.width, header.height];
    let report = quality.finish(&source, options.method.name(), &gpu.description(), size);
    if let Some(report) = &report {
        report.write_json(&metrics_path)?;
    }
    Ok(report)
}

/// Creates the folder for results, and removes the metrics of an earlier run: these would belong to other images.
fn prepare_folder(out: &Path) -> Result<()> {
    ensure!(
        !out.join(MANIFEST).exists(),
        "{}: holds a capture, whose frames would be overwritten; choose another folder",
        out.display()
    );
    std::fs::create_dir_all(out).with_context(|| format!("{}: cannot create the folder", out.display()))?;
    let metrics = out.join("metrics.json");
    match std::fs::remove_file(&metrics) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(error).with_context(|| format!("{}: cannot remove", metrics.display()))
        }
        _ => Ok(()),
    }
}
