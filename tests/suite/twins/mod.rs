//! Plain f64 versions of the passes with mathematics in them, written from the formulas, against the GPU.

mod accumulate;
mod compose;
mod fit;
mod innovation;
mod packed;
mod packings;
mod prediction;
mod regression;
mod reproject;
mod sample_map;
mod surface;

use crate::gpu::gpu;
use crate::sequence::Frame;
use bytemuck::Zeroable;
use quell::gpu::{FrameUniforms, Recorder, flags};
use quell::{Centres, Windows, layout};
use rand::{Rng, rngs::StdRng};
use surface::Surface;

/// What a pass works on: all radiance, or what of it left the first hit through the specular lobe.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Signal {
    Combined,
    Specular,
}

/// Uniforms of a frame that follows `previous`.
fn uniforms(frame: &Frame, previous: &Frame) -> FrameUniforms {
    let mut uniforms = FrameUniforms {
        far: f32::INFINITY,
        size: frame.size,
        tiles: layout::tiles(frame.size),
        index: 7,
        motion_scale: [1.0, 1.0],
        max_history: 32.0,
        firefly_limit: f32::INFINITY,
        flags: flags::HISTORY | flags::SURFACE_ID | flags::SAMPLE_COUNT | flags::MIX,
        ..FrameUniforms::zeroed()
    };
    uniforms.set_windows(Windows::RingError, Centres::Adaptive);
    uniforms.set_cameras(&frame.camera, &previous.camera, previous.size);
    uniforms
}

/// Runs one pass on its own.
fn run(uniforms: &FrameUniforms, record: impl FnOnce(&mut Recorder<'_>)) {
    use wgpu::util::DeviceExt;
    let gpu = gpu();
    let buffer = gpu.device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("twin frame"),
        contents: bytemuck::bytes_of(uniforms),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    record(&mut Recorder {
        device: &gpu.device,
        encoder: &mut encoder,
        frame: &buffer,
        profiler: None,
        is_specular: false,
    });
    gpu.queue.submit([encoder.finish()]);
}

/// The guide image of a frame: words for the GPU, and what they mean.
fn guide(frame: &Frame) -> (Vec<[u32; 2]>, Vec<Surface>) {
    let u = uniforms(frame, frame);
    let read = |i| {
        let mut surface = surface::read(frame, f64::INFINITY, i);
        if let Some(&hit) = frame.hit_distance.get(i).filter(|_| !frame.specular.is_empty()) {
            let eye = surface::position_of(&u, &u.current, surface::pixel(&u, i), surface.depth).length();
            surface.cue = if hit > 0.0 { eye / (eye + f64::from(hit)) } else { 0.0 };
        }
        surface::pack(&surface)
    };
    let words: Vec<_> = (0..frame.depth.len()).map(read).collect();
    let surfaces = words.iter().map(|&w| surface::unpack(w)).collect();
    (words, surfaces)
}

/// Random means with sample counts (one in ten without history), as half floats hold them.
fn random_history(random: &mut StdRng, pixels: usize) -> Vec<[half::f16; 4]> {
    let texel = |random: &mut StdRng| {
        let count = if random.random_bool(0.1) { 0.0 } else { random.random_range(1.0..80.0_f32) };
        let colour = random.random_range(0.0..4.0_f32);
        [colour, colour * 0.7, colour * random.random::<f32>(), count].map(half::f16::from_f32)
    };
    (0..pixels).map(|_| texel(random)).collect()
}

/// Samples of a frame with their number: none, one, or many.
fn random_signal(random: &mut StdRng, surfaces: &[Surface]) -> (Vec<u32>, Vec<u32>) {
    let texel = |random: &mut StdRng, surface: &Surface| {
        let samples = if surface.is_miss() { 0 } else { [0, 1, 1, 2, 3, 8, 40][random.random_range(0..7)] };
        let colour = random.random_range(0.0..8.0_f64);
        let word = packed::pack_signal([colour, colour, 0.5 * colour]);
        (if samples == 0 { packed::NO_SAMPLE } else { word }, samples)
    };
    surfaces.iter().map(|surface| texel(random, surface)).unzip()
}

/// Colour and number of samples; 0 for none.
fn unpack_samples(words: &[u32], counts: &[u32]) -> Vec<[f64; 4]> {
    let texel = |(&word, &count): (&u32, &u32)| {
        let [r, g, b] = packed::unpack_signal(word);
        if word == packed::NO_SAMPLE { [0.0; 4] } else { [r, g, b, f64::from(count.min(1024))] }
    };
    words.iter().zip(counts).map(texel).collect()
}

fn rgb(v: &[f64; 4]) -> [f64; 3] {
    [v[0], v[1], v[2]]
}

fn wide(texels: &[[half::f16; 4]]) -> Vec<[f64; 4]> {
    texels.iter().map(|t| t.map(f64::from)).collect()
}

fn luminance(c: [f64; 3]) -> f64 {
    0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]
}

/// Share of values further apart than `relative` of their size (or `absolute`, near 0).
fn mismatches(found: &[f64], expected: &[f64], relative: f64, absolute: f64) -> f64 {
    assert_eq!(found.len(), expected.len());
    let wrong = found.iter().zip(expected).filter(|&(&f, &e)| {
        let close = (f - e).abs() <= absolute + relative * e.abs();
        !close // NaN is never close
    });
    wrong.count() as f64 / found.len() as f64
}

#[test]
fn the_comparison_notices_a_wrong_value_and_a_nan() {
    let right = vec![1.0, 2.0, 3.0, 4.0];
    assert_eq!(mismatches(&right, &right, 1e-6, 0.0), 0.0);
    assert_eq!(mismatches(&[1.0, 2.0, 3.1, 4.0], &right, 1e-3, 0.0), 0.25);
    assert_eq!(mismatches(&[1.0, 2.0, f64::NAN, 4.0], &right, 1e-3, 1e9), 0.25);
}
