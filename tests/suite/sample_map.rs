//! Where further samples are asked for.

use crate::gpu::{blank, download};
use crate::sequence::{Frame, denoiser, frame, read_output, submit, walk};
use glam::Vec3;
use quell::{DebugView, Denoiser, FrameError, HistoryMode, SampleMap, Settings};
use wgpu::TextureFormat as Format;

const SIZE: [u32; 2] = [190, 125];
const EYE: Vec3 = Vec3::new(0.0, 1.4, 1.0);
const DARK_LEVEL: f32 = 0.1;

/// Denoises a frame and returns the samples that it asks for.
fn asked(quell: &mut Denoiser, frame: &Frame, samples_per_pixel: f32) -> Vec<u32> {
    let images = frame.upload();
    let view = &blank(SIZE, Format::R32Uint);
    let sample_map = Some(SampleMap::new(view, samples_per_pixel).with_dark_level(DARK_LEVEL));
    let inputs = images.inputs(frame.camera, HistoryMode::Continue).with_sample_map(sample_map);
    submit(quell, &inputs, &Settings::default());
    download(view)
}

/// Mean over the pixels that are chosen, of those that see a surface.
fn mean(frame: &Frame, samples: &[u32], is_chosen: impl Fn(u32, u32) -> bool) -> f64 {
    let chosen = samples.iter().enumerate().filter(|&(i, _)| {
        let (x, y) = (i as u32 % SIZE[0], i as u32 / SIZE[0]);
        frame.depth[i].is_finite() && is_chosen(x, y)
    });
    let (sum, count) = chosen.fold((0.0, 0.0), |(sum, n), (_, &k)| (sum + f64::from(k), n + 1.0));
    assert!(count > 500.0, "too few pixels are chosen: {count}");
    sum / count
}

#[test]
fn the_mean_is_the_budget_and_misses_get_one() {
    for budget in [0.25, 0.5, 1.0, 3.0, 12.0] {
        let mut quell = denoiser(SIZE);
        let mut sums = 0.0;
        for i in 0..8 {
            let frame = frame(SIZE, EYE, EYE, i);
            let samples = asked(&mut quell, &frame, budget);
            let found = mean(&frame, &samples, |_, _| true);
            assert!(
                (found / f64::from(budget) - 1.0).abs() < 0.05,
                "{found} instead of {budget} in frame {i}"
            );
            sums += found / 8.0;
            let most = (4.0 * budget).max(2.0).ceil() as u32;
            assert!(samples.iter().all(|&k| k <= most), "{:?} at {budget}", samples.iter().max());
            let misses = samples.iter().zip(&frame.depth).filter(|(_, depth)| !depth.is_finite());
            assert!(misses.clone().count() > 500 && misses.clone().all(|(&k, _)| k == 1));
        }
        assert!((sums / f64::from(budget) - 1.0).abs() < 0.02, "{sums} instead of {budget} over all frames");
    }
}

#[test]
fn every_pixel_gets_its_turn() {
    let mut quell = denoiser(SIZE);
    let mut sums = vec![0; (SIZE[0] * SIZE[1]) as usize];
    for i in 0..32 {
        let samples = asked(&mut quell, &frame(SIZE, EYE, EYE, i), 0.5);
        sums.iter_mut().zip(samples).for_each(|(sum, k)| *sum += k);
    }
    // An eighth of a sample each, at least.
    assert!(sums.iter().all(|&sum| sum >= 3), "{:?}", sums.iter().min());
}

#[test]
fn noise_gets_more_samples_than_calm() {
    let mut quell = denoiser(SIZE);
    let mut samples = vec![];
    let mut last = frame(SIZE, EYE, EYE, 0);
    for i in 0..8 {
        last = frame(SIZE, EYE, EYE, i);
        for (i, radiance) in last.radiance.iter_mut().enumerate().filter(|(i, _)| i % SIZE[0] as usize >= 95)
        {
            let [r, g, b] = last.truth[i];
            *radiance = [r, g, b, 1.0];
        }
        samples = asked(&mut quell, &last, 1.0);
    }
    let noisy = mean(&last, &samples, |x, _| x < 80);
    let calm = mean(&last, &samples, |x, _| x > 110);
    assert!(noisy > 3.0 * calm, "{noisy} against {calm}");
    assert!(calm > 0.2, "a quarter goes to all pixels alike: {calm}");
}

#[test]
fn what_was_just_uncovered_gets_more_at_once() {
    let mut quell = denoiser(SIZE);
    for i in 0..12 {
        asked(&mut quell, &frame(SIZE, EYE, EYE, i), 1.0);
    }
    // History of a part is lost: its motion points out of the picture.
    let mut next = frame(SIZE, EYE, EYE, 12);
    let is_lost = |x: u32, y: u32| (60..100).contains(&x) && (70..110).contains(&y);
    for (i, motion) in next.motion.iter_mut().enumerate() {
        if is_lost(i as u32 % SIZE[0], i as u32 / SIZE[0]) {
            *motion = [3.0, 3.0];
        }
    }
    let samples = asked(&mut quell, &next, 1.0);
    let lost = mean(&next, &samples, is_lost);
    let kept = mean(&next, &samples, |x, y| !is_lost(x, y));
    assert!(lost > 3.0 * kept, "{lost} against {kept}");
}

#[test]
fn what_comes_into_view_gets_more_at_once() {
    let mut quell = denoiser(SIZE);
    for i in 0..12 {
        asked(&mut quell, &frame(SIZE, EYE, EYE, i), 1.0);
    }
    // The picture moves to the right, and will once more: its left border will show what was never seen.
    let mut next = frame(SIZE, EYE, EYE, 12);
    next.motion.iter_mut().for_each(|motion| *motion = [-12.0 / SIZE[0] as f32, 0.0]);
    let samples = asked(&mut quell, &next, 1.0);
    let new = mean(&next, &samples, |x, _| x < 12);
    let old = mean(&next, &samples, |x, _| x > 40);
    assert!(new > 2.0 * old, "{new} against {old}");
}

/// Ranks from 0.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    order.into_iter().enumerate().for_each(|(rank, i)| ranks[i] = rank as f64);
    ranks
}

/// Spearman's rank correlation, without ties.
fn rank_correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let squares: f64 = ranks(a).iter().zip(ranks(b)).map(|(a, b)| (a - b).powi(2)).sum();
    1.0 - 6.0 * squares / (n * (n * n - 1.0))
}

#[test]
fn the_expected_error_follows_the_true_one() {
    let luminance = |[r, g, b]: [f32; 3]| f64::from(0.2126 * r + 0.7152 * g + 0.0722 * b);
    let mut quell = denoiser(SIZE);
    let [columns, rows] = SIZE.map(|side| (side / 8) as usize);
    let mut sums = vec![[0.0; 2]; columns * rows]; // expected and true squared errors
    for (i, frame) in walk(SIZE, 20, Vec3::new(0.013, 0.0, -0.01), 7).enumerate() {
        let images = frame.upload();
        let debug = &blank(SIZE, Format::Rgba16Float);
        let inputs =
            images.inputs(frame.camera, HistoryMode::Continue).with_debug((DebugView::OutputError, debug));
        submit(&mut quell, &inputs, &Settings::default());
        if i < 8 {
            continue;
        }
        let (output, expected) = (read_output(&images.output), read_output(debug));
        for p in 0..output.len() {
            let (x, y) = (p % SIZE[0] as usize / 8, p / SIZE[0] as usize / 8);
            if x < columns && y < rows && frame.depth[p].is_finite() {
                let sum = &mut sums[y * columns + x];
                sum[0] += f64::from(expected[p][0]).powi(2);
                sum[1] += (luminance(output[p]) - luminance(frame.truth[p])).powi(2);
            }
        }
    }
    let known: Vec<[f64; 2]> = sums.into_iter().filter(|sum| sum[0] > 0.0).collect();
    let side = |side: usize| known.iter().map(|sum| sum[side]).collect::<Vec<_>>();
    let (expected, truth) = (side(0), side(1));
    let correlation = rank_correlation(&expected, &truth);
    let ratio = expected.iter().sum::<f64>() / truth.iter().sum::<f64>();
    println!("rank correlation {correlation:.2}, expected over true squared error {ratio:.2}");
    assert!(correlation > 0.6, "{correlation}");
    assert!((0.3..3.0).contains(&ratio), "{ratio}");
    // Another order has none.
    let turned: Vec<f64> = truth.iter().rev().copied().collect();
    assert!(rank_correlation(&expected, &turned) < 0.4);
}

#[test]
fn wrong_requests_are_named() {
    let frame = frame(SIZE, EYE, EYE, 1);
    let images = frame.upload();
    let good = images.inputs(frame.camera, HistoryMode::Continue);
    let mut quell = denoiser(SIZE);
    let (view, other) = (&blank(SIZE, Format::R32Uint), &blank(SIZE, Format::Rgba16Float));
    let right = SampleMap::new(view, 1.0).with_dark_level(DARK_LEVEL);
    let cases = [
        (SampleMap::new(other, 1.0), ["`sample_map`", "Rgba16Float", "R32Uint"]),
        (SampleMap::new(&images.id, 1.0), ["`sample_map`", "`surface_id`", "same texture"]),
        (SampleMap::new(view, 0.0), ["sample_map.samples_per_pixel", "0", "1/16 to 64"]),
        (SampleMap::new(view, 65.0), ["sample_map.samples_per_pixel", "65", "1/16 to 64"]),
        (SampleMap::new(view, f32::NAN), ["samples_per_pixel", "NaN", "1/16 to 64"]),
        (right.with_dark_level(0.0), ["sample_map.dark_level", "0", "above 0"]),
        (right.with_dark_level(f32::INFINITY), ["sample_map.dark_level", "inf", "finite"]),
    ];
    let gpu = crate::gpu::gpu();
    let mut refusal = |sample_map| -> Result<_, FrameError> {
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let inputs = good.with_sample_map(sample_map);
        quell.encode(&gpu.device, &gpu.queue, &mut encoder, &inputs, &Settings::default())
    };
    for (map, parts) in cases {
        let message = refusal(map).unwrap_err().to_string();
        assert!(parts.iter().all(|part| message.contains(part)), "{message}");
    }
    assert!(refusal(right).is_ok());
    // It is read before it is written.
    assert!(refusal(SampleMap::new(&images.samples, 1.0)).is_ok());
}
