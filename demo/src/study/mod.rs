//! The figure of Moon et al., "Adaptive Rendering with Linear Predictions", SIGGRAPH 2015: one still image, denoised with
//! models at dense, uniform and adaptive centres, and the estimated error against the true one. Then the same view over many
//! frames: how the error falls.

mod convergence;
mod denoise;
mod errors;
mod page;
mod plot;
mod report;
mod spots;
mod stillness;
mod surfaces;
mod variants;

pub use report::{Rect, StudyReport};

use crate::gbuffer::Split;
use crate::gpu::Gpu;
use crate::image::{ImageRgb, write_png_rgb8};
use crate::metrics::compare;
use crate::quality::write_json;
use crate::render::progress_bar;
use crate::tracer::Sampling;
use crate::walk::{Walk, WalkOptions};
use anyhow::{Context, Result, ensure};
use denoise::StillDenoiser;
use errors::Truth;
use spots::Spot;
use std::path::{Path, PathBuf};
use surfaces::{Surfaces, Tiles};
use variants::Measured;

/// What to study.
#[derive(Debug, Clone)]
pub struct StudyOptions {
    /// A glTF file; the built-in gallery without.
    pub scene: Option<PathBuf>,
    pub width: u32,
    pub height: u32,
    /// Scene time, seconds.
    pub start_s: f32,
    /// Samples per pixel of the image to denoise.
    pub spp: u32,
    /// Samples per pixel of the reference, 2 and up.
    pub reference_spp: u32,
    pub seed: u32,
    /// Independent images over which true errors are averaged, 1 and up.
    pub runs: u32,
    /// Frames of 1 sample per pixel over which convergence is measured; 0 for no such section.
    pub frames: u32,
    /// What is enlarged; the quarter with the most detail without.
    pub zoom: Option<Rect>,
    /// Whose errors are plotted; an edge, a shadow, a texture and a flat wall without any.
    pub pixels: Vec<[u32; 2]>,
    /// Folder for the results, created where needed.
    pub out: PathBuf,
}

impl StudyOptions {
    fn check(&self) -> Result<()> {
        let (width, height) = (self.width, self.height);
        let image = format!("the image has {width}x{height} pixels, numbered from 0");
        for [x, y] in &self.pixels {
            ensure!(*x < width && *y < height, "pixel {x},{y} is outside: {image}");
        }
        if let Some(Rect { x, y, width: w, height: h }) = self.zoom {
            let fits =
                |at: u32, side: u32, end: u32| side > 0 && at.checked_add(side).is_some_and(|to| to <= end);
            ensure!(fits(x, w, width) && fits(y, h, height), "zoom {x},{y},{w},{h} does not fit: {image}");
        }
        ensure!(self.reference_spp >= 2, "reference of {}: two samples are the least", self.reference_spp);
        ensure!(self.runs >= 1, "runs: at least 1");
        Ok(())
    }
}

/// Makes the study. Leaves `study.html`, `study.json` and the page's PNGs in `out`.
pub fn study(gpu: &Gpu, options: &StudyOptions) -> Result<StudyReport> {
    options.check()?;
    let StudyOptions { width, height, spp, seed, runs, frames, reference_spp, start_s, .. } = *options;
    // Frames of a still: no time passes between them, so they differ by noise alone.
    let walk = Walk::new(
        gpu,
        WalkOptions {
            scene: options.scene.clone(),
            width,
            height,
            frames: runs.max(frames),
            fps: f32::INFINITY,
            start_s,
            spp: spp as f32,
            sampling: Sampling::Uniform,
            seed,
            jitter: false,
            // Its errors are those of one signal.
            split: Split::None,
        },
    )?;
    trace(gpu, &walk, 0, spp)?;
    let surfaces = Surfaces::read_back(gpu, walk.gbuffer())?;
    for &[x, y] in &options.pixels {
        let is_hit = surfaces.hit[surfaces.index([x, y])];
        ensure!(is_hit, "pixel {x},{y} sees the sky, where nothing is predicted");
    }
    std::fs::create_dir_all(&options.out)
        .with_context(|| format!("{}: cannot create the folder", options.out.display()))?;

    let samples = [reference_spp, runs * spp, frames * convergence::SPP];
    let progress = progress_bar(samples.into_iter().map(u64::from).sum(), "studying");
    let noisy = ImageRgb::read_back(gpu, walk.gbuffer().radiance.texture())?;
    let [first, second] = [reference_spp / 2, reference_spp - reference_spp / 2];
    let halves = [(0, first), (1, second)];
    let [a, b] = halves.map(|(frame, spp)| walk.reference(gpu, frame, spp, |n| progress.inc(n.into())));
    let (a, b) = (a?, b?);
    let share = first as f32 / reference_spp as f32;
    let reference = combine(&a, &b, |a, b| share * a + (1.0 - share) * b);

    let mut denoiser = StillDenoiser::new(gpu, walk.gbuffer(), walk.view(0).camera)?;
    let measured = variants::measure(&mut denoiser, &reference)?;
    let (tiles, truth) = (Tiles::new(&surfaces), Truth::new(&surfaces, [&a, &b]));
    let mut found = Vec::new();
    for run in 0..runs {
        trace(gpu, &walk, run, spp)?;
        found.push(errors::measure_run(&mut denoiser, &tiles, &truth)?);
        progress.inc(spp.into());
    }
    let convergence = match frames {
        0 => None,
        _ => Some(convergence::measure(gpu, &walk, frames, [&a, &b], |n| progress.inc(n.into()))?),
    };
    progress.finish_and_clear();

    let spots = match options.pixels.as_slice() {
        [] => spots::choose(&surfaces, &tiles, &truth),
        pixels => pixels.iter().map(|&pixel| Spot { label: "pixel", pixel }).collect(),
    };
    let report = StudyReport {
        scene: walk.scene_name().to_owned(),
        adapter: gpu.description(),
        is_cpu: gpu.adapter.get_info().device_type == wgpu::DeviceType::Cpu,
        width,
        height,
        start_s,
        spp,
        seed,
        reference_spp,
        reference_relative_mse: noise_of_reference(&reference, &a, &b)?,
        zoom: options.zoom.unwrap_or_else(|| spots::detailed_part([&a, &b])),
        noisy: compare(&repaired(&noisy), &reference)?,
        variants: measured.iter().map(|measured| measured.report.clone()).collect(),
        runs,
        windows: errors::windows(&found),
        choice: errors::choice(&found, &tiles, &truth),
        pixels: errors::pixels(&found, &tiles, &spots),
        convergence,
    };
    write_pictures(&options.out, report.zoom, &noisy, &reference, &measured)?;
    write_json(&report, &options.out.join("study.json"))?;
    let pairs: Vec<_> = (0..errors::WINDOWS.len()).map(|size| errors::pairs(&found, size)).collect();
    page::write(&report, &pairs, &options.out)?;
    Ok(report)
}

/// Traces frame `index` with `spp` samples per pixel and waits for it.
fn trace(gpu: &Gpu, walk: &Walk, index: u32, spp: u32) -> Result<()> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    walk.trace_with(gpu, &mut encoder, index, spp as f32, Sampling::Uniform);
    gpu.queue.submit([encoder.finish()]);
    gpu.device.poll(wgpu::PollType::wait_indefinitely())?;
    Ok(())
}

fn combine(a: &ImageRgb, b: &ImageRgb, value: impl Fn(f32, f32) -> f32) -> ImageRgb {
    let pixel = |(a, b): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|c| value(a[c], b[c]));
    ImageRgb { pixels: a.pixels.iter().zip(&b.pixels).map(pixel).collect(), ..*a }
}

/// As the denoiser repairs its input: what is not finite or negative is 0.
fn repaired(image: &ImageRgb) -> ImageRgb {
    let repair = |value: f32| if value.is_finite() { value.max(0.0) } else { 0.0 };
    ImageRgb { pixels: image.pixels.iter().map(|pixel| pixel.map(repair)).collect(), ..*image }
}

/// What the noise of a reference adds to relative errors: half the difference of its halves deviates as the whole does.
fn noise_of_reference(reference: &ImageRgb, a: &ImageRgb, b: &ImageRgb) -> Result<f64> {
    let deviation = combine(a, b, |a, b| 0.5 * (a - b));
    Ok(compare(&combine(reference, &deviation, |r, d| r + d), reference)?.relative_mse)
}

/// Pixels that an enlarged part is wide, or nearly.
const ZOOMED_WIDTH: u32 = 480;

/// Writes all pictures of the page.
fn write_pictures(
    out: &Path,
    zoom: Rect,
    noisy: &ImageRgb,
    reference: &ImageRgb,
    measured: &[Measured],
) -> Result<()> {
    let ends = [("noisy", noisy), ("reference", reference)];
    let variants = measured.iter().map(|measured| (measured.report.name, &measured.image));
    for (name, image) in ends.into_iter().chain(variants) {
        image.write_png(&out.join(format!("{name}.png")))?;
        enlarged(image, zoom).write_png(&out.join(format!("{name}_zoom.png")))?;
    }
    for Measured { report, image, centres } in measured {
        let path = out.join(format!("{}_centres.png", report.name));
        write_png_rgb8(&path, image.width, image.height, centres)?;
    }
    Ok(())
}

/// A part of an image, each pixel a square of pixels.
fn enlarged(image: &ImageRgb, part: Rect) -> ImageRgb {
    let times = (ZOOMED_WIDTH / part.width).max(1);
    ImageRgb::from_fn(part.width * times, part.height * times, |x, y| {
        let (x, y) = (part.x + x / times, part.y + y / times);
        image.pixels[y as usize * image.width as usize + x as usize]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enlarging_repeats_pixels() {
        let image = ImageRgb::from_fn(4, 3, |x, y| [x as f32, y as f32, 0.0]);
        let zoomed = enlarged(&image, Rect { x: 1, y: 1, width: 2, height: 1 });
        assert_eq!((zoomed.width, zoomed.height), (480, 240));
        assert_eq!(zoomed.pixels[239], [1.0, 1.0, 0.0]);
        assert_eq!(zoomed.pixels[480 * 240 - 1], [2.0, 1.0, 0.0]);
    }

    #[test]
    fn a_references_noise_is_that_of_its_halves_mean() {
        // Halves of 1 and 3: the mean 2 deviates by 1.
        let [a, b, mean] = [1.0, 3.0, 2.0].map(|value| ImageRgb::from_fn(8, 8, |_, _| [value; 3]));
        assert!((noise_of_reference(&mean, &a, &b).unwrap() - 1.0 / 4.01).abs() < 1e-6);
    }
}
