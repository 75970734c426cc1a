//! What `compose` predicts against its f64 twin.

use super::packed::{Prediction, RELATIVE_NOISE_STEPS};
use super::regression::{HEAD, Model, ROW};
use super::surface::{Surface, features};
use super::{Signal, guide, mismatches, run, uniforms};
use crate::gpu::{blank, download, gpu, upload, upload_buffer, upload_words};
use crate::mirror::mirrored;
use crate::sequence::frame;
use glam::Vec3;
use quell::gpu::{FrameUniforms, flags};
use quell::layout::{self, MODEL_STRIDE, MODELS};
use quell::passes::compose::{Compose, ComposeViews};
use rand::{Rng, SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

const SIZE: [u32; 2] = [122, 86];
const N: usize = MODELS.columns() as usize;
const STRIDE: usize = MODEL_STRIDE as usize;
/// Half a window's width, by window from 1.
const REACHES: [f64; 4] = [0.0, 12.0, 12.0, 20.0];

/// The models of a frame, and their windows, as they lie in memory.
pub struct Models {
    pub models: Vec<f32>,
    pub windows: Vec<u32>,
    tiles: [u32; 2],
}

impl Models {
    /// Half the tiles have no model; the left third of the image has none at all.
    pub fn random(random: &mut StdRng, size: [u32; 2]) -> Self {
        let [columns, rows] = layout::tiles(size);
        let models = (0..columns * rows)
            .flat_map(|_| {
                let mut model: Vec<f32> = (0..STRIDE).map(|_| random.random_range(-0.1..0.1)).collect();
                model[0] = if random.random_bool(0.2) { 0.0 } else { random.random_range(0.01..1.0) };
                model[1] = random.random_range(0.1..1.0);
                model[2] = random.random_range(0.1..5.0);
                // Slopes per pixel as small as they are in an image.
                (0..3).for_each(|c| {
                    model[HEAD + ROW * c] = random.random_range(0.5..2.0);
                    model[HEAD + ROW * c + 10..][..2].iter_mut().for_each(|slope| *slope *= 0.01);
                });
                model
            })
            .collect();
        let windows = (0..columns * rows).map(|tile| {
            let none = tile % columns < columns / 3 || random.random_bool(0.5);
            if none { 0 } else { random.random_range(1..=3) }
        });
        Self { windows: windows.collect(), models, tiles: [columns, rows] }
    }

    pub fn predict(&self, u: &FrameUniforms, signal: Signal, surfaces: &[Surface]) -> Vec<Prediction> {
        let of = |(i, surface): (usize, &Surface)| self.predict_pixel(u, signal, i, surface);
        surfaces.iter().enumerate().map(of).collect()
    }

    fn predict_pixel(&self, u: &FrameUniforms, signal: Signal, i: usize, surface: &Surface) -> Prediction {
        if surface.is_miss() {
            return Prediction::NONE;
        }
        let z = features(u, signal, i, surface);
        let (x, y) = ((i as u32 % u.size[0]) as f64 + 0.5, (i as u32 / u.size[0]) as f64 + 0.5);
        let (mut sum, mut gain, mut relative_noise, mut total) = ([0.0; 3], 0.0, 0.0, 0.0);
        // Every model of the image: those that do not reach the pixel have weight 0.
        for (tile, model) in self.models.chunks(STRIDE).enumerate() {
            if self.windows[tile] == 0 || model[0] <= 0.0 {
                continue;
            }
            let reach = REACHES[self.windows[tile] as usize];
            let (column, row) = (tile as u32 % self.tiles[0], tile as u32 / self.tiles[0]);
            let (cx, cy) = (f64::from(column * 8 + 4), f64::from(row * 8 + 4));
            let tent = (1.0 - (x - cx).abs() / reach).max(0.0) * (1.0 - (y - cy).abs() / reach).max(0.0);
            let weight = tent * f64::from(model[0]);
            let value = Model::<N>::stored(model).value(&z);
            (0..3).for_each(|c| sum[c] += weight * value[c]);
            gain += weight * f64::from(model[1]);
            relative_noise += weight * f64::from(model[2]);
            total += weight;
        }
        if total == 0.0 {
            return Prediction::NONE;
        }
        Prediction {
            signal: sum.map(|s| (s / total).max(0.0)),
            noise_gain: gain / total,
            relative_noise: relative_noise / total,
        }
    }
}

/// The pass shows its predictions where there is a debug view.
fn check(signal: Signal) {
    let mut random = StdRng::seed_from_u64(41);
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let mut frame = frame(SIZE, eye, eye, 1);
    if signal == Signal::Specular {
        frame = mirrored(&frame, 2);
    }
    let mut u = uniforms(&frame, &frame);
    u.flags |= flags::DEBUG;
    u.index = 32; // the grid of workgroups begins outside of the frame, in x and in y
    let (words, surfaces) = guide(&frame);
    let models = Models::random(&mut random, SIZE);
    let [float, output] = [(); 2].map(|()| blank(SIZE, Format::Rgba16Float));
    let [noise, error, mix_weight] = [(); 3].map(|()| blank(SIZE, Format::R32Uint));
    let prediction = blank(SIZE, Format::Rg32Uint);
    let device = &gpu().device;
    let pass = match signal {
        Signal::Combined => Compose::new(device),
        Signal::Specular => Compose::specular(device),
    };
    run(&u, |recorder| {
        let views = ComposeViews {
            guide: &upload(SIZE, Format::Rg32Uint, &words),
            models: &upload_buffer(&models.models),
            windows: &upload_words(&models.windows),
            history: &float,
            noise: &noise,
            albedo: &float,
            emission: &float,
            rest: &float,
            output: &output,
            error: &error,
            prediction: &prediction,
            mix_weight: &mix_weight,
        };
        pass.record(recorder, &views, SIZE);
    });
    // Signal, noise gain, and the relative noise's logarithm in steps: -1e9 where no model reaches.
    let steps = |noise: f64| if noise >= 0.0 { noise.log2() * RELATIVE_NOISE_STEPS } else { -1e9 };
    let flat =
        |p: &Prediction| [p.signal[0], p.signal[1], p.signal[2], p.noise_gain, steps(p.relative_noise)];
    let found = download::<[u32; 2]>(&prediction).into_iter().map(|words| flat(&Prediction::unpack(words)));
    let found: Vec<[f64; 5]> = found.collect();
    let predicted = models.predict(&u, signal, &surfaces);
    let alone = predicted.iter().zip(&surfaces).filter(|(p, s)| !p.is_known() && !s.is_miss()).count();
    assert!(alone > 100, "no pixel is out of all models' reach");
    let mut expected: Vec<_> = predicted.iter().map(flat).collect();
    // By kind: half floats round to 2^-11, and values cancel to no less than 1e-3 of the largest; half a step of 8 bits.
    let wrong = |expected: &[[f64; 5]]| {
        let of = |range: std::ops::Range<usize>, relative, absolute| {
            let flat = |texels: &[[f64; 5]]| -> Vec<f64> {
                texels.iter().flat_map(|texel| texel[range.clone()].to_vec()).collect()
            };
            mismatches(&flat(&found), &flat(expected), relative, absolute)
        };
        [of(0..3, 2.0_f64.powi(-10), 1e-3), of(3..4, 0.0, 0.501 / 255.0), of(4..5, 0.0, 0.501)]
    };
    assert_eq!(wrong(&expected), [0.0; 3]);
    expected.iter_mut().for_each(|p| (p[1], p[3], p[4]) = (p[1] + 0.05, p[3] + 0.01, p[4] + 1.0));
    assert!(wrong(&expected).iter().all(|&share| share > 0.1), "{:?}", wrong(&expected));
}

#[test]
fn matches_its_twin_for_random_windows() {
    check(Signal::Combined);
}

#[test]
fn matches_its_twin_for_random_windows_on_mirrors() {
    check(Signal::Specular);
}
