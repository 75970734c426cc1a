//! `accumulate` against its f64 twin.

use super::surface::{position_of, same_surface};
use super::{guide, luminance, mismatches, random_history, random_noise, random_signal, run, uniforms, wide};
use crate::gpu::{blank, download, gpu, upload, upload_buffer};
use crate::sequence::frame;
use glam::{DVec2, Vec3};
use quell::gpu::FrameUniforms;
use quell::passes::accumulate::{Accumulate, AccumulateViews};
use rand::{SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

const SIZE: [u32; 2] = [61, 47];

fn rgb(v: &[f64; 4]) -> [f64; 3] {
    [v[0], v[1], v[2]]
}

/// Mean and variance.
fn spatial_spread(u: &FrameUniforms, i: usize, signal: &[[f64; 4]], surfaces: &[super::Surface]) -> [f64; 2] {
    let [width, height] = u.size.map(i64::from);
    let (x, y) = (i as i64 % width, i as i64 / width);
    let position = |x: i64, y: i64, depth| position_of(u, &u.current, DVec2::new(x as f64, y as f64), depth);
    let mut values = vec![];
    let mut samples = 0.0;
    for ty in (y - 3).max(0)..=(y + 3).min(height - 1) {
        for tx in (x - 3).max(0)..=(x + 3).min(width - 1) {
            let t = (ty * width + tx) as usize;
            let offset = position(tx, ty, surfaces[t].depth) - position(x, y, surfaces[i].depth);
            if signal[t][3] > 0.0 && same_surface(&surfaces[i], &surfaces[t], offset) {
                values.push(luminance(rgb(&signal[t])));
                samples += signal[t][3];
            }
        }
    }
    if values.len() < 2 {
        return [0.0, luminance(rgb(&signal[i])).powi(2) * signal[i][3]];
    }
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let spread = values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (n - 1.0);
    [mean, spread * samples / n]
}

#[test]
fn matches_its_twin_on_random_history() {
    let mut random = StdRng::seed_from_u64(11);
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let frame = frame(SIZE, eye, eye, 1);
    let u = uniforms(&frame, &frame);
    let (words, surfaces) = guide(&frame);
    let old = random_history(&mut random, surfaces.len());
    let old_noise = random_noise(&mut random, surfaces.len());
    let signal = random_signal(&mut random, &surfaces);
    let (history, noise) = (blank(SIZE, Format::Rgba16Float), blank(SIZE, Format::Rg32Float));
    let pass = Accumulate::new(&gpu().device);
    run(&u, |recorder| {
        let views = AccumulateViews {
            signal: &upload(SIZE, Format::Rgba16Float, &signal),
            guide: &upload(SIZE, Format::Rgba32Uint, &words),
            reprojected: &upload(SIZE, Format::Rgba16Float, &old),
            reprojected_noise: &upload(SIZE, Format::Rg32Float, &old_noise),
            innovations: &upload_buffer(&[0.0; 4]),
            history: &history,
            noise: &noise,
        };
        pass.record(recorder, &views, SIZE);
    });
    let found = wide(&download(&history));
    let found_noise: Vec<f64> = download::<f32>(&noise).into_iter().map(f64::from).collect();

    let (signal, old) = (wide(&signal), wide(&old));
    let (mut expected, mut expected_noise) = (vec![], vec![]);
    for i in 0..signal.len() {
        let k = signal[i][3];
        let [v, e] = old_noise[i].map(f64::from);
        if k == 0.0 {
            expected.push(old[i]);
            expected_noise.extend([v, e]);
            continue;
        }
        let n = old[i][3].min((32.0 - k).max(0.0)) + k;
        let alpha = k / n;
        let mean: Vec<f64> = (0..3).map(|c| old[i][c] + alpha * (signal[i][c] - old[i][c])).collect();
        expected.push([mean[0], mean[1], mean[2], n]);
        let d = luminance(rgb(&signal[i])) - luminance(rgb(&old[i]));
        let [mean, spread] = spatial_spread(&u, i, &signal, &surfaces);
        let first = alpha == 1.0;
        let innovation = if first { luminance(rgb(&signal[i])) - mean } else { (1.0 - alpha).sqrt() * d };
        let v = if first || n < 4.0 { spread } else { (1.0 - alpha) * (v + alpha * k * d * d) };
        expected_noise.extend([v, alpha * innovation - (1.0 - alpha) * e]);
    }
    // One dithered step of a half float.
    let step = 2.0_f64.powi(-10);
    let wrong = mismatches(found.as_flattened(), expected.as_flattened(), step, 1e-6);
    assert_eq!(wrong, 0.0);
    // A neighbour on the threshold of a surface test may fall to either side.
    let wrong = mismatches(&found_noise, &expected_noise, 1e-4, 1e-6);
    assert!(wrong <= 0.005, "{wrong}");
    // The comparator notices a sample that entered with the wrong weight.
    expected.iter_mut().for_each(|h| h[3] += 1.0);
    assert!(mismatches(found.as_flattened(), expected.as_flattened(), step, 1e-6) > 0.2);
}
