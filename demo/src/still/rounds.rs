//! The rounds of an image.

use crate::gpu::Gpu;
use crate::image::{ImageRgb, luminance};
use crate::method::{Method, MethodFrame, MethodRunner, output_image};
use crate::metrics::compare;
use crate::render::progress_bar;
use crate::tracer::Sampling;
use crate::walk::Walk;
use anyhow::Result;
use quell::{DebugView, Settings};
use serde::Serialize;
use std::time::Instant;

/// Samples of every pixel in the first round, which the errors of the second are expected by.
const FIRST_SPP: f32 = 4.0;
/// A round spends so much of what was spent before it: enough to matter, little enough to learn from.
const ROUND_SHARE: f32 = 0.25;
/// As the denoiser's sample map takes them.
const ROUND_SPP: [f32; 2] = [1.0 / 16.0, 64.0];

/// When to stop.
#[derive(Debug, Clone, Copy)]
pub struct Budget {
    pub spp: f32,
    pub time_s: Option<f32>,
    pub target_error: Option<f64>,
}

/// Why it ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stop {
    SamplesSpent,
    TimeSpent,
    ErrorReached,
}

impl Stop {
    pub fn text(self) -> &'static str {
        match self {
            Self::SamplesSpent => "all samples were spent",
            Self::TimeSpent => "the time was spent",
            Self::ErrorReached => "the expected error was low enough",
        }
    }
}

/// What is known after a round.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Round {
    /// Samples per pixel so far, the sky included.
    pub spp: f64,
    /// Relative mean squared error that the denoiser expects.
    pub expected_mse: f64,
    /// The true one, where there is a reference.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub relative_mse: Option<f64>,
}

/// A finished image.
#[derive(Debug)]
pub struct Finished {
    pub image: ImageRgb,
    /// Of each pixel.
    pub samples: Vec<u32>,
    pub expected_error: ImageRgb,
    pub rounds: Vec<Round>,
    pub stop: Stop,
    pub seconds: f64,
}

/// Renders a still view.
#[derive(Debug)]
pub struct Rounds<'a> {
    gpu: &'a Gpu,
    walk: &'a Walk,
    reference: Option<&'a ImageRgb>,
    debug: wgpu::TextureView,
}

impl<'a> Rounds<'a> {
    pub fn new(gpu: &'a Gpu, walk: &'a Walk, reference: Option<&'a ImageRgb>) -> Self {
        let (width, height) = (walk.gbuffer().width, walk.gbuffer().height);
        Self { gpu, walk, reference, debug: output_image(&gpu.device, width, height) }
    }

    /// Renders until the budget is spent, anew.
    pub fn render(&mut self, sampling: Sampling, budget: &Budget) -> Result<Finished> {
        let start = Instant::now();
        let (width, height) = (self.walk.gbuffer().width, self.walk.gbuffer().height);
        let mut runner = MethodRunner::new(self.gpu, Method::Quell, width, height)?;
        let mut samples = vec![0; width as usize * height as usize];
        let mut rounds = Vec::new();
        let mut spent = 0.0;
        let mut next = FIRST_SPP.min(budget.spp);
        let progress = progress_bar((budget.spp * 100.0) as u64, "samples");
        for index in 0.. {
            // Every pixel alike at first, or nothing would be known of some.
            let sampling = if index == 0 { Sampling::Uniform } else { sampling };
            spent += next;
            let following = (ROUND_SHARE * spent).min(budget.spp - spent).clamp(ROUND_SPP[0], ROUND_SPP[1]);
            let (image, expected_error) = self.round(&mut runner, index, (next, sampling), following)?;
            let counts = self.gpu.read_texture(self.walk.gbuffer().sample_count.texture())?;
            let counts: Vec<u32> = bytemuck::pod_collect_to_vec(&counts);
            samples.iter_mut().zip(counts).for_each(|(sum, count)| *sum += count);
            let round = Round {
                spp: samples.iter().map(|&count| f64::from(count)).sum::<f64>() / samples.len() as f64,
                expected_mse: expected_relative_mse(&image, &expected_error),
                relative_mse: match self.reference {
                    Some(reference) => Some(compare(&image, reference)?.relative_mse),
                    None => None,
                },
            };
            rounds.push(round);
            progress.set_position((spent * 100.0) as u64);
            let seconds = start.elapsed().as_secs_f64();
            let stop = if budget.target_error.is_some_and(|target| round.expected_mse <= target) {
                Some(Stop::ErrorReached)
            } else if spent + ROUND_SPP[0] > budget.spp {
                Some(Stop::SamplesSpent)
            } else if budget.time_s.is_some_and(|time| seconds >= f64::from(time)) {
                Some(Stop::TimeSpent)
            } else {
                None
            };
            if let Some(stop) = stop {
                progress.finish_and_clear();
                return Ok(Finished { image, samples, expected_error, rounds, stop, seconds });
            }
            next = following;
        }
        unreachable!("rounds end when all samples are spent")
    }

    /// Traces a round, denoises all so far and asks for what the following round needs. Returns the image and how far it is
    /// expected to be off.
    fn round(
        &self,
        runner: &mut MethodRunner,
        index: u32,
        (spp, sampling): (f32, Sampling),
        following: f32,
    ) -> Result<(ImageRgb, ImageRgb)> {
        // As long a memory as there is; the light is known not to change, and nothing is to be cut.
        let settings = Settings::default()
            .with_max_history(1024.0)
            .with_innovation(false)
            .with_firefly_limit(f32::INFINITY);
        let mut encoder = self.gpu.device.create_command_encoder(&Default::default());
        self.walk.trace_with(self.gpu, &mut encoder, index, spp, sampling);
        let frame = MethodFrame {
            sample_budget: Some(following),
            debug: Some((DebugView::OutputError, &self.debug)),
            ..MethodFrame::new(self.walk.gbuffer(), self.walk.view(index).camera, index == 0, &settings)
        };
        runner.encode(self.gpu, &mut encoder, &frame)?;
        self.gpu.queue.submit([encoder.finish()]);
        let image = ImageRgb::read_back(self.gpu, runner.output().texture())?;
        Ok((image, ImageRgb::read_back(self.gpu, self.debug.texture())?))
    }
}

/// As the relative MSE of images, of luminance.
fn expected_relative_mse(image: &ImageRgb, expected_error: &ImageRgb) -> f64 {
    let pixels = image.pixels.iter().zip(&expected_error.pixels);
    let sum: f64 = pixels
        .map(|(&pixel, [deviation, ..])| f64::from(*deviation).powi(2) / (luminance(pixel).powi(2) + 0.01))
        .sum();
    sum / image.pixels.len() as f64
}
