//! `change` against its f64 twin.

use super::noise::{Noise, random_noise, unpack};
use super::regression::{Tile, TileBuffers};
use super::surface::surface_features;
use super::{Surface, guide, luminance, mismatches, random_history, random_signal};
use super::{run, uniforms, wide};
use crate::gpu::{gpu, upload};
use crate::sequence::frame;
use glam::Vec3;
use quell::gpu::FrameUniforms;
use quell::layout::{self, INNOVATIONS, REGION, SURFACE_FEATURES};
use quell::passes::change::{Change, ChangeViews};
use rand::{Rng, SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

pub const N: usize = INNOVATIONS.columns() as usize;

/// The pixels of a region that have a surface, samples and history, and the means of their noises.
fn region(
    u: &FrameUniforms,
    [x, y]: [u32; 2],
    surfaces: &[Surface],
    signal: &[[f64; 4]],
    history: &[[f64; 4]],
    noise: &[Noise],
) -> Tile<N> {
    let [width, height] = u.size;
    let (mut rows, mut sums) = (vec![], [0.0; 3]);
    for py in y..(y + REGION).min(height) {
        for px in x..(x + REGION).min(width) {
            let i = (py * width + px) as usize;
            let (sample, old) = (signal[i], history[i]);
            if surfaces[i].is_miss() || sample[3] <= 0.0 || old[3] <= 0.0 {
                continue;
            }
            let mut columns = [0.0; N];
            columns[..SURFACE_FEATURES as usize].copy_from_slice(&surface_features(u, i, &surfaces[i]));
            (0..3).for_each(|c| columns[N - 3 + c] = sample[c] - old[c]);
            let noises = [noise[i].variance, luminance([old[0], old[1], old[2]]), old[3]];
            (0..3).for_each(|k| sums[k] += sample[3] * noises[k]);
            rows.push((sample[3], columns));
        }
    }
    let weight: f64 = rows.iter().map(|(w, _)| w).sum();
    Tile { rows, noises: sums.map(|sum| sum / weight.max(1e-30)) }
}

#[test]
fn matches_its_twin_on_every_region() {
    let size = [45, 35]; // not a multiple of the region
    let mut random = StdRng::seed_from_u64(22);
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let mut frame = frame(size, eye, eye, 1);
    frame.normal.iter_mut().for_each(|n| n[3] = random.random());
    let u = uniforms(&frame, &frame);
    let (words, surfaces) = guide(&frame);
    let history = random_history(&mut random, surfaces.len());
    let noise = random_noise(&mut random, surfaces.len());
    let signal = random_signal(&mut random, &surfaces);
    let [columns, region_rows] = layout::regions(size);
    let nothing = Tile::<N> { rows: vec![], noises: [0.0; 3] };
    let buffers = TileBuffers::upload(&vec![nothing; (columns * region_rows) as usize]);
    let pass = Change::new(&gpu().device);
    run(&u, |recorder| {
        let views = ChangeViews {
            signal: &upload(size, Format::Rgba16Float, &signal),
            guide: &upload(size, Format::Rgba32Uint, &words),
            reprojected: &upload(size, Format::Rgba16Float, &history),
            reprojected_noise: &upload(size, Format::Rgba16Float, &noise),
            tile_means: &buffers.means,
            tile_squares_low: &buffers.low,
            tile_squares_high: &buffers.high,
        };
        pass.record(recorder, &views, size);
    });
    let found = buffers.download::<N>();

    let (signal, history, noise) = (wide(&signal), wide(&history), unpack(&noise));
    let corner = |t: u32| [t % columns * REGION, t / columns * REGION];
    let mut expected: Vec<f64> = (0..columns * region_rows)
        .flat_map(|t| region(&u, corner(t), &surfaces, &signal, &history, &noise).flat())
        .collect();
    // Sums of 64 products of f32 with weights up to 40; squares near 0 keep the rounding of the terms they cancel from.
    assert_eq!(mismatches(&found, &expected, 1e-4, 1e-3), 0.0);
    expected.iter_mut().step_by(N).for_each(|v| *v += 0.1);
    assert!(mismatches(&found, &expected, 1e-4, 1e-3) > 0.01);
}
