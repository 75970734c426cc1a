//! Image quality against a reference.
//!
//! All but the relative error compare images as they are shown: tonemapped by x / (1 + x), sRGB-encoded, 0 to 1.
//! A value that is not finite in either image is an error: a metric must never be a silent NaN.

use crate::image::ImageRgb;
use serde::Serialize;
use thiserror::Error;

/// How close an image is to its reference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FrameMetrics {
    /// Peak signal-to-noise ratio over all pixels and channels, dB; higher is better. Infinite for equal images,
    /// which JSON stores as `null`.
    pub psnr_db: f64,
    /// PSNR over reflective surfaces alone ([`GBuffer::reflective`](crate::gbuffer::GBuffer::reflective)). Missing where it is not
    /// known which these are, or none is in view.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reflective_psnr_db: Option<f64>,
    /// Structural similarity, -1 to 1; 1 is equal.
    pub ssim: f64,
    /// Mean LDR FLIP, 0 to 1; 0 is equal.
    pub flip: f64,
    /// mean((I - R)^2 / (R^2 + 0.01)) on linear values; 0 is equal.
    pub relative_mse: f64,
    /// (sum I / sum R - 1) in percent, on linear values: energy lost (below 0) or won.
    pub bias_percent: f64,
}

/// Why images cannot be compared.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum MetricError {
    /// The images differ in size, or one is empty.
    #[error("cannot compare a {}x{} image with a {}x{} reference", image[0], image[1], reference[0], reference[1])]
    Size { image: [u32; 2], reference: [u32; 2] },
    /// A value is NaN or infinite.
    #[error("the {which} has {value} at pixel ({x}, {y}), channel {}", ["R", "G", "B"][*channel])]
    NotFinite { which: &'static str, x: u32, y: u32, channel: usize, value: f32 },
}

/// All single-frame metrics of `image`, but for that of reflective surfaces.
pub fn compare(image: &ImageRgb, reference: &ImageRgb) -> Result<FrameMetrics, MetricError> {
    compare_reflective(image, reference, &[])
}

/// All single-frame metrics of `image`; `reflective` says of each pixel whether its surface is, and is empty where that is not
/// known.
pub fn compare_reflective(
    image: &ImageRgb,
    reference: &ImageRgb,
    reflective: &[bool],
) -> Result<FrameMetrics, MetricError> {
    check(image, reference)?;
    let (shown, target) = (image.to_display(), reference.to_display());
    let chosen = |pixels: &[[f32; 3]]| -> Vec<[f32; 3]> {
        pixels.iter().zip(reflective).filter(|&(_, &chosen)| chosen).map(|(&pixel, _)| pixel).collect()
    };
    let (shown_there, target_there) = (chosen(&shown), chosen(&target));
    Ok(FrameMetrics {
        psnr_db: psnr_from_mse(mse(&shown, &target)),
        reflective_psnr_db: (!shown_there.is_empty())
            .then(|| psnr_from_mse(mse(&shown_there, &target_there))),
        ssim: ssim(&shown, &target, image.width as usize, image.height as usize),
        flip: flip(image, reference),
        relative_mse: relative_mse(image, reference),
        bias_percent: bias_percent(image, reference),
    })
}

/// Temporal PSNR in dB: of the change from the previous frame, against the change of the reference. As shown.
pub fn temporal_psnr(
    previous: &ImageRgb,
    image: &ImageRgb,
    previous_reference: &ImageRgb,
    reference: &ImageRgb,
) -> Result<f64, MetricError> {
    check(previous, previous_reference)?;
    check(image, reference)?;
    check(image, previous)?;
    let change = |from: &ImageRgb, to: &ImageRgb| -> Vec<[f32; 3]> {
        let (from, to) = (from.to_display(), to.to_display());
        to.iter().zip(&from).map(|(to, from)| [0, 1, 2].map(|c| to[c] - from[c])).collect()
    };
    Ok(psnr_from_mse(mse(&change(previous, image), &change(previous_reference, reference))))
}

fn check(image: &ImageRgb, reference: &ImageRgb) -> Result<(), MetricError> {
    let size = |image: &ImageRgb| [image.width, image.height];
    if size(image) != size(reference) || image.pixels.is_empty() {
        return Err(MetricError::Size { image: size(image), reference: size(reference) });
    }
    for (which, image) in [("image", image), ("reference", reference)] {
        let values = image.pixels.iter().flatten();
        if let Some((i, &value)) = values.enumerate().find(|(_, value)| !value.is_finite()) {
            let (pixel, channel) = ((i / 3) as u32, i % 3);
            let (x, y) = (pixel % image.width, pixel / image.width);
            return Err(MetricError::NotFinite { which, x, y, channel, value });
        }
    }
    Ok(())
}

fn mse(a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let sum: f64 = a
        .iter()
        .flatten()
        .zip(b.iter().flatten())
        .map(|(a, b)| {
            let difference = f64::from(*a) - f64::from(*b);
            difference * difference
        })
        .sum();
    sum / (3 * a.len()) as f64
}

/// The peak is 1.
fn psnr_from_mse(mse: f64) -> f64 {
    if mse == 0.0 { f64::INFINITY } else { -10.0 * mse.log10() }
}

fn bias_percent(image: &ImageRgb, reference: &ImageRgb) -> f64 {
    let sum = |image: &ImageRgb| image.pixels.iter().flatten().copied().map(f64::from).sum::<f64>();
    match (sum(image), sum(reference)) {
        (image, reference) if image == reference => 0.0,
        (image, reference) => 100.0 * (image / reference - 1.0),
    }
}

fn relative_mse(image: &ImageRgb, reference: &ImageRgb) -> f64 {
    let values = image.pixels.iter().flatten().zip(reference.pixels.iter().flatten());
    let sum: f64 = values
        .map(|(&i, &r)| {
            let (i, r) = (f64::from(i), f64::from(r));
            (i - r) * (i - r) / (r * r + 0.01)
        })
        .sum();
    sum / (3 * image.pixels.len()) as f64
}

fn flip(image: &ImageRgb, reference: &ImageRgb) -> f64 {
    let errors =
        flip_map(&image.to_display_rgb8(), &reference.to_display_rgb8(), [image.width, image.height]);
    errors.iter().copied().map(f64::from).sum::<f64>() / errors.len() as f64
}

/// LDR FLIP of every pixel, 0 to 1, of images as shown in 8 bits.
///
/// # Panics
/// Where an image has not `width * height` pixels.
pub fn flip_map(shown: &[u8], reference: &[u8], [width, height]: [u32; 2]) -> Vec<f32> {
    let image = |rgb: &[u8]| nv_flip::FlipImageRgb8::with_data(width, height, rgb);
    nv_flip::flip(image(reference), image(shown), nv_flip::DEFAULT_PIXELS_PER_DEGREE).to_vec()
}

/// Taps to either side of the SSIM window's centre, and its sigma: 11x11, 1.5 (Wang et al. 2004).
const SSIM_RADIUS: usize = 5;
const SSIM_SIGMA: f64 = 1.5;
const SSIM_C1: f64 = 0.01 * 0.01;
const SSIM_C2: f64 = 0.03 * 0.03;

/// Mean SSIM over channels and over the pixels whose window lies inside the image. Along a side shorter than a
/// window all pixels count, with windows cut at the border.
fn ssim(a: &[[f32; 3]], b: &[[f32; 3]], width: usize, height: usize) -> f64 {
    let channel =
        |image: &[[f32; 3]], c: usize| -> Vec<f64> { image.iter().map(|p| f64::from(p[c])).collect() };
    let inside = |length: usize| {
        if length > 2 * SSIM_RADIUS { SSIM_RADIUS..length - SSIM_RADIUS } else { 0..length }
    };
    let mut sum = 0.0;
    for c in 0..3 {
        let (a, b) = (channel(a, c), channel(b, c));
        let product = |p: &[f64], q: &[f64]| -> Vec<f64> { p.iter().zip(q).map(|(p, q)| p * q).collect() };
        let mean = |values: Vec<f64>| gaussian(&values, width, height);
        let (aa, bb, ab) = (mean(product(&a, &a)), mean(product(&b, &b)), mean(product(&a, &b)));
        let (a, b) = (mean(a), mean(b));
        for y in inside(height) {
            for x in inside(width) {
                let i = y * width + x;
                let (va, vb, cov) = (aa[i] - a[i] * a[i], bb[i] - b[i] * b[i], ab[i] - a[i] * b[i]);
                let luminance = (2.0 * a[i] * b[i] + SSIM_C1) / (a[i] * a[i] + b[i] * b[i] + SSIM_C1);
                sum += luminance * (2.0 * cov + SSIM_C2) / (va + vb + SSIM_C2);
            }
        }
    }
    sum / (3 * inside(width).len() * inside(height).len()) as f64
}

/// Separable Gaussian mean; at the border the weights that are left are renormalised.
fn gaussian(values: &[f64], width: usize, height: usize) -> Vec<f64> {
    let weights: [f64; 2 * SSIM_RADIUS + 1] =
        std::array::from_fn(|i| (-0.5 * ((i as f64 - SSIM_RADIUS as f64) / SSIM_SIGMA).powi(2)).exp());
    let blur = |values: &[f64], length: usize, stride: usize, start: usize, out: &mut [f64]| {
        for i in 0..length {
            let (mut sum, mut total) = (0.0, 0.0);
            for j in i.saturating_sub(SSIM_RADIUS)..=(i + SSIM_RADIUS).min(length - 1) {
                let w = weights[j + SSIM_RADIUS - i];
                sum += w * values[start + j * stride];
                total += w;
            }
            out[start + i * stride] = sum / total;
        }
    };
    let mut rows = vec![0.0; values.len()];
    for y in 0..height {
        blur(values, width, 1, y * width, &mut rows);
    }
    let mut out = vec![0.0; values.len()];
    for x in 0..width {
        blur(&rows, height, width, x, &mut out);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Smooth colours with enough structure that a shift by a row matters.
    fn picture() -> ImageRgb {
        ImageRgb::from_fn(32, 24, |x, y| {
            let (x, y) = (x as f32, y as f32);
            [1.0 + (x * 0.7).sin(), 0.5 + 0.4 * (y * 0.9).cos(), 0.1 + 0.02 * (x + y)]
        })
    }

    #[test]
    fn equal_images_are_perfect_and_json_stays_valid() {
        let metrics = compare(&picture(), &picture()).unwrap();
        assert_eq!(metrics.psnr_db, f64::INFINITY);
        assert!((metrics.ssim - 1.0).abs() < 1e-12);
        assert_eq!((metrics.flip, metrics.relative_mse), (0.0, 0.0));
        let p = picture();
        assert_eq!(temporal_psnr(&p, &p, &p, &p).unwrap(), f64::INFINITY);
        let json = serde_json::to_string(&metrics).unwrap();
        let value: serde_json::Value = serde_json::from_str(&json).unwrap();
        assert!(value["psnr_db"].is_null(), "{json}");
    }

    #[test]
    fn constant_images_have_the_values_of_the_formulas() {
        // 0 shows as 0; 1 as 0.735357 (x / (1 + x), then sRGB).
        let (black, white) = (ImageRgb::new(16, 16), ImageRgb::from_fn(16, 16, |_, _| [1.0; 3]));
        let metrics = compare(&black, &white).unwrap();
        let shown = 0.735_356_98_f64;
        assert!((metrics.psnr_db + 20.0 * shown.log10()).abs() < 1e-4, "{metrics:?}");
        // Constant windows have no variance, so SSIM is its luminance term alone.
        assert!((metrics.ssim - SSIM_C1 / (shown * shown + SSIM_C1)).abs() < 1e-6, "{metrics:?}");
        assert!((metrics.relative_mse - 1.0 / 1.01).abs() < 1e-6, "{metrics:?}");
        assert!(metrics.flip > 0.5, "{metrics:?}");
        // The change from black to white against no change at all: the same error as black against white.
        let t = temporal_psnr(&black, &white, &black, &black).unwrap();
        assert!((t - metrics.psnr_db).abs() < 1e-9);
    }

    #[test]
    fn ssim_matches_its_definition_summed_directly() {
        let (a, b) = (picture().to_display(), {
            let mut other = picture();
            other.pixels.rotate_left(3);
            other.to_display()
        });
        let (width, height) = (32_usize, 24_usize);
        let (mut total, mut count) = (0.0, 0);
        for c in 0..3 {
            for y in 5..height - 5 {
                for x in 5..width - 5 {
                    let (mut w, mut m, mut n, mut mm, mut nn, mut mn) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
                    for dy in 0..11 {
                        for dx in 0..11 {
                            let r2 = (dx as f64 - 5.0).powi(2) + (dy as f64 - 5.0).powi(2);
                            let g = (-r2 / (2.0 * 1.5 * 1.5)).exp();
                            let i = (y + dy - 5) * width + x + dx - 5;
                            let (p, q) = (f64::from(a[i][c]), f64::from(b[i][c]));
                            w += g;
                            m += g * p;
                            n += g * q;
                            mm += g * p * p;
                            nn += g * q * q;
                            mn += g * p * q;
                        }
                    }
                    let (m, n, mm, nn, mn) = (m / w, n / w, mm / w, nn / w, mn / w);
                    total += (2.0 * m * n + SSIM_C1) * (2.0 * (mn - m * n) + SSIM_C2)
                        / ((m * m + n * n + SSIM_C1) * (mm - m * m + nn - n * n + SSIM_C2));
                    count += 1;
                }
            }
        }
        assert!((ssim(&a, &b, width, height) - total / f64::from(count)).abs() < 1e-9);
    }

    #[test]
    fn every_metric_notices_a_shifted_row_and_a_swapped_channel() {
        let good = picture();
        let mut shifted = good.clone();
        shifted.pixels[12 * 32..13 * 32].rotate_right(1);
        let mut swapped = good.clone();
        for pixel in &mut swapped.pixels {
            pixel.swap(0, 1);
        }
        for (name, wrong) in [("shifted", &shifted), ("swapped", &swapped)] {
            let metrics = compare(wrong, &good).unwrap();
            assert!(metrics.psnr_db < 50.0, "{name}: {metrics:?}");
            assert!(metrics.ssim < 0.99, "{name}: {metrics:?}");
            assert!(metrics.flip > 0.001, "{name}: {metrics:?}");
            assert!(metrics.relative_mse > 1e-4, "{name}: {metrics:?}");
            assert!(temporal_psnr(&good, wrong, &good, &good).unwrap() < 50.0, "{name}");
        }
    }

    #[test]
    fn reflective_pixels_are_measured_alone() {
        let good = picture();
        let mut bad = good.clone();
        bad.pixels[40] = [7.0; 3];
        let psnr = |mask: &dyn Fn(usize) -> bool| {
            let mask: Vec<bool> = (0..good.pixels.len()).map(mask).collect();
            compare_reflective(&bad, &good, &mask).unwrap().reflective_psnr_db
        };
        let all = compare(&bad, &good).unwrap();
        assert_eq!(all.reflective_psnr_db, None);
        assert_eq!(psnr(&|_| false), None);
        assert_eq!(psnr(&|i| i != 40), Some(f64::INFINITY));
        assert_eq!(psnr(&|_| true), Some(all.psnr_db));
        // The same error over a quarter of the pixels.
        let quarter = psnr(&|i| i < good.pixels.len() / 4).unwrap();
        assert!((quarter - all.psnr_db + 10.0 * 4f64.log10()).abs() < 1e-9, "{quarter}");
    }

    #[test]
    fn a_nan_pixel_is_an_error_that_says_where() {
        let good = picture();
        let mut bad = good.clone();
        bad.pixels[2 * 32 + 5][1] = f32::NAN;
        let error = compare(&bad, &good).unwrap_err();
        assert_eq!(error.to_string(), "the image has NaN at pixel (5, 2), channel G");
        assert!(compare(&good, &bad).unwrap_err().to_string().contains("reference"));
        assert!(temporal_psnr(&good, &good, &bad, &good).is_err());
        bad.pixels[2 * 32 + 5][1] = f32::INFINITY;
        assert!(compare(&bad, &good).is_err());
    }

    #[test]
    fn sizes_must_agree_and_small_images_work() {
        let error = compare(&ImageRgb::new(4, 4), &ImageRgb::new(4, 5)).unwrap_err();
        assert!(error.to_string().contains("4x4") && error.to_string().contains("4x5"), "{error}");
        assert!(compare(&ImageRgb::new(0, 0), &ImageRgb::new(0, 0)).is_err());
        for (width, height) in [(1, 1), (1, 2), (10, 11), (17, 9)] {
            let image = ImageRgb::from_fn(width, height, |x, y| [x as f32, y as f32, 1.0]);
            let metrics = compare(&image, &image).unwrap();
            assert!((metrics.ssim - 1.0).abs() < 1e-12, "{width}x{height}");
        }
    }
}
