//! One image, in rounds: four samples in every pixel, then more where the denoiser expects them to help most, until the samples
//! or the time are spent, or the error is expected to be low enough.
//!
//! After Moon et al., "Adaptive Rendering with Linear Predictions", SIGGRAPH 2015, section 4.4. Each round is a frame of a
//! still view to the denoiser, whose history is as long as it can be.

mod args;
mod curve;
mod rounds;

pub use args::StillArgs;
pub use curve::{Curve, equal_error_ratio};
pub use rounds::{Round, Stop};

use crate::gbuffer::Split;
use crate::gpu::Gpu;
use crate::image::write_png_rgb8;
use crate::quality::write_json;
use crate::render::progress_bar;
use crate::tracer::Sampling;
use crate::walk::{Walk, WalkOptions};
use anyhow::{Context, Result, ensure};
use rounds::{Budget, Finished, Rounds};
use serde::Serialize;
use std::path::PathBuf;

/// What to render and how long.
#[derive(Debug, Clone)]
pub struct StillOptions {
    /// A glTF file; the built-in gallery without.
    pub scene: Option<PathBuf>,
    pub width: u32,
    pub height: u32,
    /// Scene time, seconds.
    pub start_s: f32,
    /// Samples per pixel to spend, in the mean.
    pub spp: f32,
    /// Seconds after which no further round begins.
    pub time_s: Option<f32>,
    /// Expected relative mean squared error at which no further round begins.
    pub target_error: Option<f64>,
    pub sampling: Sampling,
    /// Samples per pixel of a reference to measure against; 0 for none.
    pub reference_spp: u32,
    pub seed: u32,
    /// What quell gets apart.
    pub split: Split,
    /// Folder for the results, created where needed.
    pub out: PathBuf,
}

/// What `still.json` holds.
#[derive(Debug, Serialize)]
pub struct StillReport {
    pub scene: String,
    pub adapter: String,
    pub size: [u32; 2],
    pub reference_spp: u32,
    pub sampling: Sampling,
    /// Why it ended.
    pub stop: Stop,
    pub seconds: f64,
    pub rounds: Vec<Round>,
    /// The same with uniform samples; with a reference only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uniform: Option<Vec<Round>>,
    /// How many times the samples uniform sampling takes to the same error; with a reference, and where it gets there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub equal_error_ratio: Option<f64>,
}

/// Renders the image. Leaves `still.png`, `still.exr`, `samples.png` (white where most), `expected_error.png` and `still.json` in
/// `out`; with a reference `reference.png`, `uniform.png` and `error.svg` as well.
pub fn still(gpu: &Gpu, options: &StillOptions) -> Result<StillReport> {
    let StillOptions { width, height, start_s, spp, seed, reference_spp, sampling, .. } = *options;
    ensure!(spp >= 1.0, "{spp} samples per pixel: an image needs at least 1");
    // Frames of a still: no time passes between them.
    let walk = Walk::new(
        gpu,
        WalkOptions {
            scene: options.scene.clone(),
            width,
            height,
            frames: 1,
            fps: f32::INFINITY,
            start_s,
            spp,
            sampling,
            seed,
            jitter: false,
            split: options.split,
        },
    )?;
    std::fs::create_dir_all(&options.out)
        .with_context(|| format!("{}: cannot create the folder", options.out.display()))?;
    let reference = match reference_spp {
        0 => None,
        spp => {
            let progress = progress_bar(spp.into(), "reference");
            let image = walk.reference(gpu, 0, spp, |n| progress.inc(n.into()))?;
            progress.finish_and_clear();
            image.write_png(&options.out.join("reference.png"))?;
            Some(image)
        }
    };

    let budget = Budget { spp, time_s: options.time_s, target_error: options.target_error };
    let mut rounds = Rounds::new(gpu, &walk, reference.as_ref());
    let Finished { image, samples, expected_error, rounds: own, stop, seconds } =
        rounds.render(sampling, &budget)?;
    image.write_png(&options.out.join("still.png"))?;
    image.write_exr(&options.out.join("still.exr"))?;
    write_png_rgb8(&options.out.join("samples.png"), width, height, &shades(&samples))?;
    expected_error.write_png(&options.out.join("expected_error.png"))?;

    let mut uniform = None;
    if reference.is_some() && sampling != Sampling::Uniform {
        // As many samples as it takes to see where it gets as far, but not for ever.
        let budget = Budget { spp: 4.0 * spp, time_s: None, target_error: None };
        let finished = rounds.render(Sampling::Uniform, &budget)?;
        finished.image.write_png(&options.out.join("uniform.png"))?;
        uniform = Some(finished.rounds);
    }
    let curves = [Some((sampling.name(), &own)), uniform.as_ref().map(|uniform| ("uniform", uniform))];
    let curves: Vec<Curve> =
        curves.into_iter().flatten().filter_map(|(name, rounds)| Curve::of(name, rounds)).collect();
    if !curves.is_empty() {
        let path = options.out.join("error.svg");
        std::fs::write(&path, curve::plot(&curves))
            .with_context(|| format!("{}: cannot write", path.display()))?;
    }
    let report = StillReport {
        scene: walk.scene_name().to_owned(),
        adapter: gpu.description(),
        size: [width, height],
        reference_spp,
        sampling,
        stop,
        seconds,
        equal_error_ratio: match curves.as_slice() {
            [own, uniform] => equal_error_ratio(own, uniform),
            _ => None,
        },
        rounds: own,
        uniform,
    };
    write_json(&report, &options.out.join("still.json"))?;
    Ok(report)
}

/// Counts as shades of grey, white where most.
pub(crate) fn shades(counts: &[u32]) -> Vec<u8> {
    let most = counts.iter().copied().max().unwrap_or(0).max(1);
    counts.iter().flat_map(|&count| [(255 * count / most) as u8; 3]).collect()
}

impl StillReport {
    /// What was done, for a terminal.
    pub fn summary(&self) -> String {
        use std::fmt::Write;
        let [width, height] = self.size;
        let mut out = format!("{}, {width}x{height}, on {}\n", self.scene, self.adapter);
        let rounds = |out: &mut String, name: &str, rounds: &[Round]| {
            let _ = writeln!(out, "{name:<10} {:>8} {:>14} {:>14}", "spp", "expected rMSE", "true rMSE");
            for round in rounds {
                let truth = round.relative_mse.map_or("-".to_owned(), |error| format!("{error:.6}"));
                let _ =
                    writeln!(out, "{:<10} {:>8.2} {:>14.6} {truth:>14}", "", round.spp, round.expected_mse);
            }
        };
        rounds(&mut out, self.sampling.name(), &self.rounds);
        if let Some(uniform) = &self.uniform {
            rounds(&mut out, "uniform", uniform);
        }
        if let Some(ratio) = self.equal_error_ratio {
            let _ = writeln!(out, "uniform sampling takes {ratio:.2} times the samples to the same error");
        }
        let _ = writeln!(out, "{} after {:.1} s", self.stop.text(), self.seconds);
        out
    }
}
