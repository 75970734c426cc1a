//! The ways to place models and to choose their windows that the study compares.

use super::denoise::StillDenoiser;
use super::report::VariantReport;
use crate::image::{ImageRgb, display_from_linear};
use crate::metrics::compare;
use crate::quality::median;
use anyhow::Result;
use quell::{Centres, DebugView, Settings, Windows};

/// Encodes before the first that is timed, and those that are.
const WARM_UP: usize = 1;
const TIMED: usize = 5;

/// How to denoise.
#[derive(Debug, Clone, Copy)]
struct Variant {
    name: &'static str,
    centres: Centres,
    windows: Windows,
}

/// A variant's numbers and pictures.
#[derive(Debug)]
pub struct Measured {
    pub report: VariantReport,
    pub image: ImageRgb,
    /// The image in grey, tinted by window size, with a dark dot per centre in its own window's colour; 8-bit RGB.
    pub centres: Vec<u8>,
}

impl Variant {
    fn new(name: &'static str, centres: Centres, windows: Windows) -> Self {
        Self { name, centres, windows }
    }

    fn settings(self) -> Settings {
        Settings::default().with_centres(self.centres).with_windows(self.windows)
    }

    fn centres_label(self) -> String {
        match self.centres {
            Centres::Uniform(1) => "dense: every 8 px".to_owned(),
            Centres::Uniform(stride) => format!("uniform: every {} px", 8 * stride),
            _ => "adaptive".to_owned(),
        }
    }

    fn windows_label(self) -> &'static str {
        match self.windows {
            Windows::RingError => "by ring error",
            Windows::MallowsCp => "by Mallows' Cp",
            Windows::Fixed(1) => "fixed, five tiles",
            Windows::Fixed(2) => "fixed, 3x3 tiles",
            _ => "fixed, 5x5 tiles",
        }
    }
}

/// Dense, uniform and adaptive centres with the default windows, then adaptive ones with windows chosen otherwise. Uniform centres
/// have the stride whose number of models is the nearest to the adaptive ones'.
fn variants(denoiser: &mut StillDenoiser<'_>) -> Result<Vec<Variant>> {
    let windows = Windows::default();
    let adaptive = Variant::new("adaptive", Centres::Adaptive, windows);
    let mut models = |variant: Variant| -> Result<f64> {
        Ok(f64::from(denoiser.denoised(&variant.settings())?.1).max(1.0).ln())
    };
    let aim = models(adaptive)?;
    let [fine, coarse] = [2, 4].map(|stride| Variant::new("uniform", Centres::Uniform(stride), windows));
    let is_fine_nearer = (models(fine)? - aim).abs() <= (models(coarse)? - aim).abs();
    Ok(vec![
        Variant::new("dense", Centres::Uniform(1), windows),
        if is_fine_nearer { fine } else { coarse },
        adaptive,
        Variant::new("adaptive_ring", Centres::Adaptive, Windows::RingError),
        Variant::new("adaptive_12px", Centres::Adaptive, Windows::Fixed(1)),
        Variant::new("adaptive_20px", Centres::Adaptive, Windows::Fixed(2)),
        Variant::new("adaptive_28px", Centres::Adaptive, Windows::Fixed(3)),
    ])
}

/// Measures all variants on the image that was traced last.
pub fn measure(denoiser: &mut StillDenoiser<'_>, reference: &ImageRgb) -> Result<Vec<Measured>> {
    let variants = variants(denoiser)?;
    let mut measured = Vec::new();
    for (variant, wall_ms) in variants.iter().zip(wall_times(denoiser, &variants)?) {
        let settings = variant.settings();
        let (image, models) = denoiser.denoised(&settings)?;
        let (alone, _) = denoiser.denoised(&settings.with_mix_temporal_mean(false))?;
        let windows = denoiser.debug_view(&settings, DebugView::Windows)?;
        let pixels = f64::from(reference.width) * f64::from(reference.height);
        let report = VariantReport {
            name: variant.name,
            centres: variant.centres_label(),
            windows: variant.windows_label(),
            models,
            pixels_per_model: pixels / f64::from(models.max(1)),
            output: compare(&image, reference)?,
            models_alone: compare(&alone, reference)?,
            wall_ms,
        };
        measured.push(Measured { report, centres: draw_centres(&image, &windows), image });
    }
    Ok(measured)
}

/// Median milliseconds of each variant. They take turns, so that what else the machine does meets all alike.
fn wall_times(denoiser: &mut StillDenoiser<'_>, variants: &[Variant]) -> Result<Vec<f64>> {
    let mut samples = vec![Vec::new(); variants.len()];
    for round in 0..WARM_UP + TIMED {
        for (variant, samples) in variants.iter().zip(&mut samples) {
            let ms = denoiser.run(&variant.settings(), None)?;
            if round >= WARM_UP {
                samples.push(ms);
            }
        }
    }
    Ok(samples.into_iter().filter_map(median).collect())
}

/// Share of a colour that is left where the tint has none of it, and the least light, so that dark dots show everywhere.
const PALE: f32 = 0.35;
const LEAST_LIGHT: f32 = 0.45;
/// What the view of windows shows the full colours of places as; those of dots are brighter.
const FULL_TINT: f32 = 0.4;
/// Share of a dot's colour that is left: dark among what is pale, and still a colour.
const DOT: f32 = 0.55;

/// The image in grey, tinted by the view of windows, whose bright dots, one per centre, become dark.
fn draw_centres(image: &ImageRgb, windows: &ImageRgb) -> Vec<u8> {
    let shade = |(image, windows): (&[f32; 3], &[f32; 3])| {
        let brightest = windows.iter().copied().fold(0.0, f32::max);
        let light = LEAST_LIGHT + (1.0 - LEAST_LIGHT) * display_from_linear(image[1]);
        let tint = |value: f32| PALE + (1.0 - PALE) * (value / FULL_TINT).min(1.0);
        let shown = |value: f32| match brightest {
            0.0 => light, // the sky
            _ if brightest > 0.5 * (1.0 + FULL_TINT) => DOT * value,
            _ => light * tint(value),
        };
        windows.map(|value| (255.0 * shown(value)).round() as u8)
    };
    image.pixels.iter().zip(&windows.pixels).flat_map(shade).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn centres_are_dark_and_have_their_windows_colour() {
        let image = ImageRgb::from_fn(3, 1, |_, _| [1e9; 3]);
        let windows =
            ImageRgb::from_fn(3, 1, |x, _| [[1.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.0; 3]][x as usize]);
        assert_eq!(draw_centres(&image, &windows), [140, 0, 0, 255, 89, 89, 255, 255, 255]);
    }
}
