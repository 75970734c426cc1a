//! A still view over many frames: how the error of each method falls.

use super::report::{ConvergenceCurve, ConvergenceReport};
use super::stillness::Stillness;
use super::trace;
use crate::gpu::Gpu;
use crate::image::ImageRgb;
use crate::method::{Method, MethodFrame, MethodRunner};
use crate::walk::Walk;
use anyhow::Result;
use quell::Settings;

/// Samples per pixel and frame.
pub const SPP: u32 = 1;
/// The most there is: what bounds the error is the method, not the length of its memory.
const MAX_HISTORY: f32 = 1024.0;
/// Doublings of the number of frames over which the slope is measured.
const SLOPE_DOUBLINGS: usize = 3;

/// A method that sees all frames of the view.
#[derive(Debug)]
pub struct Sequence {
    pub name: &'static str,
    pub label: &'static str,
    settings: Settings,
    runner: MethodRunner,
}

impl Sequence {
    pub fn new(
        gpu: &Gpu,
        walk: &Walk,
        (name, label): (&'static str, &'static str),
        method: Method,
        settings: Settings,
    ) -> Result<Self> {
        let gbuffer = walk.gbuffer();
        let runner = MethodRunner::new(gpu, method, gbuffer.width, gbuffer.height)?;
        Ok(Self { name, label, settings, runner })
    }

    /// Denoises what was traced last, and shows it.
    pub fn shown(&mut self, gpu: &Gpu, walk: &Walk, index: u32) -> Result<Vec<[f32; 3]>> {
        let frame = MethodFrame::new(walk.gbuffer(), walk.view(index).camera, index == 0, &self.settings);
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        self.runner.encode(gpu, &mut encoder, &frame)?;
        gpu.queue.submit([encoder.finish()]);
        Ok(ImageRgb::read_back(gpu, self.runner.output().texture())?.to_display())
    }
}

/// Denoises `frames` frames (at least one) of a walk in which time stands still. `halves` are references with independent
/// noise; `progress` hears of samples as they are done.
pub fn measure(
    gpu: &Gpu,
    walk: &Walk,
    frames: u32,
    halves: [&ImageRgb; 2],
    progress: impl Fn(u32),
) -> Result<ConvergenceReport> {
    let settings = Settings::default().with_max_history(MAX_HISTORY);
    let alone = settings.with_mix_temporal_mean(false);
    let sequence = |name, method, settings| Sequence::new(gpu, walk, name, method, settings);
    let mut sequences = [
        sequence(("quell", "quell"), Method::Quell, settings)?,
        sequence(("models_alone", "quell, models alone"), Method::Quell, alone)?,
        sequence(("accumulate", "plain accumulation"), Method::Accumulate, settings)?,
    ];
    let mut stillness = Stillness::new(gpu, walk, frames)?;
    let halves = halves.map(ImageRgb::to_display);
    let measured = measured_frames(frames);
    let mut mse = [const { Vec::new() }; 3];
    for index in 0..frames {
        trace(gpu, walk, index, SPP)?;
        for (sequence, mse) in sequences.iter_mut().zip(&mut mse) {
            let shown = sequence.shown(gpu, walk, index)?;
            if measured.contains(&(index + 1)) {
                mse.push(squared_error(&shown, &halves));
            }
        }
        stillness.add_frame(gpu, walk, index)?;
        progress(SPP);
    }
    let curve = |(sequence, mse): (&Sequence, Vec<f64>)| ConvergenceCurve {
        name: sequence.name,
        label: sequence.label,
        slope: slope(&measured, &mse),
        mse,
    };
    Ok(ConvergenceReport {
        max_history: MAX_HISTORY,
        methods: sequences.iter().zip(mse).map(curve).collect(),
        frames: measured,
        stillness: stillness.report(),
    })
}

/// The powers of two up to `frames`, and `frames` itself.
fn measured_frames(frames: u32) -> Vec<u32> {
    let powers = (0..32).map(|exponent| 1 << exponent).take_while(|&power| power < frames);
    powers.chain([frames]).collect()
}

/// Mean over pixels and channels of (I - A) (I - B): the squared error without the noise of A and B, below 0 by chance where
/// there is next to none.
///
/// Values as shown are a curve of linear ones, so the halves' noise shifts A and B by its square: with some hundred samples it is
/// far below what is measured, with ten it is not.
fn squared_error(image: &[[f32; 3]], [a, b]: &[Vec<[f32; 3]>; 2]) -> f64 {
    let products = image.iter().zip(a.iter().zip(b)).flat_map(|(image, (a, b))| {
        [0, 1, 2].map(|c| f64::from(image[c] - a[c]) * f64::from(image[c] - b[c]))
    });
    products.sum::<f64>() / (3 * image.len()) as f64
}

/// Of log error over log frames, between the last and three doublings before, or the first. None where either error has no
/// logarithm.
fn slope(frames: &[u32], mse: &[f64]) -> Option<f64> {
    let last = frames.len().checked_sub(1)?;
    let first = last.saturating_sub(SLOPE_DOUBLINGS);
    let log = |value: f64| value.ln();
    let slope = log(mse[last] / mse[first]) / log(f64::from(frames[last]) / f64::from(frames[first]));
    slope.is_finite().then_some(slope)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_double_and_end_with_the_last() {
        assert_eq!(measured_frames(1), [1]);
        assert_eq!(measured_frames(16), [1, 2, 4, 8, 16]);
        assert_eq!(measured_frames(20), [1, 2, 4, 8, 16, 20]);
    }

    #[test]
    fn errors_are_free_of_the_references_noise_and_no_others() {
        // The truth is 0.5; the halves deviate independently by 0.2.
        let half = |flip: u32| -> Vec<[f32; 3]> {
            (0..4_u32).map(|i| [if (i >> flip) & 1 == 0 { 0.3 } else { 0.7 }; 3]).collect()
        };
        let halves = [half(0), half(1)];
        assert!(squared_error(&[[0.5; 3]; 4], &halves).abs() < 1e-6);
        assert!((squared_error(&[[0.6; 3]; 4], &halves) - 0.01).abs() < 1e-6);
        assert!((squared_error(&[[0.5, 0.5, 0.8]; 4], &halves) - 0.03).abs() < 1e-6);
    }

    #[test]
    fn slopes_are_those_of_powers() {
        let frames = [1, 2, 4, 8, 16, 20];
        let mse = frames.map(|n| f64::from(n).powf(-0.7));
        assert!((slope(&frames, &mse).unwrap() + 0.7).abs() < 1e-12);
        // What happened before the last three doublings does not count.
        let late = [9.0, 9.0, 1.0, 1.0, 1.0, 1.0];
        assert_eq!(slope(&frames, &late), Some(0.0));
        assert_eq!(slope(&[1], &[0.5]), None);
        assert_eq!(slope(&[1, 2], &[0.5, -0.1]), None);
    }
}
