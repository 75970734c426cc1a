//! Images on the CPU: linear RGB floats, how they are shown, written and moved to and from the GPU.

mod files;
mod transfer;

pub use files::{ImageFileError, png_rgb8, write_png_rgb8};
pub use transfer::{half_from_f32, write_texture};

/// A scene-linear RGB image, rows from top to bottom.
#[derive(Debug, Clone, PartialEq)]
pub struct ImageRgb {
    pub width: u32,
    pub height: u32,
    /// `width * height` pixels.
    pub pixels: Vec<[f32; 3]>,
}

impl ImageRgb {
    /// A black image.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![[0.0; 3]; width as usize * height as usize] }
    }

    /// The image whose pixel at (x, y) is `pixel(x, y)`.
    pub fn from_fn(width: u32, height: u32, mut pixel: impl FnMut(u32, u32) -> [f32; 3]) -> Self {
        let mut image = Self::new(width, height);
        for (i, value) in image.pixels.iter_mut().enumerate() {
            *value = pixel((i % width as usize) as u32, (i / width as usize) as u32);
        }
        image
    }

    /// The image as it is shown and measured: every value through [`display_from_linear`].
    pub fn to_display(&self) -> Vec<[f32; 3]> {
        self.pixels.iter().map(|pixel| pixel.map(display_from_linear)).collect()
    }

    /// [`to_display`](Self::to_display) in 8 bits, tightly packed RGB.
    pub fn to_display_rgb8(&self) -> Vec<u8> {
        self.pixels
            .iter()
            .flatten()
            .map(|&value| (display_from_linear(value) * 255.0).round() as u8)
            .collect()
    }
}

/// ITU-R BT.709.
pub fn luminance([r, g, b]: [f32; 3]) -> f64 {
    0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b)
}

/// Tonemaps a linear value by x / (1 + x) and encodes it as sRGB, in 0 to 1. Negative and NaN give 0, infinity 1.
pub fn display_from_linear(linear: f32) -> f32 {
    // Written as a comparison because it sends NaN to 0.
    let x = if linear > 0.0 { linear.min(f32::MAX) } else { 0.0 };
    srgb_from_linear(x / (1.0 + x))
}

/// The sRGB transfer function on 0 to 1.
pub fn srgb_from_linear(linear: f32) -> f32 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn display_values_are_known_and_bounded() {
        assert_eq!(display_from_linear(0.0), 0.0);
        // 1 tonemaps to 0.5, whose sRGB code is 0.735357.
        assert!((display_from_linear(1.0) - 0.735_357).abs() < 1e-5);
        assert!((srgb_from_linear(0.002) - 0.025_84).abs() < 1e-6);
        assert!((display_from_linear(f32::INFINITY) - 1.0).abs() < 1e-6);
        assert_eq!(display_from_linear(f32::NAN), 0.0);
        assert_eq!(display_from_linear(-3.0), 0.0);
    }
}
