//! Short walks through the analytic scene that use all that the library has: every optional image, a restart, a switched light,
//! a budget, two signals.

use crate::gpu::{blank, download, gpu, upload};
use crate::mirror::mirrored;
use crate::sequence::{Light, lit_walk, psnr, read_output, submit};
use glam::Vec3;
use quell::{Budget, Denoiser, DenoiserDescriptor, HistoryMode, Pipelines, SampleMap, Settings};
use std::sync::Arc;
use wgpu::TextureFormat;

pub const SIZE: [u32; 2] = [96, 64];
pub const FRAMES: u32 = 12;
/// The first frame after a cut, and the first in another light.
const CUT: u32 = 5;
const SWITCH: u32 = 9;
/// Light of its own that every pixel has, where it has any.
const EMISSION: [f32; 4] = [0.05, 0.03, 0.02, 0.0];
/// Of the scene's truth, in dB; noisy frames have 15 to 23.
const LEAST_TRUE_PSNR: f64 = 25.0;
const PIXELS: usize = (SIZE[0] * SIZE[1]) as usize;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Walk {
    /// One signal, with emission, where a sample map tells where the next frame gets samples.
    Combined,
    /// One signal with hit distances.
    Reflections,
    /// Two signals, with specular albedo and hit distances, under a budget.
    Split,
    /// [`Walk::Combined`] with other noise; for what has to be told apart.
    OtherNoise,
    /// [`Walk::Combined`] with shorter history; as [`Walk::OtherNoise`].
    OtherSetting,
}

impl Walk {
    pub const COMPARED: [Self; 3] = [Self::Combined, Self::Reflections, Self::Split];
    /// Those first.
    pub const ALL: [Self; 5] =
        [Self::Combined, Self::Reflections, Self::Split, Self::OtherNoise, Self::OtherSetting];
}

/// What a frame came to.
#[derive(Clone)]
pub struct Frame {
    pub output: Vec<[f32; 3]>,
    pub sample_map: Vec<u32>,
}

pub fn render(walk: Walk, pipelines: &Arc<Pipelines>) -> Vec<Frame> {
    let seed = if walk == Walk::OtherNoise { 8 } else { 7 };
    let mut settings = Settings::default();
    match walk {
        Walk::Split => settings.budget = Budget::Models(60),
        Walk::OtherSetting => settings.max_history = 3.0,
        _ => {}
    }
    let light = |i| if i < SWITCH { Light::ON } else { Light::all(0.4) };
    let size = DenoiserDescriptor::new(SIZE[0], SIZE[1]);
    let mut denoiser = Denoiser::with_pipelines(&gpu().device, &size, Arc::clone(pipelines)).unwrap();
    let frames = lit_walk(SIZE, FRAMES, Vec3::new(0.04, 0.01, -0.05), seed, light).enumerate();
    let even = |texel: [f32; 4]| {
        upload(SIZE, TextureFormat::Rgba16Float, &[texel.map(half::f16::from_f32)].repeat(PIXELS))
    };
    frames
        .map(|(i, frame)| {
            let mut frame = match walk {
                Walk::Reflections | Walk::Split => mirrored(&frame, seed + 100 * i as u64),
                _ => frame,
            };
            if walk == Walk::Reflections {
                for (texel, specular) in frame.radiance.iter_mut().zip(frame.specular.drain(..)) {
                    *texel = std::array::from_fn(|channel| texel[channel] + specular[channel]);
                }
            }
            if walk != Walk::Split {
                for (texel, truth) in frame.radiance.iter_mut().zip(&mut frame.truth) {
                    *texel = std::array::from_fn(|channel| texel[channel] + EMISSION[channel]);
                    *truth = std::array::from_fn(|channel| truth[channel] + EMISSION[channel]);
                }
            }
            // Every seventh pixel has no sample.
            frame.samples.iter_mut().step_by(7).for_each(|count| *count = 0);
            let images = frame.upload();
            let emission = even(EMISSION);
            let specular_albedo = even([0.4, 0.5, 0.6, 1.0]);
            let samples = blank(SIZE, TextureFormat::R32Uint);
            let history = if i as u32 == CUT { HistoryMode::Restart } else { HistoryMode::Continue };
            let inputs = images
                .inputs(frame.camera, history)
                .with_emission((walk != Walk::Split).then_some(&emission))
                .with_specular_albedo((walk == Walk::Split).then_some(&specular_albedo))
                .with_sample_map(SampleMap::new(&samples, 0.5));
            submit(&mut denoiser, &inputs, &settings);
            let output = read_output(&images.output);
            // Two drivers that show nothing would agree.
            let found = psnr(&output, &frame.truth);
            assert!(found > LEAST_TRUE_PSNR, "{walk:?}, frame {i}: {found} dB from the truth");
            Frame { output, sample_map: download(&samples) }
        })
        .collect()
}

/// How far two frames are apart.
#[derive(Debug)]
pub struct Difference {
    /// As [`psnr`], in dB.
    pub psnr: f64,
    /// Largest difference of two values, over 1 + the value.
    pub largest: f32,
    /// Part of the pixels whose numbers of samples differ.
    pub sample_counts: f64,
}

pub fn difference(a: &Frame, b: &Frame) -> Difference {
    let largest = a.output.iter().flatten().zip(b.output.iter().flatten());
    let differ = a.sample_map.iter().zip(&b.sample_map).filter(|(a, b)| a != b).count();
    Difference {
        psnr: psnr(&a.output, &b.output),
        largest: largest.map(|(a, b)| (a - b).abs() / (1.0 + a.abs())).fold(0.0, f32::max),
        sample_counts: differ as f64 / PIXELS as f64,
    }
}

/// Frames as bytes, and back, one walk after the other.
pub fn pack(frames: &[Frame]) -> Vec<u8> {
    let frame = |frame: &Frame| {
        [bytemuck::cast_slice::<_, u8>(&frame.output), bytemuck::cast_slice(&frame.sample_map)].concat()
    };
    frames.iter().flat_map(frame).collect()
}

pub fn unpack(bytes: &[u8]) -> Vec<Vec<Frame>> {
    let output = PIXELS * size_of::<[f32; 3]>();
    let frame = |bytes: &[u8]| Frame {
        output: bytemuck::pod_collect_to_vec(&bytes[..output]),
        sample_map: bytemuck::pod_collect_to_vec(&bytes[output..]),
    };
    let frames = bytes.chunks_exact(output + PIXELS * size_of::<u32>());
    let mut frames = frames.map(frame);
    let walk = |_| Some(frames.by_ref().take(FRAMES as usize).collect::<Vec<_>>());
    let walks: Vec<_> = Walk::ALL.into_iter().map_while(walk).filter(|walk| !walk.is_empty()).collect();
    assert!(walks.len() >= Walk::COMPARED.len() && walks.iter().all(|walk| walk.len() == FRAMES as usize));
    walks
}
