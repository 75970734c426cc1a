//! What of the output still moves in a still view: temporal variance, of pixels and of low frequencies.

use super::convergence::Sequence;
use super::report::{StillnessReport, TemporalVariance};
use crate::gpu::Gpu;
use crate::method::Method;
use crate::walk::Walk;
use anyhow::Result;
use quell::Settings;

/// Side of the box blur: larger than a model's smallest window, so that what is left is what the eye sees as boiling.
const BLUR_PX: usize = 16;
/// Fewer frames have no variance worth the name.
const FEWEST_FRAMES: u32 = 4;

/// Methods with the default history, and how their values have varied.
#[derive(Debug)]
pub struct Stillness {
    /// With innovation, without it, and plain accumulation.
    sequences: Vec<(Sequence, [Variation; 2])>,
    width: usize,
    frames: u32,
}

impl Stillness {
    /// Variances are taken over the second half of `frames`: the first is that of growing histories.
    pub fn new(gpu: &Gpu, walk: &Walk, frames: u32) -> Result<Self> {
        let settings = Settings::default();
        let sequence = |name, method, innovation| -> Result<_> {
            let sequence = Sequence::new(gpu, walk, name, method, settings.with_innovation(innovation))?;
            Ok((sequence, [Variation::default(), Variation::default()]))
        };
        let sequences = match frames {
            0..FEWEST_FRAMES => Vec::new(),
            _ => vec![
                sequence(("innovation", "quell"), Method::Quell, true)?,
                sequence(("no_innovation", "quell without innovation"), Method::Quell, false)?,
                sequence(("accumulate", "plain accumulation"), Method::Accumulate, true)?,
            ],
        };
        Ok(Self { sequences, width: walk.gbuffer().width as usize, frames })
    }

    /// Denoises what was traced last.
    pub fn add_frame(&mut self, gpu: &Gpu, walk: &Walk, index: u32) -> Result<()> {
        for (sequence, [pixels, blurred]) in &mut self.sequences {
            let shown = sequence.shown(gpu, walk, index)?;
            if index >= self.frames / 2 {
                pixels.add(&shown);
                blurred.add(&box_means(&shown, self.width, BLUR_PX));
            }
        }
        Ok(())
    }

    /// None of too few frames.
    pub fn report(&self) -> Option<StillnessReport> {
        let variance = |(sequence, [pixels, blurred]): &(Sequence, [Variation; 2])| TemporalVariance {
            name: sequence.name,
            label: sequence.label,
            variance: pixels.mean_variance(),
            blurred: blurred.mean_variance(),
        };
        let methods: Vec<_> = self.sequences.iter().map(variance).collect();
        let [with, without, ..] = methods.as_slice() else {
            return None;
        };
        let ratio = |with: f64, without: f64| Some(with / without).filter(|ratio| ratio.is_finite());
        Some(StillnessReport {
            max_history: Settings::default().max_history,
            first_frame: self.frames / 2 + 1,
            last_frame: self.frames,
            blur_px: BLUR_PX as u32,
            innovation_ratio: ratio(with.variance, without.variance),
            innovation_blurred_ratio: ratio(with.blurred, without.blurred),
            methods,
        })
    }
}

/// Running means and squared deviations of many values (Welford 1962).
#[derive(Debug, Default)]
struct Variation {
    count: f64,
    /// Mean, and sum of squared deviations from it.
    values: Vec<[f64; 2]>,
}

impl Variation {
    fn add(&mut self, pixels: &[[f32; 3]]) {
        self.values.resize(3 * pixels.len(), [0.0; 2]);
        self.count += 1.0;
        for ([mean, squares], &value) in self.values.iter_mut().zip(pixels.as_flattened()) {
            let deviation = f64::from(value) - *mean;
            *mean += deviation / self.count;
            *squares += deviation * (f64::from(value) - *mean);
        }
    }

    fn mean_variance(&self) -> f64 {
        let squares: f64 = self.values.iter().map(|[_, squares]| squares).sum();
        squares / (self.count - 1.0) / self.values.len() as f64
    }
}

/// Means over all squares of `side` pixels that lie in the image; of an image smaller than that, over all it has.
fn box_means(pixels: &[[f32; 3]], width: usize, side: usize) -> Vec<[f32; 3]> {
    let height = pixels.len() / width;
    let (w, h) = (side.min(width), side.min(height));
    // Summed-area table, one wider and higher than the image.
    let stride = width + 1;
    let mut sums = vec![[0.0_f64; 3]; stride * (height + 1)];
    for (i, pixel) in pixels.iter().enumerate() {
        let at = (i / width + 1) * stride + i % width + 1;
        sums[at] = std::array::from_fn(|c| {
            f64::from(pixel[c]) + sums[at - 1][c] + sums[at - stride][c] - sums[at - stride - 1][c]
        });
    }
    let places = (0..=height - h).flat_map(|y| (0..=width - w).map(move |x| y * stride + x));
    let mean = |at: usize| {
        let (right, below) = (at + w, at + h * stride);
        let sum = |c: usize| sums[below + w][c] - sums[below][c] - sums[right][c] + sums[at][c];
        std::array::from_fn(|c| (sum(c) / (w * h) as f64) as f32)
    };
    places.map(mean).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn variance_is_that_over_time_not_over_pixels() {
        let mut variation = Variation::default();
        for value in [1.0, 2.0, 6.0] {
            variation.add(&[[value, 5.0, 0.0], [100.0, 7.0, value]]);
        }
        // Deviations -2, -1, 3 in two of six values.
        assert!((variation.mean_variance() - 7.0 * 2.0 / 6.0).abs() < 1e-12);
    }

    #[test]
    fn boxes_are_means_of_their_pixels() {
        let pixels: Vec<[f32; 3]> = (0..35u16).map(|i| [f32::from(i), f32::from(i * i % 7), -1.0]).collect();
        let means = box_means(&pixels, 7, 3);
        assert_eq!(means.len(), 5 * 3);
        let (x, y) = (4, 2);
        let direct = |c: usize| {
            let places = (y..y + 3).flat_map(|y| (x..x + 3).map(move |x| y * 7 + x));
            places.map(|i| pixels[i][c]).sum::<f32>() / 9.0
        };
        let found = means[y * 5 + x];
        assert!([0, 1, 2].iter().all(|&c| (found[c] - direct(c)).abs() < 1e-5), "{found:?}");
        let all = box_means(&pixels, 7, 16);
        assert!(all.len() == 1 && (all[0][0] - 17.0).abs() < 1e-5);
    }

    #[test]
    fn a_blur_removes_noise_and_keeps_boiling() {
        let ratio = |frame: fn(u32, u32) -> f32| {
            let (mut pixels, mut blurred) = (Variation::default(), Variation::default());
            for time in 0..4 {
                let shown: Vec<[f32; 3]> = (0..32 * 32).map(|i| [frame(time, i); 3]).collect();
                pixels.add(&shown);
                blurred.add(&box_means(&shown, 32, 16));
            }
            blurred.mean_variance() / pixels.mean_variance()
        };
        assert!(ratio(|time, pixel| ((pixel + pixel / 32 + time) % 2) as f32) < 1e-9);
        assert!((ratio(|time, _| (time % 2) as f32) - 1.0).abs() < 1e-9);
    }
}
