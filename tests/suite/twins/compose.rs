//! `compose` against its f64 twin.

use super::packed::{Noise, quieter, random_noise, unpack_noises};
use super::prediction::Models;
use super::surface::{Surface, is_alike, of_albedo, position_of, towards_eye};
use super::{Signal, guide, luminance, mismatches, rgb, run, uniforms, wide};
use crate::gpu::{blank, download, gpu, upload, upload_buffer, upload_words};
use crate::sequence::frame;
use glam::{DVec2, DVec3, Vec3};
use quell::gpu::flags;
use quell::passes::compose::{Compose, ComposeViews};
use rand::{Rng, SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

const SIZE: [u32; 2] = [61, 43];

/// What a dielectric reflects in all directions: Schlick's formula, limited by roughness.
fn dielectric(surface: &Surface, towards: DVec3) -> f64 {
    let grazing = (1.0 - surface.normal.dot(towards).clamp(0.0, 1.0)).powi(5);
    0.04 + grazing * ((1.0 - surface.roughness).max(0.04) - 0.04)
}

fn check(signal: Signal, with_albedo: bool, index: u32) {
    let mut random = StdRng::seed_from_u64(51);
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let mut frame = frame(SIZE, eye, eye, 1);
    frame.normal.iter_mut().enumerate().for_each(|(i, normal)| normal[3] = (i % 9) as f32 / 8.0);
    let mut u = uniforms(&frame, &frame);
    u.index = index;
    let is_specular = signal == Signal::Specular;
    u.flags |= match (signal, with_albedo) {
        (Signal::Combined, _) => flags::EMISSION,
        (Signal::Specular, false) => flags::SPLIT,
        (Signal::Specular, true) => flags::SPLIT | flags::SPECULAR_ALBEDO,
    };
    let (words, surfaces) = guide(&frame);
    let models = Models::random(&mut random, SIZE);
    let prediction = models.predict(&u, signal, &surfaces);
    // Means near the prediction, so that all shares between 0 and 1 occur; some without a sample.
    let history: Vec<[half::f16; 4]> = prediction
        .iter()
        .map(|predicted| {
            let error = random.random_range(-0.8..0.4); // with a bias, as models have
            let [r, g, b] = predicted.signal.map(|c| (c + error).max(0.0));
            let count = if random.random_bool(0.1) { 0.0 } else { random.random_range(1.0..80.0) };
            [r, g, b, count].map(half::f16::from_f64)
        })
        .collect();
    let mut noise = random_noise(&mut random, surfaces.len());
    // In the left half the mean is found to be less noisy than is expected of it, in the right one noisier.
    for (_, word) in noise.iter_mut().enumerate().filter(|(i, _)| i % (SIZE[0] as usize) < 30) {
        *word = quieter(*word);
    }
    let half_texels = |texels: &[[f32; 4]]| -> Vec<[half::f16; 4]> {
        texels.iter().map(|t| t.map(half::f16::from_f32)).collect()
    };
    let albedo = half_texels(&frame.albedo);
    let emission = half_texels(&vec![[0.25, 0.5, 0.0, 0.0]; surfaces.len()]);
    let output = blank(SIZE, Format::Rgba16Float);
    let [error, mix_weight] = [(); 2].map(|()| blank(SIZE, Format::R32Uint));
    let shown = blank(SIZE, Format::Rg32Uint);
    let rest: Vec<[half::f16; 4]> = surfaces
        .iter()
        .map(|_| [0.5, 0.25, 0.0, 1.0].map(|most| half::f16::from_f32(most * random.random::<f32>())))
        .collect();
    let device = &gpu().device;
    let pass = if is_specular { Compose::specular(device) } else { Compose::new(device) };
    let views = ComposeViews {
        guide: &upload(SIZE, Format::Rg32Uint, &words),
        models: &upload_buffer(&models.models),
        windows: &upload_words(&models.windows),
        history: &upload(SIZE, Format::Rgba16Float, &history),
        noise: &upload(SIZE, Format::R32Uint, &noise),
        albedo: &upload(SIZE, Format::Rgba16Float, &albedo),
        emission: &upload(SIZE, Format::Rgba16Float, &emission),
        rest: &upload(SIZE, Format::Rgba16Float, &rest),
        output: &output,
        error: &error,
        prediction: &shown,
        mix_weight: &mix_weight,
    };
    // Prediction, mix weight and error are other images' memory unless somebody asks for them.
    u.flags &= !(flags::DEBUG | flags::ERROR);
    run(&u, |recorder| pass.record(recorder, &views, SIZE));
    assert!([&mix_weight, &error].iter().all(|image| download::<u32>(image).iter().all(|&word| word == 0)));
    assert!(download::<[u32; 2]>(&shown).iter().all(|&words| words == [0; 2]));
    u.flags |= flags::DEBUG | flags::ERROR;
    run(&u, |recorder| pass.record(recorder, &views, SIZE));
    let found = wide(&download(&output));
    let found_error: Vec<[f64; 2]> =
        download::<[half::f16; 2]>(&error).into_iter().map(|parts| parts.map(|part| part.to_f64())).collect();
    let found_share: Vec<f64> = download::<f32>(&mix_weight).into_iter().map(f64::from).collect();

    let (history, albedo, rest) = (wide(&history), wide(&albedo), wide(&rest));
    let counts = |i: usize| history[i][3] > 0.0 && prediction[i].is_known();
    let [width, height] = SIZE.map(|side| side as usize);
    let position = |i: usize| {
        let pixel = DVec2::new((i % width) as f64, (i / width) as f64);
        position_of(&u, &u.current, pixel, surfaces[i].depth)
    };
    // Pixels of one row or column, by the surface of the earlier one.
    let linked = |i: usize, t: usize| {
        let (earlier, later) = (i.min(t), i.max(t));
        let offset = position(later) - position(earlier);
        let is_hit = !surfaces[earlier].is_miss();
        i == t || is_hit && is_alike(&surfaces[earlier], &surfaces[later], offset, 0.8)
    };
    // Of workgroups of 2x2 tiles, whose grid is moved by up to one to the left and above, elsewhere every 16 frames.
    let shift = [[0, 0], [8, 0], [8, 8], [0, 8]][u.index as usize / 16 % 4];
    let near = |at: usize, radius: usize, shift: usize, end: usize| {
        let group = (at + shift) / 16 * 16;
        let first = group.saturating_sub(shift).max(at.saturating_sub(radius));
        first..(at + radius + 1).min(group + 16 - shift).min(end)
    };
    // Rows of what goes with their middle, which goes with that of all.
    let around = |i: usize, radius: usize| -> Vec<usize> {
        let (x, y) = (i % width, i / width);
        let rows = near(y, radius, shift[1], height);
        let columns = near(x, radius, shift[0], width);
        let middles = rows.map(|ty| ty * width + x).filter(|&middle| linked(i, middle));
        let of_row = |middle: usize| {
            let row = columns.clone().map(move |tx| middle - x + tx);
            row.filter(|&t| linked(middle, t)).collect::<Vec<_>>()
        };
        middles.flat_map(of_row).filter(|&t| counts(t)).collect()
    };
    // The pass holds what it smooths as half floats.
    let half = |v: f64| f64::from(half::f16::from_f64(v));
    let residual = |i: usize| half(luminance(rgb(&history[i])) - luminance(prediction[i].signal));
    let noise = unpack_noises(&noise, &history);
    let mean = |taps: &[usize], value: &dyn Fn(usize) -> f64| {
        taps.iter().map(|&t| value(t)).sum::<f64>() / taps.len().max(1) as f64
    };
    let rest_at = |i: usize| if is_specular { rest[i] } else { [0.0; 4] };
    let reflectance_at = |i: usize| -> [f64; 3] {
        match (signal, with_albedo) {
            (Signal::Combined, _) => std::array::from_fn(|c| of_albedo(albedo[i][c])),
            (Signal::Specular, true) => std::array::from_fn(|c| albedo[i][c].max(0.02)),
            (Signal::Specular, false) => [dielectric(&surfaces[i], towards_eye(&u.current, position(i))); 3],
        }
    };
    let (mut expected, mut expected_share, mut expected_error) = (vec![], vec![], vec![]);
    for i in 0..surfaces.len() {
        if surfaces[i].is_miss() {
            // The history holds its radiance.
            let seen: [f64; 3] = std::array::from_fn(|c| history[i][c] + rest_at(i)[c]);
            expected.push([seen[0], seen[1], seen[2], 1.0]);
            expected_share.push(1.0);
            expected_error.push([rest_at(i)[3], luminance(seen)]);
            continue;
        }
        let pool = around(i, 2);
        let smooth_noise = |t: usize| {
            let taps = around(t, 1);
            let deviations = std::array::from_fn(|k| mean(&taps, &|t| half(noise[t].deviations[k])));
            2.0 * Noise { deviations, ..Noise::default() }.found()
        };
        let smooth: f64 = pool.iter().map(|&t| mean(&around(t, 1), &residual).powi(2)).sum();
        let chance = pool.iter().map(|&t| smooth_noise(t)).sum::<f64>();
        let beyond = (smooth - chance).max(0.0);
        let error = if is_specular || surfaces[i].roughness < 0.5 {
            (smooth - 0.5 * chance).max(0.0)
        } else if beyond > 0.0 {
            beyond * beyond / smooth
        } else {
            0.0
        };
        let rounded = |variance: f64| half(variance.sqrt()).powi(2);
        let of_mean = |t: &usize| rounded(prediction[*t].error_of_mean(noise[*t].variance, history[*t][3]));
        let variance = pool.iter().map(of_mean).sum::<f64>();
        let found = pool.iter().map(|&t| rounded(noise[t].found())).sum::<f64>();
        let variance = if is_specular { found } else { variance.max(found) };
        let share = if !prediction[i].is_known() {
            1.0 // the temporal mean is all there is
        } else if !counts(i) || error == 0.0 {
            0.0
        } else {
            error / (error + variance) * (1.0 - 1.0 / (pool.len() as f64).powi(2))
        };
        let colour: [f64; 3] = std::array::from_fn(|c| {
            let filtered = prediction[i].signal[c] + share * (history[i][c] - prediction[i].signal[c]);
            let added = if is_specular { rest[i][c] } else { [0.25, 0.5, 0.0][c] };
            filtered * reflectance_at(i)[c] + added
        });
        // What is left of the mean's noise and of the model's error, and noise of the model: twelve coefficients, 320 pixels.
        let per_pixel = |sum: f64| sum / pool.len() as f64;
        let square = if pool.is_empty() {
            let l = if prediction[i].is_known() { prediction[i].signal } else { rgb(&history[i]) };
            prediction[i].relative_noise.max(1.0) * luminance(l).powi(2)
        } else {
            let rest = 1.0 - share;
            let own_noise = rest * 12.0 / 320.0;
            per_pixel(variance) * (share * share + own_noise) + rest * rest * per_pixel(error)
        };
        expected.push([colour[0], colour[1], colour[2], 1.0]);
        expected_share.push(share);
        let deviation = (square.sqrt() * luminance(reflectance_at(i))).hypot(rest_at(i)[3]);
        expected_error.push([deviation, luminance(colour)]);
    }
    let mixed = expected_share.iter().filter(|&&s| s > 0.1 && s < 0.9).count();
    assert!(mixed > 100, "the test shows too few mixed pixels: {mixed}");
    // A neighbour on the threshold of a surface test may fall to either side; the output rounds to half floats.
    assert!(mismatches(&found_share, &expected_share, 1e-3, 1e-3) <= 0.005);
    assert!(mismatches(found.as_flattened(), expected.as_flattened(), 2.0_f64.powi(-9), 2e-3) <= 0.005);
    assert!(
        mismatches(found_error.as_flattened(), expected_error.as_flattened(), 2.0_f64.powi(-9), 2e-3)
            <= 0.005
    );
    // The comparator notices errors of the irradiance instead of the radiance, and an output without its emission.
    expected_error.iter_mut().enumerate().for_each(|(i, e)| e[0] /= reflectance_at(i)[0]);
    assert!(
        mismatches(found_error.as_flattened(), expected_error.as_flattened(), 2.0_f64.powi(-9), 2e-3) > 0.2
    );
    expected.iter_mut().for_each(|p| p[1] -= 0.5);
    assert!(mismatches(found.as_flattened(), expected.as_flattened(), 2.0_f64.powi(-9), 2e-3) > 0.2);
}

#[test]
fn matches_its_twin_on_random_images() {
    // Before the grid of workgroups moves, and in the three other places.
    [15, 16, 32, 63].into_iter().for_each(|index| check(Signal::Combined, true, index));
}

#[test]
fn matches_its_twin_on_the_specular_signal() {
    check(Signal::Specular, true, 40);
    check(Signal::Specular, false, 0);
}
