//! `sample_map` against its f64 twin.

use super::{guide, mismatches, random_history, uniforms, wide};
use crate::gpu::{blank, download, gpu, upload};
use crate::sequence::frame;
use glam::Vec3;
use quell::gpu::words;
use quell::layout::SAMPLE_BUCKETS;
use quell::passes::sample_map::{SampleMap, SampleMapViews};
use rand::{Rng, SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

const SIZE: [u32; 2] = [61, 43];
const DARK_LEVEL: f64 = 0.1;

/// Gains are told apart by eighths of an octave, from 2^-40 on.
fn in_steps(gain: f64) -> f64 {
    let step = ((gain.log2() + 40.0) * 8.0).floor().clamp(0.0, SAMPLE_BUCKETS as f64 - 1.0);
    ((step + 0.5) / 8.0 - 40.0).exp2()
}

#[test]
fn matches_its_twin_on_random_images() {
    let mut random = StdRng::seed_from_u64(61);
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let frame = frame(SIZE, eye, eye, 1);
    let (words_of_guide, surfaces) = guide(&frame);
    let history = random_history(&mut random, surfaces.len());
    let errors: Vec<[half::f16; 2]> = (0..surfaces.len())
        .map(|_| [random.random_range(0.0..2.0_f32), random.random_range(0.0..4.0_f32)])
        .map(|[deviation, luminance]| [deviation * deviation, luminance].map(half::f16::from_f32))
        .collect();
    // In pixels, of which it is rounded to whole ones; some point out of the picture, some are broken.
    let motion: Vec<[f32; 2]> = (0..surfaces.len())
        .map(|_| match random.random_range(0..12) {
            0 => [f32::NAN, 1.0],
            1 => [0.0, f32::INFINITY],
            _ => [0; 2].map(|_| f32::from(random.random_range(-9..=9_i8)) + 0.25),
        })
        .collect();
    let uv_motion: Vec<[f32; 2]> =
        motion.iter().map(|m| [m[0] / SIZE[0] as f32, m[1] / SIZE[1] as f32]).collect();

    let pass = SampleMap::new(&gpu().device);
    for budget in [0.25, 1.0, 5.0] {
        let mut u = uniforms(&frame, &frame);
        (u.sample_budget, u.dark_level) = (budget, DARK_LEVEL as f32);
        let samples = blank(SIZE, Format::R32Uint);
        let views = SampleMapViews {
            guide: &upload(SIZE, Format::Rg32Uint, &words_of_guide),
            motion: &upload(SIZE, Format::Rg32Float, &uv_motion),
            history: &upload(SIZE, Format::Rgba16Float, &history),
            error: &upload(SIZE, Format::R32Uint, &errors),
            sample_histogram: &words(
                &gpu().device,
                "histogram",
                SAMPLE_BUCKETS + 1,
                wgpu::BufferUsages::empty(),
            ),
            samples: &samples,
        };
        super::run(&u, |recorder| pass.record(recorder, &views, SIZE));
        let found: Vec<f64> = download::<u32>(&samples).into_iter().map(f64::from).collect();

        let [width, height] = SIZE.map(f64::from);
        let wide_history = wide(&history);
        let gain = |i: usize| -> Option<f64> {
            let mut place = [(i % SIZE[0] as usize) as f64, (i / SIZE[0] as usize) as f64];
            if motion[i].iter().all(|m| m.is_finite()) {
                [0, 1].into_iter().for_each(|axis| place[axis] += f64::from(motion[i][axis]).round());
            }
            let seen = [place[0].clamp(0.0, width - 1.0), place[1].clamp(0.0, height - 1.0)];
            let source = seen[1] as usize * SIZE[0] as usize + seen[0] as usize;
            if surfaces[source].is_miss() {
                return None;
            }
            let count = if seen == place { wide_history[source][3] } else { 0.0 };
            let [deviation, luminance] = errors[source].map(|part| part.to_f64());
            let relative = deviation.powi(2) / (luminance.powi(2) + DARK_LEVEL.powi(2));
            Some(in_steps((relative / (count + 1.0)).sqrt()))
        };
        let gains: Vec<Option<f64>> = (0..surfaces.len()).map(gain).collect();
        let budget = f64::from(budget);
        // A quarter for all alike, four times the budget or two at most.
        let expected = |gain: f64, rate: f64| (0.25 * budget + rate * gain).min((4.0 * budget).max(2.0));
        let known: Vec<f64> = gains.iter().copied().flatten().collect();
        let mean =
            |rate: f64| known.iter().map(|&gain| expected(gain, rate)).sum::<f64>() / known.len() as f64;
        let (mut low, mut high) = (0.0, 1e9);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if mean(middle) > budget { high = middle } else { low = middle }
        }
        let twin = |shift: f64| -> Vec<f64> {
            let sample = |(i, gain): (usize, &Option<f64>)| {
                let (x, y) = ((i % SIZE[0] as usize) as f64, (i / SIZE[0] as usize) as f64);
                let threshold = 0.7548776662 * x + 0.5698402910 * y + 0.6180339887 * f64::from(u.index);
                gain.map_or(1.0, |gain| (expected(gain, low) + (threshold + shift).fract()).floor())
            };
            gains.iter().enumerate().map(sample).collect()
        };
        // Where a number is all but whole, it may fall to either side.
        assert!(mismatches(&found, &twin(0.0), 0.0, 0.0) <= 0.01);
        // The comparator notices another order of turns.
        assert!(mismatches(&found, &twin(0.5), 0.0, 0.0) > 0.1);
    }
}
