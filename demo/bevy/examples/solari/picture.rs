//! Pictures of linear light: shown, written, compared.

use bevy::ecs::error::Result;
use std::path::Path;

#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    pub width: u32,
    pub height: u32,
    /// Linear RGB, rows from top to bottom.
    pub pixels: Vec<[f32; 3]>,
}

impl Picture {
    /// As it is shown and compared: tonemapped by x / (1 + x), sRGB-encoded, 0 to 1.
    fn shown(&self) -> Vec<f32> {
        let encode = |x: f32| if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        self.pixels.iter().flatten().map(|&x| encode(x.max(0.0) / (1.0 + x.max(0.0)))).collect()
    }

    pub fn save(&self, path: &Path) -> Result<()> {
        let bytes: Vec<u8> = self.shown().into_iter().map(|x| (255.0 * x).round() as u8).collect();
        Ok(image::save_buffer(path, &bytes, self.width, self.height, image::ColorType::Rgb8)?)
    }

    /// Pictures of one height from left to right.
    pub fn beside(pictures: &[&Self]) -> Self {
        let height = pictures[0].height;
        let row = |y: u32| {
            pictures.iter().flat_map(move |p| &p.pixels[(y * p.width) as usize..][..p.width as usize])
        };
        let pixels = (0..height).flat_map(row).copied().collect();
        Self { width: pictures.iter().map(|p| p.width).sum(), height, pixels }
    }
}

/// Peak signal-to-noise ratio in dB of pictures as shown; the peak is 1.
pub fn psnr_db(picture: &Picture, reference: &Picture) -> Result<f64> {
    let error = difference(picture, reference)?;
    Ok(decibels(error.iter()))
}

/// PSNR of the change since the picture before, against the reference's change.
pub fn temporal_psnr_db(
    [before, now]: [&Picture; 2],
    [reference_before, reference]: [&Picture; 2],
) -> Result<f64> {
    let error = [difference(now, reference)?, difference(before, reference_before)?];
    let changes: Vec<_> = error[0].iter().zip(&error[1]).map(|(now, before)| now - before).collect();
    Ok(decibels(changes.iter()))
}

/// A value that is not finite must not be a silent NaN.
fn difference(picture: &Picture, reference: &Picture) -> Result<Vec<f64>> {
    if [picture.width, picture.height] != [reference.width, reference.height] {
        return Err("pictures differ in size".into());
    }
    if ![picture, reference].iter().all(|picture| picture.pixels.iter().flatten().all(|x| x.is_finite())) {
        return Err("a picture has NaN or infinity".into());
    }
    Ok(picture.shown().iter().zip(reference.shown()).map(|(a, b)| f64::from(a - b)).collect())
}

fn decibels<'a>(errors: impl ExactSizeIterator<Item = &'a f64>) -> f64 {
    let count = errors.len() as f64;
    -10.0 * (errors.map(|error| error * error).sum::<f64>() / count).log10()
}
