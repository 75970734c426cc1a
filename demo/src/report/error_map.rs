//! Where methods differ from the reference: FLIP per pixel, its colours, and the parts that are worth enlarging.

use crate::metrics::flip_map;
use crate::study::Rect;

/// FLIP of every pixel, per method, and the scale on which all are drawn.
pub struct ErrorMaps {
    pub methods: Vec<Vec<f32>>,
    /// What the brightest colour stands for; errors beyond it are drawn alike.
    pub full_scale: f32,
}

/// Share of the denoisers' pixels that lie within the scale; the few beyond would darken all others.
const WITHIN_SCALE: f64 = 0.995;
const SCALE_STEP: f32 = 0.1;

impl ErrorMaps {
    /// Of images as shown. The scale is that of the `denoisers`: the noisy input exceeds it.
    pub fn new(methods: &[Vec<u8>], reference: &[u8], size: [u32; 2], denoisers: &[bool]) -> Self {
        let methods: Vec<Vec<f32>> = methods.iter().map(|rgb| flip_map(rgb, reference, size)).collect();
        let mut all: Vec<f32> = chosen(&methods, denoisers).flatten().copied().collect();
        all.sort_by(f32::total_cmp);
        let top = all.get((all.len() as f64 * WITHIN_SCALE) as usize).copied().unwrap_or(1.0);
        let full_scale = ((top / SCALE_STEP).ceil() * SCALE_STEP).clamp(SCALE_STEP, 1.0);
        Self { methods, full_scale }
    }

    /// A method's map as 8-bit RGB.
    pub fn draw(&self, method: usize) -> Vec<u8> {
        self.methods[method].iter().flat_map(|error| magma(error / self.full_scale)).collect()
    }
}

/// Box over which differences are averaged before they count as errors: what is left of the reference's noise is small there,
/// while lost shadows, ghosts and blotches stay.
const NOISE_BOX_RADIUS: usize = 2;

/// Error of every pixel without the reference's noise, summed over the denoisers so that no single one decides which part is
/// looked at.
pub fn lasting_errors(methods: &[Vec<u8>], reference: &[u8], width: u32, denoisers: &[bool]) -> Vec<f32> {
    let mut sum = vec![0.0; reference.len() / 3];
    for rgb in chosen(methods, denoisers) {
        for c in 0..3 {
            let channel = rgb.iter().zip(reference).skip(c).step_by(3);
            let difference: Vec<f32> = channel.map(|(a, b)| f32::from(*a) - f32::from(*b)).collect();
            let blurred = box_means(&difference, width as usize);
            sum.iter_mut().zip(blurred).for_each(|(sum, error)| *sum += error.abs());
        }
    }
    sum
}

/// Means over boxes, cut at the border.
fn box_means(values: &[f32], width: usize) -> Vec<f32> {
    let height = values.len() / width;
    let sums = prefix_sums(values, width);
    let at = |x: usize, y: usize| sums[y * (width + 1) + x];
    let range =
        |i: usize, end: usize| (i.saturating_sub(NOISE_BOX_RADIUS), (i + NOISE_BOX_RADIUS + 1).min(end));
    let mean = |i: usize| {
        let ((x0, x1), (y0, y1)) = (range(i % width, width), range(i / width, height));
        let sum = at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0);
        (sum / ((x1 - x0) * (y1 - y0)) as f64) as f32
    };
    (0..values.len()).map(mean).collect()
}

/// What is the denoisers'; the noisy input's where there are no others.
fn chosen<'a, T>(methods: &'a [T], denoisers: &'a [bool]) -> impl Iterator<Item = &'a T> {
    let any = denoisers.contains(&true);
    methods
        .iter()
        .zip(denoisers)
        .filter(move |(_, is_denoiser)| **is_denoiser || !any)
        .map(|(method, _)| method)
}

/// matplotlib's magma at equal steps.
pub const MAGMA: [[u8; 3]; 9] = [
    [0, 0, 4],
    [28, 16, 68],
    [79, 18, 123],
    [129, 37, 129],
    [181, 54, 122],
    [229, 80, 100],
    [251, 135, 97],
    [254, 194, 135],
    [252, 253, 191],
];
/// Fewer colours make smaller files, and no eye tells so many apart.
const COLOURS: f32 = 64.0;

fn magma(value: f32) -> [u8; 3] {
    let last = MAGMA.len() - 1;
    let place = (value.clamp(0.0, 1.0) * COLOURS).round() / COLOURS * last as f32;
    let low = (place as usize).min(last - 1);
    let mix = |c: usize| {
        let (a, b) = (f32::from(MAGMA[low][c]), f32::from(MAGMA[low + 1][c]));
        (a + (b - a) * (place - low as f32)).round() as u8
    };
    [mix(0), mix(1), mix(2)]
}

const CROPS: usize = 3;
/// Side of a crop, where the image is large enough.
const CROP_PX: u32 = 64;
/// Crops are tried at every so many pixels.
const STRIDE: u32 = 4;

/// The parts with the largest error, worst first, that do not overlap.
pub fn crops(errors: &[f32], [width, height]: [u32; 2]) -> Vec<Rect> {
    // No more than half of the image: a crop shows a part.
    let [w, h] = [width, height].map(|side| CROP_PX.min(side.div_ceil(2)));
    let sums = prefix_sums(errors, width as usize);
    let mut places: Vec<(f64, Rect)> = Vec::new();
    for y in (0..=height - h).step_by(STRIDE as usize) {
        for x in (0..=width - w).step_by(STRIDE as usize) {
            let at = |x: u32, y: u32| sums[y as usize * (width as usize + 1) + x as usize];
            let sum = at(x + w, y + h) - at(x, y + h) - at(x + w, y) + at(x, y);
            places.push((sum, Rect { x, y, width: w, height: h }));
        }
    }
    places.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<Rect> = Vec::new();
    for (_, place) in places {
        let apart = |other: &Rect| place.x.abs_diff(other.x) >= w || place.y.abs_diff(other.y) >= h;
        if chosen.len() < CROPS && chosen.iter().all(apart) {
            chosen.push(place);
        }
    }
    chosen
}

/// Sums over all pixels above and to the left, with a row and a column of zeros before them.
fn prefix_sums(values: &[f32], width: usize) -> Vec<f64> {
    let mut sums = vec![0.0; width + 1];
    for (y, row) in values.chunks_exact(width).enumerate() {
        let mut sum = 0.0;
        sums.push(0.0);
        for (x, value) in row.iter().enumerate() {
            sum += f64::from(*value);
            sums.push(sum + sums[y * (width + 1) + x + 1]);
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn crops_hold_the_worst_parts_and_do_not_overlap() {
        let (width, height) = (320_u32, 180_u32);
        let spots = [(40, 30), (200, 100), (300, 20)];
        let error = |i: u32| {
            let is_near = |&(x, y): &(u32, u32)| (i % width).abs_diff(x) < 6 && (i / width).abs_diff(y) < 6;
            spots.iter().position(is_near).map_or(0.0, |spot| 1.0 - 0.1 * spot as f32)
        };
        let errors: Vec<f32> = (0..width * height).map(error).collect();
        let found = crops(&errors, [width, height]);
        assert_eq!(found.len(), 3);
        for (crop, (x, y)) in found.iter().zip(spots) {
            assert!(crop.width == 64 && crop.height == 64);
            assert!((crop.x..crop.x + 64).contains(&x) && (crop.y..crop.y + 64).contains(&y), "{crop:?}");
        }
        let tiny = crops(&[0.0; 15], [5, 3]);
        assert!(!tiny.is_empty() && tiny.iter().all(|c| c.x + c.width <= 5 && c.y + c.height <= 3));
        assert_eq!(crops(&[0.5], [1, 1]), [Rect { x: 0, y: 0, width: 1, height: 1 }]);
    }

    #[test]
    fn colours_span_the_scale() {
        assert_eq!([magma(0.0), magma(1.0), magma(7.0)], [MAGMA[0], MAGMA[8], MAGMA[8]]);
        assert_eq!(magma(0.5), MAGMA[4]);
    }

    #[test]
    fn the_scale_is_that_of_the_denoisers() {
        let size = [16, 16];
        let [black, grey, white] = [0u8, 40, 255].map(|value| vec![value; 16 * 16 * 3]);
        let maps = ErrorMaps::new(&[white, grey], &black, size, &[false, true]);
        let (noisy, denoised) = (maps.methods[0][100], maps.methods[1][100]);
        assert!(denoised <= maps.full_scale && maps.full_scale < denoised + 0.1001, "{denoised}");
        assert!(noisy > maps.full_scale);
    }

    #[test]
    fn noise_of_the_reference_is_no_lasting_error() {
        let size = 20_usize;
        let reference: Vec<u8> =
            (0..size * size * 3).map(|i| if i / 3 % 2 == 0 { 60 } else { 140 }).collect();
        let mut image = vec![100; reference.len()];
        // A blotch about (10, 10), on half the contrast of the noise.
        for i in (0..size * size).filter(|i| (i % size).abs_diff(10) < 3 && (i / size).abs_diff(10) < 3) {
            image[3 * i..3 * i + 3].fill(120);
        }
        let noisy = vec![255; reference.len()];
        let errors = lasting_errors(&[noisy, image], &reference, size as u32, &[false, true]);
        let at = |x: usize, y: usize| errors[y * size + x];
        assert!(at(10, 10) > 3.0 * 18.0, "{}", at(10, 10));
        assert!(at(3, 3) < 0.3 * at(10, 10), "{} against {}", at(3, 3), at(10, 10));
    }
}
