//! Frames whose specular radiance came apart, and hit distances: mirrors under motion, broken and missing parts.

use crate::gpu::blank;
use crate::mirror::mirrored;
use crate::sequence::{Frame, denoise, denoiser, frame, psnr, read_output, submit, walk};
use glam::Vec3;
use quell::{DebugView, HistoryMode, SampleMap, Settings};
use rand::{Rng, SeedableRng, rngs::StdRng};
use wgpu::TextureFormat as Format;

const SIZE: [u32; 2] = [128, 96];
const EYE: Vec3 = Vec3::new(0.0, 1.4, 1.0);
const STEP: Vec3 = Vec3::new(0.02, 0.01, 0.0);

/// A walk in which every surface is a mirror as well, of this roughness.
fn mirrors(frames: u32, roughness: f32) -> Vec<Frame> {
    let polished = |(i, mut frame): (usize, Frame)| {
        frame.normal.iter_mut().for_each(|normal| normal[3] = roughness);
        mirrored(&frame, i as u64 + 100)
    };
    walk(SIZE, frames, STEP, 5).enumerate().map(polished).collect()
}

/// The same samples as one signal.
fn combined(frame: &Frame) -> Frame {
    let mut combined = Frame { specular: vec![], ..frame.clone() };
    for (sum, specular) in combined.radiance.iter_mut().zip(&frame.specular) {
        (0..3).for_each(|c| sum[c] += specular[c]);
    }
    combined
}

/// Mean PSNR over all frames from the tenth.
fn quality(frames: &[Frame]) -> f64 {
    let mut quell = denoiser(SIZE);
    let psnrs: Vec<f64> = frames
        .iter()
        .map(|frame| psnr(&denoise(&mut quell, frame, &Settings::default()), &frame.truth))
        .collect();
    psnrs[10..].iter().sum::<f64>() / (psnrs.len() - 10) as f64
}

fn assert_sound(output: &[[f32; 3]]) {
    assert!(output.iter().flatten().all(|v| v.is_finite() && *v >= 0.0), "NaN, infinite or negative output");
}

#[test]
fn what_a_mirror_shows_is_followed() {
    let frames = mirrors(18, 0.03);
    let without = |change: fn(&Frame) -> Frame| frames.iter().map(change).collect::<Vec<_>>();
    let blind = without(|frame| Frame { hit_distance: vec![], ..frame.clone() });
    let one = without(|frame| Frame { hit_distance: vec![], ..combined(frame) });
    let [followed, blind, one] = [&frames, &blind, &one].map(|frames| quality(frames));
    println!("{followed:.2} dB; without hit distances {blind:.2} dB; one signal {one:.2} dB");
    assert!(followed > blind + 1.0 && followed > one + 1.5, "{followed:.2} {blind:.2} {one:.2}");
}

/// Of one signal the samples tell which of its histories is right: of nothing but a mirror that of what is seen in it.
#[test]
fn what_a_mirror_shows_is_followed_in_one_signal() {
    let only_mirror = |frame: &Frame| {
        // Without noise, so that only history can blur what moves.
        let radiance = frame.mirror_truth.iter().map(|&[r, g, b]| [r, g, b, 1.0]).collect();
        let albedo = vec![[0.5; 4]; frame.albedo.len()];
        Frame { radiance, albedo, truth: frame.mirror_truth.clone(), specular: vec![], ..frame.clone() }
    };
    let told: Vec<Frame> = mirrors(12, 0.03).iter().map(only_mirror).collect();
    let blind: Vec<Frame> =
        told.iter().map(|frame| Frame { hit_distance: vec![], ..frame.clone() }).collect();
    let [told, blind] = [told, blind].map(|frames| share_with_history(&frames, &Settings::default()));
    println!("{told:.2} of the pixels have history; without hit distances {blind:.2}");
    assert!(told > 0.4 && blind < 0.1, "{told:.2} {blind:.2}");
}

/// Share of the pixels whose history is at least six frames long, after all frames.
fn share_with_history(frames: &[Frame], settings: &Settings) -> f64 {
    let mut quell = denoiser(SIZE);
    let lengths = blank(SIZE, Format::Rgba16Float);
    let settings = settings.with_max_history(12.0).with_innovation(false);
    for frame in frames {
        let images = frame.upload();
        let debug = Some((DebugView::HistoryLength, &lengths));
        let inputs = images.inputs(frame.camera, HistoryMode::Continue).with_debug(debug);
        submit(&mut quell, &inputs, &settings);
    }
    let hits = frames.last().unwrap().depth.iter().map(|depth| depth.is_finite());
    let lengths: Vec<f32> = read_output(&lengths)
        .iter()
        .zip(hits)
        .filter(|(_, is_hit)| *is_hit)
        .map(|(length, _)| length[1])
        .collect();
    lengths.iter().filter(|&&length| length >= 0.5).count() as f64 / lengths.len() as f64
}

#[test]
fn broken_hit_distances_are_as_good_as_none() {
    let frames = mirrors(12, 0.2);
    for frames in [frames.clone(), frames.iter().map(combined).collect()] {
        let told = |distance: f32| {
            let set =
                |frame: &Frame| Frame { hit_distance: vec![distance; frame.depth.len()], ..frame.clone() };
            quality(&frames.iter().map(set).collect::<Vec<_>>())
        };
        let unknown = told(0.0);
        for distance in [f32::NAN, -1.0, f32::NEG_INFINITY] {
            let found = told(distance);
            assert!((found - unknown).abs() < 0.01, "{distance}: {found:.2} dB, unknown {unknown:.2} dB");
        }
        // Wrong ones may harm, but not more than to lose all history would.
        for distance in [1e-30, 1.0, f32::MAX, f32::INFINITY] {
            let found = told(distance);
            println!("{distance}: {found:.2} dB, unknown {unknown:.2} dB");
            assert!(found > unknown - 1.0, "{distance}: {found:.2} dB, unknown {unknown:.2} dB");
        }
    }
}

#[test]
fn broken_specular_radiance_is_repaired_and_forgotten() {
    let frames = mirrors(16, 0.1);
    let mut broken = frames[0].clone();
    let bad = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -5.0, f32::MAX];
    for (i, pixel) in broken.specular.iter_mut().enumerate().filter(|(i, _)| i % 3 == 0) {
        pixel[i % 3] = bad[i / 3 % bad.len()];
    }
    let mut quell = denoiser(SIZE);
    assert_sound(&denoise(&mut quell, &broken, &Settings::default()));
    let mut last = vec![];
    for frame in &frames[1..] {
        last = denoise(&mut quell, frame, &Settings::default());
        assert_sound(&last);
    }
    let after = psnr(&last, &frames[15].truth);
    assert!(after > 20.0, "history is poisoned: {after:.1} dB");
}

#[test]
fn either_part_may_be_black() {
    let frame = frame(SIZE, EYE, EYE, 1);
    let black = vec![[0.0, 0.0, 0.0, 1.0]; frame.depth.len()];
    let only_rest = Frame { specular: black.clone(), ..frame.clone() };
    let output = denoise(&mut denoiser(SIZE), &only_rest, &Settings::default());
    assert_sound(&output);
    assert!(psnr(&output, &frame.truth) > 25.0);
    let mirror = mirrored(&frame, 2);
    let only_specular = Frame { radiance: black, ..mirror };
    let output = denoise(&mut denoiser(SIZE), &only_specular, &Settings::default());
    assert_sound(&output);
    assert!(psnr(&output, &only_specular.mirror_truth) > 20.0);
}

/// Histories of one signal and of two mean different things.
#[test]
fn history_restarts_where_a_split_comes_or_goes() {
    let split = mirrored(&frame(SIZE, EYE, EYE, 1), 2);
    let mut quell = denoiser(SIZE);
    let held = quell.memory().allocations().count();
    let mut restarted = |frame: &Frame| {
        let images = frame.upload();
        let gpu = crate::gpu::gpu();
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        let inputs = images.inputs(frame.camera, HistoryMode::Continue);
        let outputs =
            quell.encode(&gpu.device, &gpu.queue, &mut encoder, &inputs, &Settings::default()).unwrap();
        gpu.queue.submit([encoder.finish()]);
        outputs.restarted
    };
    let one = combined(&split);
    let found = [&one, &one, &split, &split, &one, &split].map(&mut restarted);
    assert_eq!(found, [true, false, true, false, true, true]);
    let grown = quell.memory().allocations().count();
    assert!(grown > held);
    denoise(&mut quell, &split, &Settings::default());
    assert_eq!(quell.memory().allocations().count(), grown);
}

#[test]
fn debug_views_and_sample_maps_work_on_a_split() {
    let split = mirrored(&frame(SIZE, EYE, EYE, 1), 2);
    let mut quell = denoiser(SIZE);
    let debug = blank(SIZE, Format::Rgba16Float);
    let samples = blank(SIZE, Format::R32Uint);
    let images = split.upload();
    for view in DebugView::ALL {
        let shown = [false, true].map(|debug_specular| {
            let inputs = images
                .inputs(split.camera, HistoryMode::Restart)
                .with_debug((view, &debug))
                .with_sample_map(SampleMap::new(&samples, 1.0));
            submit(&mut quell, &inputs, &Settings::default().with_debug_specular(debug_specular));
            let shown = read_output(&debug);
            assert_sound(&shown);
            shown
        });
        // What one signal is like is not what the other is.
        if [DebugView::TemporalMean, DebugView::Prediction].contains(&view) {
            assert_ne!(shown[0], shown[1], "{view:?}");
        }
    }
    let wanted: Vec<u32> = crate::gpu::download(&samples);
    let mean = wanted.iter().sum::<u32>() as f32 / wanted.len() as f32;
    assert!((0.5..1.5).contains(&mean), "{mean} samples a pixel");
}

#[test]
fn an_albedo_without_its_signal_is_refused() {
    let frame = frame(SIZE, EYE, EYE, 1);
    let images = frame.upload();
    let inputs = images.inputs(frame.camera, HistoryMode::Continue).with_specular_albedo(&images.albedo);
    let gpu = crate::gpu::gpu();
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let refused = denoiser(SIZE).encode(&gpu.device, &gpu.queue, &mut encoder, &inputs, &Settings::default());
    let message = refused.unwrap_err().to_string();
    for part in ["specular_albedo", "`specular`"] {
        assert!(message.contains(part), "{message}");
    }
}

/// Where the specular lobe was not sampled, its neighbours or the past know the distance: history goes on.
#[test]
fn distances_that_are_seldom_known_keep_history() {
    let frames = mirrors(14, 0.15);
    let mut random = StdRng::seed_from_u64(9);
    let mut unknown = frames.clone();
    for frame in &mut unknown {
        frame
            .hit_distance
            .iter_mut()
            .filter(|_| random.random_bool(0.9))
            .for_each(|distance| *distance = 0.0);
    }
    let settings = Settings::default().with_debug_specular(true);
    let [known, seldom] = [frames, unknown].map(|frames| share_with_history(&frames, &settings));
    println!("{known:.2} of the pixels have history; with one distance in ten {seldom:.2}");
    assert!(known > 0.8 && seldom > known - 0.1, "{known:.2} {seldom:.2}");
}

/// Glossy surfaces forget as their view turns: not at all where it does not.
#[test]
fn a_still_view_of_a_mirror_forgets_nothing() {
    let still = |seed| {
        let mut frame = frame(SIZE, EYE, EYE, seed);
        frame.normal.iter_mut().for_each(|normal| normal[3] = 0.0);
        frame
    };
    let frames: Vec<Frame> = (0..12).map(still).collect();
    let share = share_with_history(&frames, &Settings::default());
    assert!(share > 0.99, "{share:.2}");
}
