//! `compose` against its f64 twin.

use super::noise::{Noise, random_noise, unpack};
use super::surface::{position_of, same_surface};
use super::{guide, luminance, mismatches, random_history, run, uniforms, wide};
use crate::gpu::{blank, download, gpu, upload};
use crate::sequence::frame;
use glam::{DVec2, Vec3};
use quell::gpu::flags;
use quell::passes::compose::{Compose, ComposeViews};
use rand::{Rng, SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

const SIZE: [u32; 2] = [61, 43];

fn rgb(v: &[f64; 4]) -> [f64; 3] {
    [v[0], v[1], v[2]]
}

#[test]
fn matches_its_twin_on_random_images() {
    let mut random = StdRng::seed_from_u64(51);
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let frame = frame(SIZE, eye, eye, 1);
    let mut u = uniforms(&frame, &frame);
    u.flags |= flags::EMISSION;
    let (words, surfaces) = guide(&frame);
    let history = random_history(&mut random, surfaces.len());
    // Predictions near the mean, so that all shares between 0 and 1 occur; w is the mean's standard error.
    let prediction: Vec<[half::f16; 4]> = history
        .iter()
        .map(|h| {
            let standard_error = if f32::from(h[3]) == 0.0 { -1.0 } else { random.random_range(0.0..0.3) };
            let error: f32 = random.random_range(-0.4..0.8); // with a bias, as models have
            let colour = [h[0], h[1], h[2]].map(|c| (f32::from(c) + error).max(0.0));
            [colour[0], colour[1], colour[2], standard_error].map(half::f16::from_f32)
        })
        .collect();
    let noise = random_noise(&mut random, surfaces.len());
    let half_texels = |texels: &[[f32; 4]]| -> Vec<[half::f16; 4]> {
        texels.iter().map(|t| t.map(half::f16::from_f32)).collect()
    };
    let albedo = half_texels(&frame.albedo);
    let emission = half_texels(&vec![[0.25, 0.5, 0.0, 0.0]; surfaces.len()]);
    let (output, mix_weight) = (blank(SIZE, Format::Rgba16Float), blank(SIZE, Format::R32Float));
    let pass = Compose::new(&gpu().device);
    run(&u, |recorder| {
        let views = ComposeViews {
            guide: &upload(SIZE, Format::Rgba32Uint, &words),
            prediction: &upload(SIZE, Format::Rgba16Float, &prediction),
            history: &upload(SIZE, Format::Rgba16Float, &history),
            noise: &upload(SIZE, Format::Rgba16Float, &noise),
            radiance: &upload(SIZE, Format::Rgba32Float, &frame.radiance),
            albedo: &upload(SIZE, Format::Rgba16Float, &albedo),
            emission: &upload(SIZE, Format::Rgba16Float, &emission),
            output: &output,
            mix_weight: &mix_weight,
        };
        pass.record(recorder, &views, SIZE);
    });
    let found = wide(&download(&output));
    let found_share: Vec<f64> = download::<f32>(&mix_weight).into_iter().map(f64::from).collect();

    let (history, prediction, albedo) = (wide(&history), wide(&prediction), wide(&albedo));
    let [width, height] = SIZE.map(|side| side as usize);
    let position = |i: usize| {
        let pixel = DVec2::new((i % width) as f64, (i / width) as f64);
        position_of(&u, &u.current, pixel, surfaces[i].depth)
    };
    let related = |i: usize, t: usize| {
        same_surface(&surfaces[i], &surfaces[t], position(t) - position(i)) && prediction[t][3] >= 0.0
    };
    let around = |i: usize, radius: usize| -> Vec<usize> {
        let (x, y) = (i % width, i / width);
        let rows = y.saturating_sub(radius)..(y + radius + 1).min(height);
        let columns = x.saturating_sub(radius)..(x + radius + 1).min(width);
        let taps = rows.flat_map(|ty| columns.clone().map(move |tx| ty * width + tx));
        taps.filter(|&t| related(i, t)).collect()
    };
    let residual = |i: usize| luminance(rgb(&history[i])) - luminance(rgb(&prediction[i]));
    let noise = unpack(&noise);
    let mean = |taps: &[usize], value: &dyn Fn(usize) -> f64| {
        taps.iter().map(|&t| value(t)).sum::<f64>() / taps.len().max(1) as f64
    };
    let (mut expected, mut expected_share) = (vec![], vec![]);
    for i in 0..surfaces.len() {
        if surfaces[i].is_miss() {
            let seen = frame.radiance[i].map(f64::from);
            expected.push([seen[0], seen[1], seen[2], 1.0]);
            expected_share.push(1.0);
            continue;
        }
        let pool = around(i, 2);
        let smooth_noise = |t: usize| {
            let taps = around(t, 1);
            let deviations = std::array::from_fn(|k| mean(&taps, &|t| noise[t].deviations[k]));
            1.5 * Noise { deviations, ..Noise::default() }.found()
        };
        let smooth: f64 = pool.iter().map(|&t| mean(&around(t, 1), &residual).powi(2)).sum();
        let beyond = (smooth - pool.iter().map(|&t| smooth_noise(t)).sum::<f64>()).max(0.0);
        let error = if beyond > 0.0 { beyond * beyond / smooth } else { 0.0 };
        let variance = pool.iter().map(|&t| prediction[t][3].powi(2)).sum::<f64>();
        let variance = variance.max(pool.iter().map(|&t| noise[t].found()).sum());
        let none = prediction[i][3] < 0.0 || error == 0.0;
        let share = if none { 0.0 } else { error / (error + variance) * (1.0 - 1.0 / pool.len() as f64) };
        let colour: [f64; 3] = std::array::from_fn(|c| {
            let filtered = prediction[i][c] + share * (history[i][c] - prediction[i][c]);
            filtered * albedo[i][c].max(0.02) + [0.25, 0.5, 0.0][c]
        });
        expected.push([colour[0], colour[1], colour[2], 1.0]);
        expected_share.push(share);
    }
    let mixed = expected_share.iter().filter(|&&s| s > 0.1 && s < 0.9).count();
    assert!(mixed > 100, "the test shows too few mixed pixels: {mixed}");
    // A neighbour on the threshold of a surface test may fall to either side; the output rounds to half floats.
    assert!(mismatches(&found_share, &expected_share, 1e-3, 1e-3) <= 0.005);
    assert!(mismatches(found.as_flattened(), expected.as_flattened(), 2.0_f64.powi(-9), 2e-3) <= 0.005);
    // The comparator notices an output without its emission.
    expected.iter_mut().for_each(|p| p[1] -= 0.5);
    assert!(mismatches(found.as_flattened(), expected.as_flattened(), 2.0_f64.powi(-9), 2e-3) > 0.2);
}
