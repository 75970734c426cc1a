//! `predict` against its f64 twin.

use super::moments::N;
use super::noise::{random_noise, unpack};
use super::regression::Model;
use super::surface::features;
use super::{guide, luminance, mismatches, random_history, run, uniforms, wide};
use crate::gpu::{blank, download, gpu, upload, upload_buffer, upload_words};
use crate::sequence::frame;
use glam::Vec3;
use quell::layout::{self, MODELS, WIDEST_WINDOW};
use quell::passes::predict::{Predict, PredictViews};
use rand::{Rng, SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

const SIZE: [u32; 2] = [61, 43];

#[test]
fn matches_its_twin_for_random_windows() {
    let mut random = StdRng::seed_from_u64(41);
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let frame = frame(SIZE, eye, eye, 1);
    let u = uniforms(&frame, &frame);
    let (words, surfaces) = guide(&frame);
    let history = random_history(&mut random, surfaces.len());
    let [columns, rows] = layout::tiles(SIZE);
    let stride = MODELS.model_stride() as usize;
    let head = MODELS.head as usize;
    let models: Vec<f32> = (0..columns * rows)
        .flat_map(|_| {
            let mut model: Vec<f32> = (0..stride).map(|_| random.random_range(-0.1..0.1)).collect();
            model[0] = if random.random_bool(0.2) { 0.0 } else { 1.0 };
            model[1] = random.random_range(0.1..1.0);
            model[2] = random.random_range(0.1..5.0);
            model[3] = random.random_range(0.01..1.0);
            model[head + N - 3..][..3].fill(random.random_range(0.5..2.0));
            model
        })
        .collect();
    // Half the tiles have no model; the left third of the image has none at all.
    let windows: Vec<u32> = (0..columns * rows)
        .map(|t| {
            let none = t % columns < columns / 3 || random.random_bool(0.5);
            if none { 0 } else { random.random_range(1..=WIDEST_WINDOW) }
        })
        .collect();
    let noise = random_noise(&mut random, surfaces.len());
    let prediction = blank(SIZE, Format::Rgba16Float);
    let pass = Predict::new(&gpu().device);
    run(&u, |recorder| {
        let views = PredictViews {
            guide: &upload(SIZE, Format::Rgba32Uint, &words),
            history: &upload(SIZE, Format::Rgba16Float, &history),
            noise: &upload(SIZE, Format::Rgba16Float, &noise),
            models: &upload_buffer(&models),
            windows: &upload_words(&windows),
            prediction: &prediction,
        };
        pass.record(recorder, &views, SIZE);
    });
    let found = wide(&download(&prediction));

    let (history, noise) = (wide(&history), unpack(&noise));
    let (mut expected, mut alone) = (vec![], 0);
    for (i, surface) in surfaces.iter().enumerate() {
        if surface.is_miss() {
            expected.push([0.0; 4]);
            continue;
        }
        let z = features(&u, i, surface);
        let (x, y) = ((i as u32 % SIZE[0]) as f64 + 0.5, (i as u32 / SIZE[0]) as f64 + 0.5);
        let (mut sum, mut gain, mut relative_noise, mut total) = ([0.0; 3], 0.0, 0.0, 0.0);
        // Every model of the image: those that do not reach the pixel have weight 0.
        for (tile, model) in models.chunks(stride).enumerate() {
            let reach = f64::from(windows[tile]) * 4.0 + 2.0;
            let (cx, cy) = ((tile as u32 % columns * 4 + 2) as f64, (tile as u32 / columns * 4 + 2) as f64);
            let tent = (1.0 - (x - cx).abs() / reach).max(0.0) * (1.0 - (y - cy).abs() / reach).max(0.0);
            if windows[tile] == 0 || model[0] <= 0.0 || tent == 0.0 {
                continue;
            }
            let weight = tent * f64::from(model[3]);
            let value = Model::<N>::stored(&model[head..]).value(&z);
            (0..3).for_each(|c| sum[c] += weight * value[c]);
            gain += weight * f64::from(model[1]);
            relative_noise += weight * f64::from(model[2]);
            total += weight;
        }
        alone += usize::from(total == 0.0);
        let mean = [history[i][0], history[i][1], history[i][2]];
        let predicted = if total > 0.0 { sum.map(|s| (s / total).max(0.0)) } else { mean };
        let standard_error = if total > 0.0 && history[i][3] > 0.0 {
            let n = history[i][3];
            // With a prior sample, as noisy as the window's.
            let prior = relative_noise / total * luminance(predicted).powi(2);
            ((gain / total * noise[i].variance * n + prior) / (n + 1.0) / n).sqrt()
        } else {
            -1.0
        };
        expected.push([predicted[0], predicted[1], predicted[2], standard_error]);
    }
    assert!(alone > 100, "no pixel is out of all models' reach");
    // Half floats round to 2^-11; values cancel to no less than 1e-3 of the largest.
    assert_eq!(mismatches(found.as_flattened(), expected.as_flattened(), 2.0_f64.powi(-10), 1e-3), 0.0);
    expected.iter_mut().for_each(|p| p[1] += 0.05);
    assert!(mismatches(found.as_flattened(), expected.as_flattened(), 2.0_f64.powi(-10), 1e-3) > 0.1);
}
