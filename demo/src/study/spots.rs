//! Where to look: pixels whose errors are plotted, and the part of the image that is enlarged.

use super::errors::Truth;
use super::report::Rect;
use super::surfaces::{Surfaces, TILE, Tiles};
use crate::image::{ImageRgb, luminance};
use std::collections::HashMap;

/// A pixel whose errors are plotted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Spot {
    pub label: &'static str,
    pub pixel: [u32; 2],
}

/// Surroundings of a tile, 3x3 tiles, all of whose pixels show surfaces.
#[derive(Debug)]
struct Surroundings {
    place: [u32; 2],
    /// Share of the pixels that have the commonest surface id.
    one_surface: f64,
    /// 1 minus the length of the mean normal.
    bend: f64,
    /// Standard deviation over mean, of albedo.
    albedo: f64,
    /// As `albedo`, of the light on the surface; without the reference's noise.
    light: f64,
    /// Mean light.
    level: f64,
}

impl Surroundings {
    fn is_plane(&self) -> bool {
        self.one_surface == 1.0 && self.bend < 1e-3
    }
}

const MOST_ALBEDO_OF_A_FLAT: f64 = 0.02;
const LEAST_ALBEDO_OF_A_TEXTURE: f64 = 0.1;
const LEAST_LIGHT_OF_A_SHADOW: f64 = 0.1;
const LEAST_EDGE: f64 = 0.5; // 1 where two surfaces share the window equally
/// Share of the image's median light below which nobody would see an error.
const DARK: f64 = 0.25;
/// Spots are this share of the image's width apart.
const APART: f64 = 1.0 / 8.0;
/// Share of what qualifies, the clearest first, of which the one in the middle of the image is taken.
const CLEAR: f64 = 0.2;

/// An edge, a shadow, a texture and a flat wall, apart from each other; what the image has of these.
pub fn choose(surfaces: &Surfaces, tiles: &Tiles, truth: &Truth) -> Vec<Spot> {
    let mut all: Vec<_> =
        tiles.places.iter().filter_map(|&place| surroundings(place, surfaces, truth)).collect();
    let levels = all.iter().map(|s| s.level).collect();
    let dark = DARK * crate::quality::median(levels).unwrap_or(0.0);
    all.retain(|s| s.level > dark);
    type Score = fn(&Surroundings) -> Option<f64>;
    let kinds: [(&str, Score); 4] = [
        ("edge", |s| {
            let edge = 2.0 * (1.0 - s.one_surface);
            (edge > LEAST_EDGE).then_some(edge.min(1.0))
        }),
        ("shadow", |s| {
            let found = s.is_plane() && s.albedo < MOST_ALBEDO_OF_A_FLAT && s.light > LEAST_LIGHT_OF_A_SHADOW;
            found.then_some(s.light)
        }),
        ("texture", |s| (s.is_plane() && s.albedo > LEAST_ALBEDO_OF_A_TEXTURE).then_some(s.albedo - s.light)),
        ("flat wall", |s| (s.is_plane() && s.albedo < MOST_ALBEDO_OF_A_FLAT).then_some(-s.light)),
    ];
    let apart = APART * f64::from(surfaces.width);
    let distance = |a: [u32; 2], b: [u32; 2]| {
        (f64::from(a[0]) - f64::from(b[0])).hypot(f64::from(a[1]) - f64::from(b[1]))
    };
    let middle = [surfaces.width / 2, surfaces.height / 2];
    let mut spots: Vec<Spot> = Vec::new();
    for (label, score) in kinds {
        let pixel = |s: &Surroundings| s.place.map(|place| place * TILE + TILE / 2);
        let is_free = |pixel: [u32; 2]| spots.iter().all(|spot| distance(spot.pixel, pixel) >= apart);
        let free = all.iter().filter(|s| is_free(pixel(s)));
        let mut scored: Vec<_> = free.filter_map(|s| Some((score(s)?, pixel(s)))).collect();
        scored.sort_by(|a, b| b.0.total_cmp(&a.0));
        scored.truncate((CLEAR * scored.len() as f64).ceil() as usize);
        let pixels = scored.into_iter().map(|(_, pixel)| pixel);
        let nearest = pixels.min_by(|&a, &b| distance(a, middle).total_cmp(&distance(b, middle)));
        spots.extend(nearest.map(|pixel| Spot { label, pixel }));
    }
    spots
}

fn surroundings(place: [u32; 2], surfaces: &Surfaces, truth: &Truth) -> Option<Surroundings> {
    let [left, top] = place.map(|at| (at * TILE).checked_sub(TILE));
    let (left, top) = (left?, top?);
    let side = 3 * TILE;
    if left + side > surfaces.width || top + side > surfaces.height {
        return None;
    }
    let pixels: Vec<usize> = (top..top + side)
        .flat_map(|y| (left..left + side).map(move |x| [x, y]))
        .map(|pixel| surfaces.index(pixel))
        .collect();
    if pixels.iter().any(|&i| !surfaces.hit[i]) {
        return None;
    }
    let count = pixels.len() as f64;
    let mut ids = HashMap::new();
    let mut normal = [0.0; 3];
    for &i in &pixels {
        *ids.entry(surfaces.id[i]).or_insert(0) += 1;
        (0..3).for_each(|c| normal[c] += f64::from(surfaces.normal.pixels[i][c]) / count);
    }
    let commonest: i32 = ids.values().copied().max()?;
    let albedo: Vec<f64> = pixels.iter().map(|&i| luminance(surfaces.albedo.pixels[i])).collect();
    let halves = [0, 1].map(|half| pixels.iter().map(|&i| truth.half(half, i)).collect::<Vec<f64>>());
    let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
    let covariance = |a: &[f64], b: &[f64]| {
        let products: Vec<f64> = a.iter().zip(b).map(|(a, b)| a * b).collect();
        (mean(&products) - mean(a) * mean(b)).max(0.0)
    };
    let level = 0.5 * (mean(&halves[0]) + mean(&halves[1]));
    Some(Surroundings {
        place,
        one_surface: f64::from(commonest) / count,
        bend: 1.0 - normal.iter().map(|n| n * n).sum::<f64>().sqrt(),
        albedo: covariance(&albedo, &albedo).sqrt() / mean(&albedo).max(1e-6),
        light: covariance(&halves[0], &halves[1]).sqrt() / level.max(1e-6),
        level,
    })
}

/// A step between neighbours counts no more than this, so that one strong edge does not outweigh much detail.
const MOST_STEP: f32 = 0.1;

/// The quarter of the image (in each direction) with the most detail. Of two references with independent noise, of which the
/// product of their steps sees nothing.
pub fn detailed_part([a, b]: [&ImageRgb; 2]) -> Rect {
    let (width, height) = (a.width, a.height);
    let [w, h] = [width, height].map(|side| (side / 4).max(1));
    let shown = [a.to_display(), b.to_display()];
    // Summed-area table of the steps, one wider and higher than the image.
    let stride = (width + 1) as usize;
    let mut sums = vec![0.0_f64; stride * (height + 1) as usize];
    for y in 0..height {
        for x in 0..width {
            let product = |other: (u32, u32)| -> f32 {
                let value = |half: &Vec<[f32; 3]>, (x, y): (u32, u32)| half[(y * width + x) as usize][1];
                let steps = shown.each_ref().map(|half| value(half, (x, y)) - value(half, other));
                (steps[0] * steps[1]).clamp(-MOST_STEP * MOST_STEP, MOST_STEP * MOST_STEP)
            };
            let detail = product((x.saturating_sub(1), y)) + product((x, y.saturating_sub(1)));
            let at = (y + 1) as usize * stride + (x + 1) as usize;
            sums[at] = f64::from(detail) + sums[at - 1] + sums[at - stride] - sums[at - stride - 1];
        }
    }
    let sum = |x: u32, y: u32| {
        let at = |x: u32, y: u32| sums[y as usize * stride + x as usize];
        at(x + w, y + h) - at(x, y + h) - at(x + w, y) + at(x, y)
    };
    let places = (0..=height - h).flat_map(|y| (0..=width - w).map(move |x| [x, y]));
    let [x, y] = places.max_by(|a, b| sum(a[0], a[1]).total_cmp(&sum(b[0], b[1]))).unwrap_or([0, 0]);
    Rect { x, y, width: w, height: h }
}

#[cfg(test)]
mod tests {
    use super::super::surfaces::tests::wall;
    use super::*;

    #[test]
    fn each_kind_is_found_where_it_is() {
        // 320x24: another surface from x = 64 on; a texture about 160; a shadow's edge at 256; the sky at 312.
        let mut surfaces = wall(320, 24, 312);
        let shadow = ImageRgb::from_fn(320, 24, |x, _| [if x < 256 { 1.0 } else { 0.5 }; 3]);
        for i in 0..surfaces.id.len() {
            let x = i % 320;
            surfaces.id[i] = u32::from(x >= 64);
            if (154..166).contains(&x) && x % 2 == 0 {
                surfaces.albedo.pixels[i] = [0.5; 3];
            }
        }
        let lit = ImageRgb::from_fn(320, 24, |x, y| {
            let i = (y * 320 + x) as usize;
            [shadow.pixels[i][0] * surfaces.albedo.pixels[i][0]; 3]
        });
        let truth = Truth::new(&surfaces, [&lit, &lit]);
        let spots = choose(&surfaces, &Tiles::new(&surfaces), &truth);
        let labels: Vec<_> = spots.iter().map(|spot| spot.label).collect();
        assert_eq!(labels, ["edge", "shadow", "texture", "flat wall"]);
        for (spot, x) in spots.iter().zip([64, 256, 160]) {
            assert!(spot.pixel[0].abs_diff(x) <= 4, "{spot:?}");
        }
        // No kind at all on a curved thing.
        surfaces.normal = ImageRgb::from_fn(320, 24, |x, _| [(x as f32).sin(), 0.0, (x as f32).cos()]);
        surfaces.id.fill(1);
        assert_eq!(choose(&surfaces, &Tiles::new(&surfaces), &truth), []);
    }

    #[test]
    fn the_zoom_shows_detail_and_fits() {
        let noise = |x: u32, y: u32, seed: u32| (x * 7919 + y * 104_729 + seed * 31) % 17 < 8;
        let image = |seed: u32| {
            ImageRgb::from_fn(40, 24, |x, y| {
                let is_checked = x >= 30 && y >= 16;
                let value = if is_checked { (x + y) % 2 == 0 } else { noise(x, y, seed) };
                [f32::from(u8::from(value)); 3]
            })
        };
        let part = detailed_part([&image(0), &image(1)]);
        assert!(part.x >= 29 && part.y >= 16 && (part.width, part.height) == (10, 6), "{part:?}");
        let one = ImageRgb::new(1, 1);
        assert_eq!(detailed_part([&one, &one]), Rect { x: 0, y: 0, width: 1, height: 1 });
    }
}
