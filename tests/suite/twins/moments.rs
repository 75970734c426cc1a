//! `moments` against its f64 twin.

use super::noise::{Noise, random_noise, unpack};
use super::regression::{Tile, TileBuffers};
use super::surface::features;
use super::{Surface, guide, mismatches, random_history, run, uniforms, wide};
use crate::gpu::{gpu, upload};
use crate::sequence::frame;
use glam::Vec3;
use quell::gpu::FrameUniforms;
use quell::layout::{self, MODELS, TILE};
use quell::passes::moments::{Moments, MomentsViews};
use rand::{Rng, SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

pub const N: usize = MODELS.columns() as usize;

/// The pixels of a tile that have a surface and samples, and the means of their noises.
fn tile(
    u: &FrameUniforms,
    [x, y]: [u32; 2],
    surfaces: &[Surface],
    history: &[[f64; 4]],
    noise: &[Noise],
) -> Tile<N> {
    let [width, height] = u.size;
    let (mut rows, mut sums) = (vec![], [0.0; 3]);
    for py in y..(y + TILE).min(height) {
        for px in x..(x + TILE).min(width) {
            let i = (py * width + px) as usize;
            if surfaces[i].is_miss() || history[i][3] <= 0.0 {
                continue;
            }
            let mut columns = [0.0; N];
            columns[..N - 3].copy_from_slice(&features(u, i, &surfaces[i]));
            columns[N - 3..].copy_from_slice(&history[i][..3]);
            let (noise, n) = (&noise[i], history[i][3]);
            let noises = [noise.variance, noise.found(), noise.variance / n];
            (0..3).for_each(|k| sums[k] += n * noises[k]);
            rows.push((n, columns));
        }
    }
    let weight: f64 = rows.iter().map(|(w, _)| w).sum();
    Tile { rows, noises: sums.map(|sum| sum / weight.max(1e-30)) }
}

#[test]
fn match_their_twin_on_every_tile() {
    let size = [45, 35]; // not a multiple of the tile
    let mut random = StdRng::seed_from_u64(21);
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let mut frame = frame(size, eye, eye, 1);
    frame.normal.iter_mut().for_each(|n| n[3] = random.random());
    let u = uniforms(&frame, &frame);
    let (words, surfaces) = guide(&frame);
    let history = random_history(&mut random, surfaces.len());
    let noise = random_noise(&mut random, surfaces.len());
    let [columns, tile_rows] = layout::tiles(size);
    let nothing = Tile::<N> { rows: vec![], noises: [0.0; 3] };
    let buffers = TileBuffers::upload(&vec![nothing; (columns * tile_rows) as usize]);
    let pass = Moments::new(&gpu().device);
    run(&u, |recorder| {
        let views = MomentsViews {
            guide: &upload(size, Format::Rgba32Uint, &words),
            history: &upload(size, Format::Rgba16Float, &history),
            noise: &upload(size, Format::Rgba16Float, &noise),
            tile_means: &buffers.means,
            tile_squares_low: &buffers.low,
            tile_squares_high: &buffers.high,
        };
        pass.record(recorder, &views, size);
    });
    let found = buffers.download::<N>();

    let (history, noise) = (wide(&history), unpack(&noise));
    let corner = |t: u32| [t % columns * TILE, t / columns * TILE];
    let mut expected: Vec<f64> = (0..columns * tile_rows)
        .flat_map(|t| tile(&u, corner(t), &surfaces, &history, &noise).flat())
        .collect();
    // Sums of 16 products of f32; squares near 0 keep the rounding of the terms they cancel from.
    assert_eq!(mismatches(&found, &expected, 1e-4, 2e-4), 0.0);
    expected[0] += 1.0;
    assert!(mismatches(&found, &expected, 1e-4, 2e-4) > 0.0);
}
