//! `reproject` against its f64 twin: history here, what it packs and what it sums in its submodules.

mod change;
mod history;
mod inputs;
mod reflection;

use super::packed::{Noise, compare_noise, half_drift, random_noise, unpack_noises};
use super::{Surface, guide, mismatches, random_history, run, uniforms, wide};
use crate::gpu::{blank, download, download_buffer, gpu, upload, upload_buffer};
use crate::sequence::{Frame, frame, jittered_frame};
use glam::{Vec2, Vec3};
use half::f16;
use history::{Previous, fetch, find_origin};
use quell::gpu::{FrameUniforms, REFLECTIONS, SPECULAR, flags};
use quell::layout::{self, INNOVATIONS};
use quell::passes::reproject::{Reproject, ReprojectViews};
use rand::{Rng, SeedableRng, rngs::StdRng};
use reflection::{fetch_signal, tile_of};
use wgpu::TextureFormat as Format;

/// What the pass read and wrote.
struct Ran {
    uniforms: FrameUniforms,
    previous: Previous,
    guide: Vec<[u32; 2]>,
    surfaces: Vec<Surface>,
    signal: Vec<u32>,
    history: Vec<[f64; 4]>,
    noise: Vec<u32>,
    moments: Vec<f64>,
}

/// Runs the pass on a frame's images and a random history.
fn run_pass(
    now: &Frame,
    before: &Frame,
    motion: &[[f32; 3]],
    emission: &[[f16; 4]],
    change_flags: impl Fn(u32) -> u32,
    seed: u64,
) -> Ran {
    let mut random = StdRng::seed_from_u64(seed);
    let mut u = uniforms(now, before);
    u.flags = change_flags(u.flags);
    let (previous_words, previous_surfaces) = guide(before);
    let history = random_history(&mut random, previous_surfaces.len());
    let noise = random_noise(&mut random, previous_surfaces.len());
    let motion: Vec<_> = motion.iter().map(|m| [m[0], m[1], m[2], 0.0]).collect();
    let size = now.size;
    let images = now.upload();
    let (guide, reprojected) = (blank(size, Format::Rg32Uint), blank(size, Format::Rg32Uint));
    let (signal, reprojected_noise) = (blank(size, Format::R32Uint), blank(size, Format::R32Uint));
    let floats = layout::count(u.tiles) as usize * INNOVATIONS.tile_stride() as usize;
    let moments = upload_buffer(&vec![f32::NAN; floats]);
    let no_float = blank(size, Format::R32Float);
    let is_specular = !now.specular.is_empty();
    let device = &gpu().device;
    let pass = match (is_specular, now.hit_distance.is_empty()) {
        (true, _) => Reproject::new(device, SPECULAR),
        (false, false) => Reproject::new(device, REFLECTIONS),
        (false, true) => Reproject::new(device, &[]),
    };
    run(&u, |recorder| {
        let views = ReprojectViews {
            radiance: images.specular.as_ref().unwrap_or(&images.radiance),
            albedo: &images.albedo,
            normal_roughness: &images.normal,
            roughness: &no_float,
            depth: &images.depth,
            motion: &upload(size, Format::Rgba32Float, &motion),
            surface_id: &images.id,
            emission: &upload(size, Format::Rgba16Float, emission),
            sample_count: &images.samples,
            hit_distance: images.hit_distance.as_ref().unwrap_or(&no_float),
            previous_guide: &upload(size, Format::Rg32Uint, &previous_words),
            history: &upload(size, Format::Rgba16Float, &history),
            noise: &upload(size, Format::R32Uint, &noise),
            guide: &guide,
            signal: &signal,
            reprojected: &reprojected,
            reprojected_noise: &reprojected_noise,
            moments: &moments,
        };
        pass.record(recorder, &views, size);
    });
    let history = wide(&history);
    let noise = unpack_noises(&noise, &history);
    let guide: Vec<[u32; 2]> = download(&guide);
    Ran {
        uniforms: u,
        previous: Previous { surfaces: previous_surfaces, history, noise },
        surfaces: guide.iter().map(|&words| super::surface::unpack(words)).collect(),
        guide,
        signal: download(&signal),
        history: wide(&download(&reprojected)), // two words are four half floats
        noise: download(&reprojected_noise),
        moments: download_buffer(&moments).into_iter().map(f64::from).collect(),
    }
}

fn no_emission(frame: &Frame) -> Vec<[f16; 4]> {
    vec![[f16::ZERO; 4]; frame.depth.len()]
}

/// Motion without a change of depth.
fn flat(motion: &[[f32; 2]]) -> Vec<[f32; 3]> {
    motion.iter().map(|m| [m[0], m[1], 0.0]).collect()
}

/// Share of mismatches between the GPU, given the first motion, and the twin, given the second.
fn check(
    now: &Frame,
    before: &Frame,
    [gpu_motion, motion]: [&[[f32; 3]]; 2],
    extra_flags: u32,
    seed: u64,
) -> f64 {
    let ran = run_pass(now, before, gpu_motion, &no_emission(now), |flags| flags | extra_flags, seed);
    let u = &ran.uniforms;
    let (mut expected, mut expected_noise) = (vec![], vec![]);
    let is_specular = !now.specular.is_empty();
    let mut favoured = vec![];
    if !is_specular && !now.hit_distance.is_empty() {
        favoured = reflection::favoured(u, now, &ran.surfaces, motion, &ran.previous);
        let share = favoured.iter().filter(|&&is| is).count() as f64 / favoured.len() as f64;
        assert!(
            (0.1..0.9).contains(&share),
            "{share} of the tiles follow reflections: the test shows too little"
        );
    }
    for (i, &surface) in ran.surfaces.iter().enumerate() {
        let (mut history, mut noise) = ([0.0; 4], Noise::default());
        if surface.is_miss() {
            // Its radiance goes along.
            (0..3).for_each(|c| history[c] = if is_specular { 0.0 } else { now.radiance[i][c].into() });
        } else if !now.hit_distance.is_empty() {
            let follows = is_specular || favoured[tile_of(u, i)];
            (history, noise) = fetch_signal(u, now, i, surface, motion[i], &ran.previous, follows);
        } else if let Some(origin) = find_origin(u, i, surface, motion[i]) {
            (history, noise) = fetch(u, &origin, &ran.previous);
        }
        expected.push(history);
        expected_noise.push(noise);
    }
    assert!(expected.iter().any(|h| h[3] > 0.0), "no pixel has history: the test would show nothing");
    // Half floats round to 2^-10 of the value (dithered: up to one whole step); 2e-3 near 0 is that of a texel's weight.
    let step = 2.0_f64.powi(-10) + 1e-4;
    let wrong = mismatches(ran.history.as_flattened(), expected.as_flattened(), step, 2e-3);
    let of_noise = compare_noise(&ran.noise, &ran.history, &expected_noise);
    let wrong = wrong.max(of_noise.wrong);
    if wrong <= ON_A_THRESHOLD {
        let drift = half_drift(&ran.history, &expected);
        assert!(drift.abs() < 0.02, "history drifts by {drift} of its last place");
        assert!(of_noise.drift.iter().all(|drift| drift.abs() < 0.03), "{of_noise:?}");
    }
    wrong
}

const SIZE: [u32; 2] = [83, 61];

// A tap that lies on a threshold falls to either side by rounding: a few pixels in a thousand may differ.
const ON_A_THRESHOLD: f64 = 0.005;

#[test]
fn matches_its_twin_under_camera_motion() {
    let (from, to) = (Vec3::new(0.0, 1.4, 1.0), Vec3::new(0.05, 1.42, 0.9));
    let (before, now) = (frame(SIZE, from, from, 1), frame(SIZE, to, from, 2));
    let wrong = check(&now, &before, [&flat(&now.motion); 2], 0, 3);
    assert!(wrong <= ON_A_THRESHOLD, "{wrong}");
}

#[test]
fn matches_its_twin_without_cubic_taps() {
    let (from, to) = (Vec3::new(0.0, 1.4, 1.0), Vec3::new(0.05, 1.42, 0.9));
    let (before, now) = (frame(SIZE, from, from, 1), frame(SIZE, to, from, 2));
    let wrong = check(&now, &before, [&flat(&now.motion); 2], flags::BILINEAR, 3);
    assert!(wrong <= ON_A_THRESHOLD, "{wrong}");
    // It is told from the other.
    let [cubic, bilinear] = [0, flags::BILINEAR].map(|flag| {
        run_pass(&now, &before, &flat(&now.motion), &no_emission(&now), |own| own | flag, 3).history
    });
    let step = 2.0_f64.powi(-10) + 1e-4;
    let differing = mismatches(cubic.as_flattened(), bilinear.as_flattened(), step, 2e-3);
    assert!(differing > 0.1, "{differing}");
}

#[test]
fn matches_its_twin_under_arbitrary_and_invalid_motion() {
    let eye = Vec3::new(0.0, 1.4, 1.0);
    let (before, now) = (frame(SIZE, eye, eye, 1), frame(SIZE, eye, eye, 2));
    let mut random = StdRng::seed_from_u64(4);
    let motion: Vec<[f32; 2]> = now
        .motion
        .iter()
        .map(|_| match random.random_range(0..10) {
            0 => [f32::NAN, 0.0],
            1 => [0.0, f32::INFINITY],
            2 => [1e30, -1e30],
            3 => [0.0, 0.0],
            _ => [random.random_range(-0.2..0.2), random.random_range(-0.2..0.2)],
        })
        .collect();
    let wrong = check(&now, &before, [&flat(&motion); 2], 0, 5);
    assert!(wrong <= ON_A_THRESHOLD, "{wrong}");
}

#[test]
fn matches_its_twin_where_motion_tells_the_change_of_depth() {
    let (from, to) = (Vec3::new(0.0, 1.4, 1.0), Vec3::new(0.05, 1.42, 0.9));
    let (before, now) = (frame(SIZE, from, from, 1), frame(SIZE, to, from, 2));
    let mut random = StdRng::seed_from_u64(6);
    let motion: Vec<[f32; 3]> = now
        .motion
        .iter()
        .map(|m| [m[0], m[1], [0.0, 0.1, -0.02, f32::NAN][random.random_range(0..4)]])
        .collect();
    let wrong = check(&now, &before, [&motion; 2], flags::MOTION_DEPTH, 7);
    assert!(wrong <= ON_A_THRESHOLD, "{wrong}");
    // Without the flag the same change of depth is not looked at.
    assert!(check(&now, &before, [&motion, &flat(&now.motion)], flags::MOTION_DEPTH, 7) > 0.1);
}

#[test]
fn matches_its_twin_with_jitter() {
    let (from, to) = (Vec3::new(0.0, 1.4, 1.0), Vec3::new(0.05, 1.42, 0.9));
    let before = jittered_frame(SIZE, from, from, 1, Vec2::new(0.4, -0.3));
    let now = jittered_frame(SIZE, to, from, 2, Vec2::new(-0.2, 0.45));
    let wrong = check(&now, &before, [&flat(&now.motion); 2], 0, 8);
    assert!(wrong <= ON_A_THRESHOLD, "{wrong}");
}

#[test]
fn the_comparison_fails_where_the_gpu_gets_motion_that_is_off_by_a_pixel() {
    let (from, to) = (Vec3::new(0.0, 1.4, 1.0), Vec3::new(0.05, 1.42, 0.9));
    let (before, now) = (frame(SIZE, from, from, 1), frame(SIZE, to, from, 2));
    let motion = flat(&now.motion);
    let shifted: Vec<_> = motion.iter().map(|m| [m[0] + 1.0 / SIZE[0] as f32, m[1], 0.0]).collect();
    assert!(check(&now, &before, [&shifted, &motion], 0, 3) > 0.2);
}
