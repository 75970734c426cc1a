//! `moments` against its f64 twin.

use super::surface::features;
use super::{Surface, guide, mismatches, random_history, run, uniforms, wide};
use crate::gpu::{download_buffer, gpu, upload, upload_buffer};
use crate::sequence::frame;
use glam::Vec3;
use quell::gpu::FrameUniforms;
use quell::layout::{self, COLUMNS, HALF_SQUARES, SQUARES, TILE, TILE_STRIDE};
use quell::passes::moments::{Moments, MomentsViews};
use rand::{Rng, SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

const N: usize = COLUMNS as usize;

/// A weighted pixel: features, then colour.
pub type Row = (f64, [f64; N]);

/// Rows of the pixels of a rectangle that have a surface and samples, with their variances.
pub fn rows(
    u: &FrameUniforms,
    x: std::ops::Range<u32>,
    y: std::ops::Range<u32>,
    surfaces: &[Surface],
    history: &[[f64; 4]],
    noise: &[[f32; 2]],
) -> Vec<(Row, [f64; 3])> {
    let [width, height] = u.size;
    let mut rows = vec![];
    for py in y.start..y.end.min(height) {
        for px in x.start..x.end.min(width) {
            let i = (py * width + px) as usize;
            if surfaces[i].is_miss() || history[i][3] <= 0.0 {
                continue;
            }
            let mut columns = [0.0; N];
            columns[..N - 3].copy_from_slice(&features(u, i, &surfaces[i]));
            columns[N - 3..].copy_from_slice(&history[i][..3]);
            let ([v, e], n) = (noise[i].map(f64::from), history[i][3]);
            rows.push(((n, columns), [v, e * e, v / n]));
        }
    }
    rows
}

/// Weight, means, and squares about the means.
pub fn moments(rows: &[Row]) -> (f64, [f64; N], Vec<f64>) {
    let weight: f64 = rows.iter().map(|(w, _)| w).sum();
    let mean = std::array::from_fn(|i| {
        if weight > 0.0 { rows.iter().map(|(w, c)| w * c[i]).sum::<f64>() / weight } else { 0.0 }
    });
    let mut squares = vec![];
    for i in 0..N {
        for j in i..N {
            squares.push(rows.iter().map(|(w, c)| w * (c[i] - mean[i]) * (c[j] - mean[j])).sum());
        }
    }
    (weight, mean, squares)
}

#[test]
fn match_their_twin_on_every_tile() {
    let size = [45, 35]; // not a multiple of the tile
    let mut random = StdRng::seed_from_u64(21);
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let frame = frame(size, eye, eye, 1);
    let u = uniforms(&frame, &frame);
    let (words, surfaces) = guide(&frame);
    let history = random_history(&mut random, surfaces.len());
    let noise: Vec<[f32; 2]> =
        surfaces.iter().map(|_| [random.random_range(0.0..2.0), random.random_range(-1.0..1.0)]).collect();
    let [columns, tile_rows] = layout::tiles(size);
    let tiles = (columns * tile_rows) as usize;
    let means = upload_buffer(&vec![0.0; tiles * TILE_STRIDE as usize]);
    let low = upload_buffer(&vec![0.0; tiles * HALF_SQUARES as usize]);
    let high = upload_buffer(&vec![0.0; tiles * HALF_SQUARES as usize]);
    let pass = Moments::new(&gpu().device);
    run(&u, |recorder| {
        let views = MomentsViews {
            guide: &upload(size, Format::Rgba32Uint, &words),
            history: &upload(size, Format::Rgba16Float, &history),
            noise: &upload(size, Format::Rg32Float, &noise),
            tile_means: &means,
            tile_squares_low: &low,
            tile_squares_high: &high,
        };
        pass.record(recorder, &views, size);
    });
    let (means, low, high) = (download_buffer(&means), download_buffer(&low), download_buffer(&high));

    let history = wide(&history);
    let (mut found, mut expected) = (Vec::<f32>::new(), vec![]);
    for tile in 0..tiles {
        let (tx, ty) = (tile as u32 % columns * TILE, tile as u32 / columns * TILE);
        let rows = rows(&u, tx..tx + TILE, ty..ty + TILE, &surfaces, &history, &noise);
        let pooled = |c: usize| rows.iter().map(|((w, _), v)| w * v[c]).sum::<f64>();
        let pooled = [pooled(0), pooled(1), pooled(2)];
        let rows: Vec<Row> = rows.into_iter().map(|(row, _)| row).collect();
        let (weight, mean, squares) = moments(&rows);
        expected.push(weight);
        expected.extend(pooled.map(|sum| if weight > 0.0 { sum / weight } else { 0.0 }));
        expected.extend(mean);
        expected.extend(squares);
        let half = HALF_SQUARES as usize;
        found.extend(&means[tile * TILE_STRIDE as usize..][..TILE_STRIDE as usize]);
        found.extend(&low[tile * half..][..half]);
        found.extend(&high[tile * half..][..SQUARES as usize - half]);
    }
    let found: Vec<f64> = found.into_iter().map(f64::from).collect();
    // Sums of 16 products of f32; squares near 0 keep the rounding of the terms they cancel from.
    assert_eq!(mismatches(&found, &expected, 1e-4, 2e-4), 0.0);
    expected[0] += 1.0;
    assert!(mismatches(&found, &expected, 1e-4, 2e-4) > 0.0);
}
