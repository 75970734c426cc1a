//! Recording a walk as a capture.

use crate::capture::{CaptureHeader, CaptureWriter, FrameInfo, download};
use crate::gpu::Gpu;
use crate::render::progress_bar;
use crate::tracer::Sampling;
use crate::walk::{References, Walk, WalkOptions};
use anyhow::{Result, ensure};
use std::path::PathBuf;

/// What to record and where to.
#[derive(Debug, Clone)]
pub struct RecordOptions {
    pub walk: WalkOptions,
    pub references: References,
    /// Folder for the capture, created where needed.
    pub out: PathBuf,
    /// Replace a capture that is there already.
    pub overwrite: bool,
}

/// Misses are infinitely far in the path tracer; a capture wants a number.
const FAR: f32 = 1e9;

/// Traces a walk and writes every frame's inputs, and references where asked for.
pub fn record(gpu: &Gpu, options: &RecordOptions) -> Result<()> {
    ensure!(
        options.walk.sampling != Sampling::Adaptive,
        "adaptive sampling: nothing is denoised while a walk is recorded, so nothing says where the samples go"
    );
    let WalkOptions { width, height, frames, fps, .. } = options.walk;
    let chosen = options.references.chosen(frames)?;
    let walk = Walk::new(gpu, options.walk.clone())?;
    let header = CaptureHeader { width, height, far: FAR, frame_time_s: 1.0 / fps };
    let mut writer = CaptureWriter::create(&options.out, header, options.overwrite)?;
    let reference_steps = chosen.len() as u64 * u64::from(options.references.spp);
    let progress = progress_bar(u64::from(frames) + reference_steps, "recording");
    for i in 0..frames {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        walk.trace(gpu, &mut encoder, i);
        gpu.queue.submit([encoder.finish()]);
        let mut frame = download(gpu, walk.gbuffer())?;
        if chosen.contains(&i) {
            let image = walk.reference(gpu, i, options.references.spp, |n| progress.inc(n.into()))?;
            frame.reference = Some(image.pixels);
        }
        let camera = walk.view(i).camera;
        let info = FrameInfo {
            view: camera.view_from_world,
            projection: camera.clip_from_view,
            jitter_px: camera.jitter_px,
            restart: walk.is_cut(i),
        };
        writer.write_frame(&frame, &info)?;
        progress.inc(1);
    }
    writer.finish()?;
    progress.finish_and_clear();
    Ok(())
}
