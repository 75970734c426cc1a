//! Writing images: PNG as shown, OpenEXR as linear floats.

use super::ImageRgb;
use exr::prelude::WritableImage;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why an image could not be written or read.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum ImageFileError {
    /// The PNG encoder or the disk refused.
    #[error("{}: cannot write PNG", path.display())]
    Png {
        path: PathBuf,
        #[source]
        source: image::ImageError,
    },
    /// The EXR encoder, decoder or the disk refused.
    #[error("{}: OpenEXR", path.display())]
    Exr {
        path: PathBuf,
        #[source]
        source: exr::error::Error,
    },
}

impl ImageRgb {
    /// Writes the image as it is shown (tonemapped, sRGB, 8 bits).
    pub fn write_png(&self, path: &Path) -> Result<(), ImageFileError> {
        write_png_rgb8(path, self.width, self.height, &self.to_display_rgb8())
    }

    /// Writes linear 32-bit `R`, `G`, `B`.
    pub fn write_exr(&self, path: &Path) -> Result<(), ImageFileError> {
        use exr::prelude::{Encoding, Image, Layer, LayerAttributes, SpecificChannels};
        let width = self.width as usize;
        let pixel = |at: exr::math::Vec2<usize>| {
            let [r, g, b] = self.pixels[at.y() * width + at.x()];
            (r, g, b)
        };
        let layer = Layer::new(
            (width, self.height as usize),
            LayerAttributes::default(),
            Encoding::SMALL_LOSSLESS,
            SpecificChannels::rgb(pixel),
        );
        Image::from_layer(layer)
            .write()
            .to_file(path)
            .map_err(|source| ImageFileError::Exr { path: path.to_owned(), source })
    }

    /// Reads `R`, `G`, `B` of an EXR file.
    pub fn read_exr(path: &Path) -> Result<Self, ImageFileError> {
        use exr::prelude::{ReadChannels, ReadLayers, read};
        let image = read()
            .no_deep_data()
            .largest_resolution_level()
            .rgb_channels(
                |size, _| Self::new(size.width() as u32, size.height() as u32),
                |image, at, (r, g, b): (f32, f32, f32)| {
                    image.pixels[at.y() * image.width as usize + at.x()] = [r, g, b];
                },
            )
            .first_valid_layer()
            .all_attributes()
            .from_file(path)
            .map_err(|source| ImageFileError::Exr { path: path.to_owned(), source })?;
        Ok(image.layer_data.channel_data.pixels)
    }
}

/// Writes 8-bit RGB as it is.
pub fn write_png_rgb8(path: &Path, width: u32, height: u32, rgb: &[u8]) -> Result<(), ImageFileError> {
    image::save_buffer_with_format(path, rgb, width, height, image::ColorType::Rgb8, image::ImageFormat::Png)
        .map_err(|source| ImageFileError::Png { path: path.to_owned(), source })
}

/// 8-bit RGB as the bytes of a PNG, as small as it gets: filters help smooth images, and hurt those of few colours.
pub fn png_rgb8(width: u32, height: u32, rgb: &[u8]) -> Result<Vec<u8>, image::ImageError> {
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};
    let encoded = |filter| {
        let mut bytes = Vec::new();
        let encoder = PngEncoder::new_with_quality(&mut bytes, CompressionType::Best, filter);
        image::ImageEncoder::write_image(encoder, rgb, width, height, image::ExtendedColorType::Rgb8)?;
        Ok::<_, image::ImageError>(bytes)
    };
    let (filtered, plain) = (encoded(FilterType::Adaptive)?, encoded(FilterType::NoFilter)?);
    Ok(if plain.len() < filtered.len() { plain } else { filtered })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exr_keeps_every_bit_and_png_the_size() {
        let folder = tempfile::tempdir().unwrap();
        let image = ImageRgb::from_fn(7, 3, |x, y| [x as f32 * 0.1, y as f32 * 1e4, 1.0 / 3.0]);
        let path = folder.path().join("image.exr");
        image.write_exr(&path).unwrap();
        assert_eq!(ImageRgb::read_exr(&path).unwrap(), image);
        let path = folder.path().join("image.png");
        image.write_png(&path).unwrap();
        let png = image::open(&path).unwrap().to_rgb8();
        assert_eq!(png.dimensions(), (7, 3));
        assert_eq!(png.as_raw(), &image.to_display_rgb8());
    }

    #[test]
    fn a_missing_folder_is_named() {
        let path = Path::new("/no/such/folder/image.png");
        let error = ImageRgb::new(2, 2).write_png(path).unwrap_err();
        assert!(error.to_string().contains("/no/such/folder/image.png"), "{error}");
    }
}
