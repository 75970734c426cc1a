//! What the study found: the content of `study.json`, and all numbers of the page.

use crate::metrics::FrameMetrics;
use serde::Serialize;
use std::fmt::Write;

/// What `study.json` holds. Infinite and missing values are `null`.
#[derive(Debug, Clone, Serialize)]
pub struct StudyReport {
    pub scene: String,
    pub adapter: String,
    /// Times on a CPU say nothing about a GPU.
    pub is_cpu: bool,
    pub width: u32,
    pub height: u32,
    pub start_s: f32,
    pub spp: u32,
    pub seed: u32,
    pub reference_spp: u32,
    /// Relative MSE that the reference's own noise adds to every method's, estimated from its two halves.
    pub reference_relative_mse: f64,
    pub zoom: Rect,
    /// The input, invalid values repaired.
    pub noisy: FrameMetrics,
    pub variants: Vec<VariantReport>,
    /// Independent images whose errors were measured.
    pub runs: u32,
    pub windows: Vec<WindowReport>,
    pub choice: Option<ChoiceReport>,
    pub pixels: Vec<PixelReport>,
    /// None where no frames were asked for.
    pub convergence: Option<ConvergenceReport>,
}

impl StudyReport {
    /// What was measured, for a terminal.
    pub fn summary(&self) -> String {
        let mut out = format!(
            "{:<21} {:<15} {:>7} {:>8} {:>9} {:>7}\n",
            "centres", "windows", "models", "rMSE", "PSNR", "ms"
        );
        for v in &self.variants {
            let FrameMetrics { relative_mse, psnr_db, .. } = v.output;
            let _ = writeln!(
                out,
                "{:<21} {:<15} {:>7} {relative_mse:>8.5} {psnr_db:>6.2} dB {:>7.1}",
                v.centres, v.windows, v.models, v.wall_ms
            );
        }
        let number = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.3}"));
        for w in &self.windows {
            let Correlation { pearson_log, spearman, .. } = w.expected;
            let _ = writeln!(
                out,
                "estimated against true error, windows of {} pixels: Pearson on logs {}, Spearman {}",
                w.pixels,
                number(pearson_log),
                number(spearman)
            );
        }
        if let Some(convergence) = &self.convergence {
            convergence.summarise(&mut out);
        }
        out
    }
}

/// A part of the image, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Rect {
    pub x: u32,
    pub y: u32,
    pub width: u32,
    pub height: u32,
}

/// One way to place models and to choose their windows.
#[derive(Debug, Clone, Serialize)]
pub struct VariantReport {
    /// As in file names.
    pub name: &'static str,
    pub centres: String,
    pub windows: &'static str,
    pub models: u32,
    pub pixels_per_model: f64,
    /// Of the denoiser's output.
    pub output: FrameMetrics,
    /// Of the models' prediction, not mixed with the temporal mean.
    pub models_alone: FrameMetrics,
    /// Median, from submission until the GPU is done.
    pub wall_ms: f64,
}

/// Estimated against true error of one window size, over the tiles of the image.
#[derive(Debug, Clone, Serialize)]
pub struct WindowReport {
    /// As in `Windows::Fixed`.
    pub window: u32,
    /// That it holds.
    pub pixels: u32,
    pub tiles: usize,
    /// With the true error averaged over all runs.
    pub expected: Correlation,
    /// With the true error of the same run: one sample of the expected one.
    pub own: Correlation,
    /// Median over tiles of estimated over expected error.
    pub median_ratio: Option<f64>,
}

#[derive(Debug, Clone, Copy, Serialize)]
pub struct Correlation {
    /// Of the logarithms, where both errors are above 0.
    pub pearson_log: Option<f64>,
    /// Of all tiles.
    pub spearman: Option<f64>,
    /// Tiles that have no logarithm.
    pub without_log: usize,
}

/// What choosing windows by the estimate is worth, over all tiles and runs.
#[derive(Debug, Clone, Serialize)]
pub struct ChoiceReport {
    /// Mean relative error with the same window everywhere, per size.
    pub fixed: Vec<f64>,
    /// With the window of the least estimated error.
    pub estimated: f64,
    /// With the window of the least expected error, which nobody knows.
    pub best: f64,
    /// Share of tiles where both are the same window.
    pub agreement: f64,
    /// Share of tiles where each size has the least expected error.
    pub best_shares: Vec<f64>,
}

/// Errors at one pixel (its tile), per window size.
#[derive(Debug, Clone, Serialize)]
pub struct PixelReport {
    pub label: String,
    pub x: u32,
    pub y: u32,
    /// Mean over the runs.
    pub true_error: Vec<f64>,
    /// Of each run.
    pub estimated_error: Vec<Vec<f64>>,
}

/// A still view over many frames of one sample per pixel.
#[derive(Debug, Clone, Serialize)]
pub struct ConvergenceReport {
    /// Of all methods.
    pub max_history: f32,
    /// How many frames had been denoised when errors were measured.
    pub frames: Vec<u32>,
    pub methods: Vec<ConvergenceCurve>,
    /// None where too few frames were traced to tell.
    pub stillness: Option<StillnessReport>,
}

#[derive(Debug, Clone, Serialize)]
pub struct ConvergenceCurve {
    pub name: &'static str,
    pub label: &'static str,
    /// Mean squared error of values as shown, per entry of `frames`, without the reference's noise.
    pub mse: Vec<f64>,
    /// Of the logarithms, over the last three doublings of the frames; -1 is what averaging does.
    pub slope: Option<f64>,
}

/// How much of the output still moves while nothing in the view does.
#[derive(Debug, Clone, Serialize)]
pub struct StillnessReport {
    pub max_history: f32,
    /// The frames over which variances are taken, counted from 1.
    pub first_frame: u32,
    pub last_frame: u32,
    /// Side of the box blur that leaves low frequencies alone.
    pub blur_px: u32,
    pub methods: Vec<TemporalVariance>,
    /// Variance with innovation over that without; 1 where innovation adds nothing.
    pub innovation_ratio: Option<f64>,
    /// The same after the blur.
    pub innovation_blurred_ratio: Option<f64>,
}

/// Variance over time of values as shown, mean over pixels and channels.
#[derive(Debug, Clone, Serialize)]
pub struct TemporalVariance {
    pub name: &'static str,
    pub label: &'static str,
    pub variance: f64,
    /// After the box blur.
    pub blurred: f64,
}

impl ConvergenceReport {
    fn summarise(&self, out: &mut String) {
        let (Some(first), Some(last)) = (self.frames.first(), self.frames.last()) else {
            return;
        };
        for ConvergenceCurve { label, mse, slope, .. } in &self.methods {
            let [Some(start), Some(end)] = [mse.first(), mse.last()] else { continue };
            let slope = slope.map_or("-".to_owned(), |slope| format!("{slope:.2}"));
            let _ = writeln!(
                out,
                "still view, {label}: MSE {start:.2e} at frame {first}, {end:.2e} at {last}, slope {slope}"
            );
        }
        if let Some(StillnessReport {
            blur_px,
            innovation_ratio: Some(ratio),
            innovation_blurred_ratio: Some(blurred),
            ..
        }) = self.stillness
        {
            let _ = writeln!(
                out,
                "still view, temporal variance with innovation over without: {ratio:.3}; blurred by {blur_px} px: {blurred:.3}"
            );
        }
    }
}
