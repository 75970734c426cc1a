//! Broken values in every input, one at a time and all at once: nothing broken comes out, and nothing stays.

use crate::gpu::{blank, download, gpu};
use crate::pool::{Content, image};
use glam::{Mat4, camera::rh::proj::directx};
use half::f16;
use quell::{Camera, Denoiser, DenoiserDescriptor, FrameInputs, HistoryMode, RequiredInputs, Settings};
use rand::{SeedableRng, rngs::StdRng};
use wgpu::{TextureFormat as Format, TextureView};

const SIZE: [u32; 2] = [40, 24];
/// Name and format; floats, because the bits of others are numbers whatever they are.
const INPUTS: [(&str, Format); 11] = [
    ("radiance", Format::Rgba32Float),
    ("albedo", Format::Rgba16Float),
    ("normal_roughness", Format::Rgba32Float),
    ("depth", Format::R32Float),
    ("motion", Format::Rgba32Float),
    ("roughness", Format::R32Float),
    ("emission", Format::Rgba32Float),
    ("specular", Format::Rgba32Float),
    ("specular_albedo", Format::Rgba16Float),
    ("hit_distance", Format::R32Float),
    ("surface_id", Format::R32Uint),
];

/// An image of each input.
struct Images(Vec<TextureView>);

impl Images {
    /// `hostile` tells which have broken content.
    fn new(content: Content, hostile: impl Fn(usize) -> bool, seed: u64) -> Self {
        let mut random = StdRng::seed_from_u64(seed);
        let of = |(i, &(_, format)): (usize, &(&str, Format))| {
            image(SIZE, format, if hostile(i) { content } else { Content::Sane }, &mut random)
        };
        Self(INPUTS.iter().enumerate().map(of).collect())
    }

    fn denoise(&self, quell: &mut Denoiser, is_split: bool, history: HistoryMode) -> Vec<[f16; 4]> {
        let [
            radiance,
            albedo,
            normal_roughness,
            depth,
            motion,
            roughness,
            emission,
            specular,
            specular_albedo,
            hit_distance,
            surface_id,
        ] = std::array::from_fn(|i| &self.0[i]);
        let output = blank(SIZE, Format::Rgba16Float);
        let camera = Camera::new(Mat4::IDENTITY, directx::perspective(1.0, 1.5, 0.1, 100.0));
        let required =
            RequiredInputs { radiance, albedo, normal_roughness, depth, motion, output: &output, camera };
        let inputs = FrameInputs::new(required)
            .with_history(history)
            .with_roughness(roughness)
            .with_emission(emission)
            .with_surface_id(surface_id)
            .with_hit_distance(hit_distance)
            .with_specular(is_split.then_some(specular))
            .with_specular_albedo(is_split.then_some(specular_albedo));
        let gpu = gpu();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        quell.encode(&gpu.device, &gpu.queue, &mut encoder, &inputs, &Settings::default()).unwrap();
        gpu.queue.submit([encoder.finish()]);
        download(&output)
    }
}

fn assert_sound(output: &[[f16; 4]], what: &str) {
    let is_sound = |texel: &[f16; 4]| texel.iter().all(|v| v.is_finite() && *v >= f16::ZERO);
    assert!(output.iter().all(is_sound), "broken pixels: {what}");
}

/// One frame's worth of numbers after a restart, which must not depend on what was before. Dithering does, by half a per cent.
fn assert_alike(a: &[[f16; 4]], b: &[[f16; 4]], what: &str) {
    let sums = [a, b].map(|image| image.iter().flatten().map(|v| f64::from(v.to_f32())).sum::<f64>());
    let differences =
        a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| f64::from(a.to_f32() - b.to_f32()).abs());
    let share = differences.sum::<f64>() / sums[1];
    assert!(share < 0.02, "{what} left traces: off by {:.1} %", 100.0 * share);
}

fn check(is_split: bool) {
    let [width, height] = SIZE;
    let pipelines = std::sync::Arc::new(quell::Pipelines::new(&gpu().device).unwrap());
    let denoiser = || {
        let descriptor = DenoiserDescriptor::new(width, height);
        Denoiser::with_pipelines(&gpu().device, &descriptor, pipelines.clone()).unwrap()
    };
    let sane = Images::new(Content::Sane, |_| false, 1);
    let fresh = sane.denoise(&mut denoiser(), is_split, HistoryMode::Restart);
    for content in Content::HOSTILE {
        for which in 0..=INPUTS.len() {
            let name = INPUTS.get(which).map_or("all", |&(name, _)| name);
            let what = format!("{content:?} in {name}, split {is_split}");
            let hostile = Images::new(content, |i| i == which || which == INPUTS.len(), 2);
            let mut quell = denoiser();
            for images in [&sane, &hostile, &hostile, &sane] {
                assert_sound(&images.denoise(&mut quell, is_split, HistoryMode::Continue), &what);
            }
            assert_alike(&sane.denoise(&mut quell, is_split, HistoryMode::Restart), &fresh, &what);
        }
    }
}

#[test]
fn hostile_values_in_one_signal() {
    check(false);
}

#[test]
fn hostile_values_in_two_signals() {
    check(true);
}
