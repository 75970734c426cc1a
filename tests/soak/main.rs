//! Frames that nobody would think of: random settings, conventions, sizes, viewports, cuts, cameras and inputs, hostile
//! pixels, denoisers that share pipelines and encoders. A binary of its own, because it measures its own memory.
//!
//! `QUELL_SOAK_FRAMES=10000 cargo test --test soak` runs longer; `QUELL_SOAK_SEED` repeats a run. Errors of wgpu's validation
//! panic, in this suite as in all: no handler is set that would swallow them.

mod case;
#[path = "../suite/gpu.rs"]
#[expect(dead_code, reason = "shared with the suite")]
mod gpu;
mod hostile;
mod judge;
mod lost;
mod pool;

use case::Case;
use judge::Judge;
use pool::Pool;
use quell::{CreateError, Denoiser, DenoiserDescriptor, Pipelines};
use rand::{Rng, SeedableRng, rngs::StdRng};
use std::sync::Arc;

/// Few: a driver on the CPU compiles anew for each combination of switches.
const FRAMES: usize = 480;
/// After so many frames another combination of switches; in long runs after more, so that there are as many.
const FRAMES_A_CASE: usize = 20;
const MOST_CASES: usize = 90;
/// A third of the frames go through all combinations, the rest through the same again: the caches of driver and allocator are warm
/// then, and the process may grow by this, in MB, which is less than 20 denoisers of the largest size.
const MOST_GROWTH_MB: f64 = 16.0;

fn from_environment(name: &str, default: usize) -> usize {
    match std::env::var(name) {
        Ok(text) => text.parse().unwrap_or_else(|_| panic!("{name} is `{text}`, expected a number")),
        Err(_) => default,
    }
}

/// A row of what Linux says of this process's memory, in kB.
fn status_kb(row: &str) -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let kb = status.lines().find_map(|line| line.strip_prefix(row)?.trim().strip_suffix(" kB"));
    kb.and_then(|kb| kb.trim().parse().ok()).unwrap_or(0)
}

fn resident_mb() -> f64 {
    status_kb("VmRSS:") as f64 / 1024.0
}

fn denoiser(random: &mut StdRng, pipelines: &Arc<Pipelines>) -> Denoiser {
    let descriptor = DenoiserDescriptor::new(random.random_range(1..=96), random.random_range(1..=96));
    Denoiser::with_pipelines(&gpu::gpu().device, &descriptor, Arc::clone(pipelines)).unwrap()
}

#[test]
fn random_frames_are_sound_and_leave_nothing_behind() {
    let frames = from_environment("QUELL_SOAK_FRAMES", FRAMES);
    let seed = from_environment("QUELL_SOAK_SEED", 1) as u64;
    println!("seed {seed}, {frames} frames");
    let gpu = gpu::gpu();
    let mut random = StdRng::seed_from_u64(seed);
    let (pool, judge) = (Pool::new(&mut random), Judge::new());
    let pipelines = Arc::new(Pipelines::new(&gpu.device).unwrap());
    let mut denoisers = [0; 3].map(|_| denoiser(&mut random, &pipelines));
    let frames_a_case = FRAMES_A_CASE.max(frames / MOST_CASES);
    let new_cases = (frames / 3).div_ceil(frames_a_case).max(1);
    let all_cases: Vec<[Case; 3]> =
        (0..new_cases).map(|_| std::array::from_fn(|_| Case::new(&mut random))).collect();
    let mut warm_mb = 0.0;
    for frame in 0..frames {
        let cases = &all_cases[frame / frames_a_case % new_cases];
        if frame % (frames / 10).max(1) == 0 {
            println!("frame {frame}, {:.0} MB", resident_mb());
        }
        if frame == frames / 3 {
            warm_mb = resident_mb();
        }
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        // Mostly one; sometimes several in one submission, sometimes one twice.
        for _ in 0..random.random_range(1..=3).min(random.random_range(1..=3)) {
            let which = random.random_range(0..denoisers.len());
            let quell = &mut denoisers[which];
            match random.random_range(0..100) {
                0 => *quell = denoiser(&mut random, &pipelines),
                1 => {
                    let descriptor =
                        DenoiserDescriptor::new(random.random_range(1..=96), random.random_range(1..=96));
                    quell.resize(&gpu.device, &descriptor).unwrap();
                }
                2 => {
                    let refused = quell.resize(&gpu.device, &DenoiserDescriptor::new(0, 7));
                    assert!(matches!(refused, Err(CreateError::EmptySize { .. })));
                }
                _ => {}
            }
            let output = judge.output(&mut random);
            let (inputs, settings) = cases[which].frame(&mut random, &pool, &output, quell.size());
            quell.encode(&gpu.device, &gpu.queue, &mut encoder, &inputs, &settings).unwrap_or_else(|error| {
                panic!("frame {frame} of seed {seed} was refused: {error}\n{inputs:?}\n{settings:?}")
            });
            judge.look_at(&mut encoder, &output, inputs.viewport.unwrap());
            let _ = quell.statistics();
        }
        if random.random_bool(0.97) {
            gpu.queue.submit([encoder.finish()]);
        }
        if frame % 8 == 0 {
            gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
            let broken = judge.broken();
            assert_eq!(broken, 0, "broken pixels up to frame {frame} of seed {seed}: {cases:?}");
        }
    }
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
    assert_eq!(judge.broken(), 0, "seed {seed}");
    let grown_mb = resident_mb() - warm_mb;
    println!("{frames} frames, {:.0} MB, grown by {grown_mb:.1} MB since the first third", resident_mb());
    assert!(grown_mb < MOST_GROWTH_MB, "grown by {grown_mb:.1} MB over two thirds of {frames} frames");
}

/// What is held does not depend on how many frames there were.
#[test]
fn views_buffers_and_textures_do_not_pile_up() {
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let (device, queue) = lost::device(&instance);
    let mut quell = Denoiser::new(&device, &DenoiserDescriptor::new(40, 24)).unwrap();
    let images = lost::Images::new(&device, [40, 24]);
    let mut held = vec![];
    for frame in 0..40 {
        images.encode(&mut quell, &device, &queue).unwrap();
        device.poll(wgpu::PollType::wait_indefinitely()).unwrap();
        let _ = quell.statistics();
        if frame >= 20 {
            let report = instance.generate_report().unwrap().hub;
            held.push(
                [report.buffers, report.textures, report.texture_views, report.bind_groups]
                    .map(|kind| kind.num_allocated),
            );
        }
    }
    assert!(held.iter().all(|counts| *counts == held[0]), "{held:?}");
}
