//! Estimated (by Mallows' Cp) and true errors of dense models with windows of each size.

use super::denoise::StillDenoiser;
use super::report::{ChoiceReport, Correlation, PixelReport, WindowReport};
use super::spots::Spot;
use super::surfaces::{Surfaces, Tiles};
use crate::correlation::{pearson, spearman};
use crate::image::{ImageRgb, luminance};
use crate::quality::median;
use anyhow::Result;
use quell::{Centres, DebugView, Settings, Windows};

/// As in `Windows::Fixed`.
pub const WINDOWS: [u32; 3] = [1, 2, 3];
/// Pixels in each: five tiles of 8x8, 3x3, 5x5.
const PIXELS: [u32; WINDOWS.len()] = [5 * 64, 9 * 64, 25 * 64];
/// Keeps relative errors of dark tiles finite; as in the relative MSE of images.
const RELATIVE_FLOOR: f64 = 0.01;

/// Squared errors of luminance, demodulated; each a mean over a tile.
#[derive(Debug, Clone)]
pub struct TileErrors {
    pub estimated: Vec<f64>,
    /// Unbiased by the reference's noise, and so below 0 by chance where there is next to no error.
    pub truth: Vec<f64>,
}

/// What all runs found: per run and window size.
pub type Runs = Vec<[TileErrors; WINDOWS.len()]>;

/// Two references of the same image with independent noise, demodulated luminance.
///
/// `(p - a) (p - b)` estimates the squared error of `p` without the noise of `a` and `b`, which `(p - a)^2` would add: at a
/// few hundred samples it is no smaller than the error of a good prediction.
#[derive(Debug)]
pub struct Truth {
    halves: [Vec<f64>; 2],
}

impl Truth {
    pub fn new(surfaces: &Surfaces, halves: [&ImageRgb; 2]) -> Self {
        Self { halves: halves.map(|half| surfaces.demodulated_luminance(half)) }
    }

    /// One of both at a pixel.
    pub fn half(&self, half: usize, pixel: usize) -> f64 {
        self.halves[half][pixel]
    }

    fn mean(&self, pixel: usize) -> f64 {
        0.5 * (self.halves[0][pixel] + self.halves[1][pixel])
    }

    fn squared_error(&self, pixel: usize, prediction: f64) -> f64 {
        (prediction - self.halves[0][pixel]) * (prediction - self.halves[1][pixel])
    }
}

/// Estimated and true errors of the image that was traced last.
pub fn measure_run(
    denoiser: &mut StillDenoiser<'_>,
    tiles: &Tiles,
    truth: &Truth,
) -> Result<[TileErrors; WINDOWS.len()]> {
    let mut measure = |window: u32| -> Result<TileErrors> {
        let settings =
            Settings::default().with_windows(Windows::Fixed(window)).with_centres(Centres::Uniform(1));
        let root = denoiser.debug_view(&settings, DebugView::PredictedError)?;
        let prediction = denoiser.debug_view(&settings, DebugView::Prediction)?;
        Ok(TileErrors {
            estimated: tiles.means(|i| f64::from(root.pixels[i][0]).powi(2)),
            truth: tiles.means(|i| truth.squared_error(i, luminance(prediction.pixels[i]))),
        })
    };
    Ok([measure(WINDOWS[0])?, measure(WINDOWS[1])?, measure(WINDOWS[2])?])
}

/// Mean over the runs of the true error of window `size`, per tile.
fn expected(runs: &Runs, size: usize) -> Vec<f64> {
    let tiles = runs.first().map_or(0, |run| run[size].truth.len());
    let mean = |tile: usize| runs.iter().map(|run| run[size].truth[tile]).sum::<f64>() / runs.len() as f64;
    (0..tiles).map(mean).collect()
}

/// Pairs of estimated and expected error of window `size` that have logarithms: what is plotted.
pub fn pairs(runs: &Runs, size: usize) -> Vec<[f64; 2]> {
    let Some(first) = runs.first() else {
        return Vec::new();
    };
    positive(&first[size].estimated, &expected(runs, size))
}

fn positive(estimated: &[f64], truth: &[f64]) -> Vec<[f64; 2]> {
    let pairs = estimated.iter().zip(truth).map(|(&estimated, &truth)| [estimated, truth]);
    pairs.filter(|pair| pair.iter().all(|error| *error > 0.0)).collect()
}

fn correlation(estimated: &[f64], truth: &[f64]) -> Correlation {
    let pairs = positive(estimated, truth);
    let logs = |side: usize| -> Vec<f64> { pairs.iter().map(|pair| pair[side].ln()).collect() };
    Correlation {
        pearson_log: pearson(&logs(0), &logs(1)),
        spearman: spearman(estimated, truth),
        without_log: truth.len() - pairs.len(),
    }
}

/// How estimated and true errors go together, per window size. The estimates are those of the first run.
pub fn windows(runs: &Runs) -> Vec<WindowReport> {
    let Some(first) = runs.first() else {
        return Vec::new();
    };
    let report = |(size, errors): (usize, &TileErrors)| {
        let expected = expected(runs, size);
        let ratios = positive(&errors.estimated, &expected);
        WindowReport {
            window: WINDOWS[size],
            pixels: PIXELS[size],
            tiles: expected.len(),
            expected: correlation(&errors.estimated, &expected),
            own: correlation(&errors.estimated, &errors.truth),
            median_ratio: median(ratios.iter().map(|[estimated, truth]| estimated / truth).collect()),
        }
    };
    first.iter().enumerate().map(report).collect()
}

/// What choosing each tile's window by the estimate is worth. None without tiles.
pub fn choice(runs: &Runs, tiles: &Tiles, truth: &Truth) -> Option<ChoiceReport> {
    if runs.is_empty() || tiles.len() == 0 {
        return None;
    }
    let scale: Vec<f64> =
        tiles.means(|i| truth.mean(i).powi(2)).iter().map(|square| 1.0 / (square + RELATIVE_FLOOR)).collect();
    let expected: [Vec<f64>; WINDOWS.len()] = std::array::from_fn(|size| expected(runs, size));
    let best: Vec<usize> = (0..tiles.len()).map(|tile| least(|size| expected[size][tile])).collect();
    let mean_expected = |size: &dyn Fn(usize) -> usize| {
        (0..tiles.len()).map(|tile| scale[tile] * expected[size(tile)][tile]).sum::<f64>()
            / tiles.len() as f64
    };
    let (mut estimated, mut agreed) = (0.0, 0);
    for run in runs {
        for tile in 0..tiles.len() {
            let chosen = least(|size| run[size].estimated[tile]);
            estimated += scale[tile] * run[chosen].truth[tile];
            agreed += usize::from(chosen == best[tile]);
        }
    }
    let choices = (runs.len() * tiles.len()) as f64;
    let share = |size: usize| best.iter().filter(|&&b| b == size).count() as f64 / tiles.len() as f64;
    Some(ChoiceReport {
        fixed: (0..WINDOWS.len()).map(|size| mean_expected(&|_| size)).collect(),
        estimated: estimated / choices,
        best: mean_expected(&|tile| best[tile]),
        agreement: agreed as f64 / choices,
        best_shares: (0..WINDOWS.len()).map(share).collect(),
    })
}

/// The window size with the least error; the smaller of equal ones.
fn least(error: impl Fn(usize) -> f64) -> usize {
    (1..WINDOWS.len()).fold(0, |best, size| if error(size) < error(best) { size } else { best })
}

/// Errors over window size at chosen pixels.
pub fn pixels(runs: &Runs, tiles: &Tiles, spots: &[Spot]) -> Vec<PixelReport> {
    let expected: [Vec<f64>; WINDOWS.len()] = std::array::from_fn(|size| expected(runs, size));
    let report = |spot: &Spot| {
        let tile = tiles.holding(spot.pixel)?;
        Some(PixelReport {
            label: spot.label.to_owned(),
            x: spot.pixel[0],
            y: spot.pixel[1],
            true_error: expected.iter().map(|errors| errors[tile]).collect(),
            estimated_error: runs
                .iter()
                .map(|run| run.iter().map(|errors| errors.estimated[tile]).collect())
                .collect(),
        })
    };
    spots.iter().filter_map(report).collect()
}

#[cfg(test)]
mod tests {
    use super::super::surfaces::tests::wall;
    use super::*;

    fn errors(estimated: &[f64], truth: &[f64]) -> TileErrors {
        TileErrors { estimated: estimated.to_vec(), truth: truth.to_vec() }
    }

    #[test]
    fn the_references_noise_is_no_error_of_the_prediction() {
        let surfaces = wall(4, 1, 4);
        let grey = |noise: f32| ImageRgb::from_fn(4, 1, |x, _| [0.5 + noise * (x as f32 - 1.5); 3]);
        // Deviations of opposite sign: their product is on average what the noise of the mean takes away.
        let truth = Truth::new(&surfaces, [&grey(0.1), &grey(-0.1)]);
        assert!((truth.mean(3) - 0.5).abs() < 1e-6);
        assert!((truth.squared_error(0, 0.7) - (0.2_f64.powi(2) - 0.15_f64.powi(2))).abs() < 1e-6);
    }

    #[test]
    fn choices_are_compared_with_fixed_windows_and_the_best() {
        let surfaces = wall(8, 4, 8);
        let (tiles, white) = (Tiles::new(&surfaces), ImageRgb::from_fn(8, 4, |_, _| [1.0; 3]));
        let truth = Truth::new(&surfaces, [&white, &white]);
        // The first tile is best with the smallest window, the second with the largest; the estimate knows the first.
        let run = [
            errors(&[1.0, 1.0], &[1.01, 3.03]),
            errors(&[2.0, 2.0], &[2.02, 2.02]),
            errors(&[3.0, 3.0], &[3.03, 1.01]),
        ];
        let report = choice(&vec![run], &tiles, &truth).unwrap();
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        assert!(report.fixed.iter().all(|&error| near(error, 2.0)), "{report:?}");
        assert!(near(report.estimated, 2.0) && near(report.best, 1.0), "{report:?}");
        assert!(near(report.agreement, 0.5), "{report:?}");
        assert_eq!(report.best_shares, [0.5, 0.0, 0.5]);
        assert!(choice(&Vec::new(), &tiles, &truth).is_none());
    }

    #[test]
    fn errors_without_logarithm_are_counted() {
        let found = correlation(&[1.0, 10.0, 100.0, 0.0], &[2.0, 20.0, 200.0, -1.0]);
        assert!((found.pearson_log.unwrap() - 1.0).abs() < 1e-12);
        assert!((found.spearman.unwrap() - 1.0).abs() < 1e-12);
        assert_eq!(found.without_log, 1);
        // The same errors at other tiles.
        let wrong = correlation(&[1.0, 10.0, 100.0, 0.0], &[200.0, 2.0, 20.0, 40.0]);
        assert!(wrong.pearson_log.unwrap() < 0.0 && wrong.spearman.unwrap() < 0.0);
    }
}
