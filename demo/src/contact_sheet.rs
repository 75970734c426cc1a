//! A grid of labelled images in one PNG, to look at many results at once.

use crate::image::{ImageFileError, ImageRgb, write_png_rgb8};
use ab_glyph::{Font, FontRef, PxScale, ScaleFont, point};
use std::path::Path;

/// Pixels between images, and around them.
const GAP: u32 = 4;
/// Height of the strip above an image that holds its label.
const LABEL_HEIGHT: u32 = 18;
const FONT_SIZE: f32 = 15.0;
const BACKGROUND: u8 = 24;

/// Images with labels, filled into a grid row by row.
#[derive(Debug, Default)]
pub struct ContactSheet {
    tiles: Vec<(String, Tile)>,
}

#[derive(Debug)]
struct Tile {
    width: u32,
    height: u32,
    rgb: Vec<u8>,
}

impl ContactSheet {
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds an image as it is shown (tonemapped, sRGB).
    pub fn add(&mut self, label: impl Into<String>, image: &ImageRgb) {
        let tile = Tile { width: image.width, height: image.height, rgb: image.to_display_rgb8() };
        self.tiles.push((label.into(), tile));
    }

    /// Draws the grid with at most `columns` images in a row: width, height and 8-bit RGB. Cells are as large as the
    /// largest image. Labels that are wider than their cell are cut.
    pub fn draw(&self, columns: u32) -> (u32, u32, Vec<u8>) {
        let cell_width = self.tiles.iter().map(|(_, tile)| tile.width).max().unwrap_or(0);
        let cell_height = self.tiles.iter().map(|(_, tile)| tile.height).max().unwrap_or(0) + LABEL_HEIGHT;
        let columns = columns.clamp(1, (self.tiles.len() as u32).max(1));
        let rows = (self.tiles.len() as u32).div_ceil(columns);
        let (width, height) = (GAP + columns * (cell_width + GAP), GAP + rows * (cell_height + GAP));
        let mut sheet = Tile { width, height, rgb: vec![BACKGROUND; width as usize * height as usize * 3] };
        for ((label, tile), i) in self.tiles.iter().zip(0..) {
            let left = GAP + (i % columns) * (cell_width + GAP);
            let top = GAP + (i / columns) * (cell_height + GAP);
            sheet.draw_text(label, left, top, cell_width);
            sheet.draw_tile(tile, left, top + LABEL_HEIGHT);
        }
        (sheet.width, sheet.height, sheet.rgb)
    }

    /// Writes [`draw`](Self::draw) as a PNG.
    pub fn write_png(&self, path: &Path, columns: u32) -> Result<(), ImageFileError> {
        let (width, height, rgb) = self.draw(columns);
        write_png_rgb8(path, width, height, &rgb)
    }
}

impl Tile {
    fn draw_tile(&mut self, tile: &Self, left: u32, top: u32) {
        if tile.width == 0 {
            return;
        }
        for (row, y) in tile.rgb.chunks_exact(tile.width as usize * 3).zip(top..) {
            let start = (y * self.width + left) as usize * 3;
            self.rgb[start..start + row.len()].copy_from_slice(row);
        }
    }

    fn draw_text(&mut self, text: &str, left: u32, top: u32, max_width: u32) {
        let Ok(font) = FontRef::try_from_slice(epaint_default_fonts::UBUNTU_LIGHT) else {
            return;
        };
        let scaled = font.as_scaled(PxScale::from(FONT_SIZE));
        let mut caret = point(left as f32, top as f32 + scaled.ascent());
        for character in text.chars() {
            let glyph = scaled.scaled_glyph(character);
            let advance = scaled.h_advance(glyph.id);
            if caret.x + advance > (left + max_width) as f32 {
                return;
            }
            let mut glyph = glyph;
            glyph.position = caret;
            if let Some(outline) = font.outline_glyph(glyph) {
                let bounds = outline.px_bounds();
                outline.draw(|x, y, coverage| {
                    self.blend_white(
                        bounds.min.x as i64 + i64::from(x),
                        bounds.min.y as i64 + i64::from(y),
                        coverage,
                    );
                });
            }
            caret.x += advance;
        }
    }

    fn blend_white(&mut self, x: i64, y: i64, coverage: f32) {
        if !(0..i64::from(self.width)).contains(&x) || !(0..i64::from(self.height)).contains(&y) {
            return;
        }
        let at = (y as usize * self.width as usize + x as usize) * 3;
        for value in &mut self.rgb[at..at + 3] {
            let old = f32::from(*value);
            *value = (old + (255.0 - old) * coverage.clamp(0.0, 1.0)).round() as u8;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_lie_where_they_should_under_their_labels() {
        let mut sheet = ContactSheet::new();
        for i in 0..3 {
            sheet.add(format!("frame {i}"), &ImageRgb::from_fn(60, 20, |_, _| [i as f32, 0.0, 1e9]));
        }
        let (width, height, rgb) = sheet.draw(2);
        assert_eq!((width, height), (GAP + 2 * (60 + GAP), GAP + 2 * (20 + LABEL_HEIGHT + GAP)));
        assert_eq!(rgb.len(), (width * height * 3) as usize);
        let pixel = |x: u32, y: u32| &rgb[((y * width + x) * 3) as usize..][..3];
        assert_eq!(pixel(GAP, GAP + LABEL_HEIGHT), [0, 0, 255]);
        // The second image: 1 shows as 188 of 255.
        assert_eq!(pixel(2 * GAP + 60, GAP + LABEL_HEIGHT), [188, 0, 255]);
        let label = (0..LABEL_HEIGHT).flat_map(|y| (0..60).map(move |x| (GAP + x, GAP + y)));
        assert!(label.into_iter().any(|(x, y)| pixel(x, y)[0] > 200), "no text was drawn");
    }

    #[test]
    fn an_empty_sheet_and_a_tiny_image_do_not_panic() {
        ContactSheet::new().draw(4);
        let mut sheet = ContactSheet::new();
        sheet.add("a label wider than its image", &ImageRgb::new(1, 1));
        sheet.draw(0);
    }
}
