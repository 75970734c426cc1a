//! Images, decoded.

use super::error::fail;
use super::limits::{MOST_IMAGE_EXPANSION, MOST_IMAGE_SIDE};
use super::read::File;
use super::{Result, element};
use crate::scene::Image;
use image::{DynamicImage, ImageDecoder, ImageReader};
use std::io::Cursor;

pub(super) fn load(file: &File) -> Result<Vec<Image>> {
    file.document.images().map(|image| load_one(file, &image)).collect()
}

fn load_one(file: &File, image: &gltf::Image<'_>) -> Result<Image> {
    let what = element("image", image.index(), image.name());
    let (fetched, label);
    let bytes = match image.source() {
        gltf::image::Source::Uri { uri, .. } => {
            (fetched, label) = (file.fetch(uri, &what)?, uri);
            fetched.as_slice()
        }
        gltf::image::Source::View { view, .. } => {
            label = "embedded";
            file.view_bytes(&view, &what)?
        }
    };
    // A data URI may be megabytes long.
    let label = if label.starts_with("data:") { "its data URI" } else { label };
    let undecodable = |error: image::ImageError| format!("cannot decode {label}: {error}");
    let decoder = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(image::ImageError::IoError)
        .and_then(ImageReader::into_decoder);
    let decoder = match decoder {
        Ok(decoder) => decoder,
        Err(error) => return fail(&file.path, &what, undecodable(error)),
    };
    let (width, height) = decoder.dimensions();
    if let Err(reason) = check_size(bytes.len(), &decoder) {
        return fail(&file.path, &what, format!("{label}: {reason}"));
    }
    file.budget.image_bytes(4 * u64::from(width) * u64::from(height), &file.path, &what)?;
    match DynamicImage::from_decoder(decoder) {
        Ok(decoded) => Ok(Image {
            name: image.name().unwrap_or(label).to_owned(),
            width,
            height,
            rgba: decoded.into_rgba8().into_raw(),
        }),
        Err(error) => fail(&file.path, &what, undecodable(error)),
    }
}

/// What a header claims, before it becomes an allocation.
fn check_size(file_bytes: usize, decoder: &impl ImageDecoder) -> std::result::Result<(), String> {
    let (width, height) = decoder.dimensions();
    if !(1..=MOST_IMAGE_SIDE).contains(&width.min(height)) || width.max(height) > MOST_IMAGE_SIDE {
        return Err(format!("is {width}x{height}, expected 1 to {MOST_IMAGE_SIDE} pixels a side"));
    }
    let bits = u64::from(decoder.original_color_type().bits_per_pixel());
    let decoded = u64::from(width) * u64::from(height) * bits / 8;
    let most = MOST_IMAGE_EXPANSION * file_bytes as u64;
    if decoded > most {
        return Err(format!(
            "is {width}x{height}, more than its {file_bytes} bytes can hold (truncated, or made to fill memory?)"
        ));
    }
    Ok(())
}
