//! Halton's sequence: points that cover the unit square evenly, however many are taken.

use glam::Vec2;

/// Frames after which the jitter of a walk repeats; longer ones move edges more slowly than temporal antialiasing averages.
const JITTERS: u32 = 16;

/// Point `index` in bases 2 and 3, from (0, 0) to below (1, 1).
pub fn point(index: u32) -> Vec2 {
    Vec2::new(radical_inverse(index, 2), radical_inverse(index, 3))
}

/// Sub-pixel offsets, half a pixel to each side and at most a hundredth more: the first `count` points, moved so that their
/// mean is 0. As they are they would shift what is averaged over them, by 0.08 pixels with 16.
pub fn offsets_px(count: u32) -> Vec<Vec2> {
    let mean = (0..count).map(point).sum::<Vec2>() / count.max(1) as f32;
    (0..count).map(|index| point(index) - mean).collect()
}

/// The jitter of frame `index` of a walk.
pub fn jitter_px(index: u32) -> Vec2 {
    offsets_px(JITTERS)[(index % JITTERS) as usize]
}

/// The digits of a number mirrored at the point.
fn radical_inverse(mut index: u32, base: u32) -> f32 {
    let (mut value, mut digit) = (0.0, 1.0);
    while index > 0 {
        digit /= base as f32;
        value += digit * (index % base) as f32;
        index /= base;
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn offsets_are_centred_and_within_the_pixel() {
        for count in 1..=256 {
            let offsets = offsets_px(count);
            let mean = offsets.iter().sum::<Vec2>() / count as f32;
            assert!(mean.length() < 1e-5, "{count}: {mean}");
            assert!(offsets.iter().all(|offset| offset.abs().max_element() < 0.51), "{count}: {offsets:?}");
        }
        let shift = (0..JITTERS).map(point).sum::<Vec2>() / JITTERS as f32 - 0.5;
        assert!(shift.length() > 0.05, "the points themselves are off centre");
    }

    /// Largest distance from a place in the pixel to the nearest offset.
    fn largest_gap(offsets: &[Vec2]) -> f32 {
        let places = (0..256).map(|i| Vec2::new((i % 16) as f32 + 0.5, (i / 16) as f32 + 0.5) / 16.0 - 0.5);
        let nearest =
            |place: Vec2| offsets.iter().map(|offset| offset.distance(place)).fold(f32::MAX, f32::min);
        places.map(nearest).fold(0.0, f32::max)
    }

    #[test]
    fn the_jitter_covers_the_pixel_and_repeats() {
        let jitters: Vec<_> = (0..JITTERS).map(jitter_px).collect();
        assert!(largest_gap(&jitters) < 0.25, "{}", largest_gap(&jitters));
        assert!(largest_gap(&jitters[..8]) > 0.25, "half of them leave gaps");
        assert_eq!(jitter_px(JITTERS), jitter_px(0));
    }
}
