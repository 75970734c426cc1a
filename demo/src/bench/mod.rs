//! How long each method takes and how much memory, all in one run.

mod args;
mod budgets;
mod compare;
mod machine;
mod measure;
mod percentiles;
mod report;
mod stopwatch;

pub use args::BenchArgs;
pub use budgets::{BudgetsArgs, BudgetsReport, budgets};
pub use compare::compare;
pub use measure::{MeasureArgs, MeasureReport, measure};
pub use report::BenchReport;

use crate::gbuffer::Split;
use crate::gpu::Gpu;
use crate::method::{Method, MethodFrame, MethodRunner};
use crate::quality::write_json;
use crate::render::progress_bar;
use crate::tracer::Sampling;
use crate::walk::{Walk, WalkOptions};
use anyhow::{Context, Result, bail};
use machine::Machine;
use quell::Settings;
use report::{MethodRecorder, SizeReport, SkippedSize};
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;
use stopwatch::{Clock, Stopwatch};

/// What to time, and where the results go.
#[derive(Debug, Clone)]
pub struct BenchOptions {
    /// A glTF file; the built-in gallery without.
    pub scene: Option<PathBuf>,
    /// Width and height of each; empty for those that suit the adapter.
    pub sizes: Vec<[u32; 2]>,
    /// Frames that are timed, and those before them; at least 1 each.
    pub frames: u32,
    pub warm_up: u32,
    /// Scene time of the first frame, seconds.
    pub start_s: f32,
    pub motion: Motion,
    /// Samples per pixel.
    pub spp: u32,
    /// Each once.
    pub methods: Vec<Method>,
    /// What ratios are to; by default SVGF where it is timed, otherwise the first but quell.
    pub baseline: Option<Method>,
    /// What quell gets apart.
    pub split: Split,
    /// quell's.
    pub settings: Settings,
    /// Folder for the results, created where needed.
    pub out: PathBuf,
}

/// What moves from frame to frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Motion {
    /// The camera walks: history is resampled
    #[default]
    Walk,
    /// Nothing moves: history lies where it is
    Still,
    /// As a walk of which each frame is the first: there is no history
    Cut,
}

const GPU_SIZES: [[u32; 2]; 3] = [[1280, 720], [1920, 1080], [2560, 1440]];
const CPU_SIZES: [[u32; 2]; 1] = [[320, 180]];
/// Frames per second of the walk's time.
const FPS: f32 = 30.0;

const ON_CPU: &str = "timestamps of a CPU adapter do not wait for compute passes, so frames are timed by the wall clock, \
                      quell's pass by pass, the others' in one; times on a CPU say nothing about a GPU";
const NO_TIMESTAMPS: &str =
    "the adapter has no timestamps, so frames are timed by the wall clock and passes are not timed";

/// Times all methods at all sizes. Leaves `bench.json` and `bench.md` in `out`.
pub fn bench(gpu: &Gpu, options: &BenchOptions) -> Result<BenchReport> {
    let baseline = baseline(&options.methods, options.baseline)?;
    let out = &options.out;
    std::fs::create_dir_all(out).with_context(|| format!("{}: cannot create the folder", out.display()))?;
    let on_cpu = is_cpu(gpu);
    let default_sizes = if on_cpu { &CPU_SIZES[..] } else { &GPU_SIZES };
    let wanted = if options.sizes.is_empty() { default_sizes } else { &options.sizes };

    let clock = Stopwatch::new(gpu, 1).clock();
    let mut scene = String::new();
    let (mut sizes, mut skipped) = (Vec::new(), Vec::new());
    for &[width, height] in wanted {
        match set_up(gpu, options, [width, height]) {
            Ok((walk, runners)) => {
                scene = walk.scene_name().to_owned();
                let report = time_size(gpu, options, &walk, runners, baseline)
                    .with_context(|| format!("{width}x{height}"))?;
                sizes.push(report);
            }
            Err(error) => skipped.push(SkippedSize { width, height, reason: format!("{error:#}") }),
        }
    }
    if let ([], [SkippedSize { width, height, reason }, ..]) = (&sizes[..], &skipped[..]) {
        bail!("no size can be timed; {width}x{height}: {reason}");
    }

    let report = BenchReport {
        machine: Machine::of(gpu),
        clock,
        note: wall_note(gpu, clock),
        scene,
        start_s: options.start_s,
        motion: options.motion,
        settings: (options.settings != Settings::default()).then(|| format!("{:?}", options.settings)),
        spp: options.spp,
        warm_up: options.warm_up,
        frames: options.frames,
        baseline: baseline.name(),
        sizes,
        skipped,
    };
    write_json(&report, &out.join("bench.json"))?;
    let path = out.join("bench.md");
    std::fs::write(&path, report.text()).with_context(|| format!("{}: cannot write", path.display()))?;
    Ok(report)
}

fn is_cpu(gpu: &Gpu) -> bool {
    gpu.device.adapter_info().device_type == wgpu::DeviceType::Cpu
}

/// What to know about the clock.
fn wall_note(gpu: &Gpu, clock: Clock) -> Option<&'static str> {
    match clock {
        Clock::GpuTimestamps => None,
        Clock::Wall => Some(if is_cpu(gpu) { ON_CPU } else { NO_TIMESTAMPS }),
    }
}

/// The `wanted` one of `methods`; by default SVGF, which the literature compares with, or else the first peer.
fn baseline(methods: &[Method], wanted: Option<Method>) -> Result<Method> {
    let find = |is: &dyn Fn(Method) -> bool| methods.iter().copied().find(|&method| is(method));
    let found = match wanted {
        Some(wanted) => find(&|method| method == wanted),
        None => find(&|method| method.name() == "svgf")
            .or_else(|| find(&|method| method != Method::Quell))
            .or_else(|| methods.first().copied()),
    };
    let Some(found) = found else {
        let timed: Vec<_> = methods.iter().map(|method| method.name()).collect();
        let wanted = wanted.map_or("any", Method::name);
        bail!("baseline {wanted}: not among the methods to time, which are {}", timed.join(", "));
    };
    Ok(found)
}

/// A walk and all methods at a size, or why there are none.
fn set_up(gpu: &Gpu, options: &BenchOptions, [width, height]: [u32; 2]) -> Result<(Walk, Vec<MethodRunner>)> {
    // Not every method checks limits itself; without scopes, wgpu would end the program.
    let filters = [wgpu::ErrorFilter::OutOfMemory, wgpu::ErrorFilter::Validation];
    let scopes = filters.map(|filter| gpu.device.push_error_scope(filter));
    let create = || {
        let runner =
            |&method: &Method| MethodRunner::new(gpu, method, width, height).with_context(|| method.name());
        let runners = options.methods.iter().map(runner).collect::<Result<Vec<_>>>()?;
        let walk = Walk::new(
            gpu,
            WalkOptions {
                scene: options.scene.clone(),
                width,
                height,
                frames: options.warm_up + options.frames,
                // Time that stands still, but for the noise.
                fps: if options.motion == Motion::Still { f32::INFINITY } else { FPS },
                start_s: options.start_s,
                spp: options.spp as f32,
                sampling: Sampling::Uniform,
                seed: 0,
                jitter: false,
                split: options.split,
            },
        )?;
        Ok((walk, runners))
    };
    let created = create();
    // A stack: the last is popped first.
    let errors = scopes.into_iter().rev().map(|scope| pollster::block_on(scope.pop()));
    let error = errors.fold(None, |first, error| first.or(error));
    match error {
        Some(error) if created.is_ok() => Err(error.into()),
        _ => created,
    }
}

/// Times all methods on the same frames. They take turns, so that a drift of the machine's speed hits all alike.
fn time_size(
    gpu: &Gpu,
    options: &BenchOptions,
    walk: &Walk,
    mut runners: Vec<MethodRunner>,
    baseline: Method,
) -> Result<SizeReport> {
    let most_passes = runners.iter().map(|runner| runner.passes().len()).max().unwrap_or_default();
    let stopwatch = Stopwatch::new(gpu, most_passes);
    let mut recorders: Vec<_> = runners.iter().map(|_| MethodRecorder::default()).collect();
    let frames = options.warm_up + options.frames;
    let progress = progress_bar(frames.into(), "timing");
    let start = Instant::now();
    let mut measured_ms = None;
    for i in 0..frames {
        trace(gpu, walk, i)?;
        let restarts = walk.is_cut(i) || options.motion == Motion::Cut;
        let frame = MethodFrame::new(walk.gbuffer(), walk.view(i).camera, restarts, &options.settings);
        let frame = MethodFrame { measured_ms, ..frame };
        for turn in 0..runners.len() {
            // Another one begins with every frame: whoever follows the tracer may find other caches and clocks.
            let which = (turn + i as usize) % runners.len();
            let runner = &mut runners[which];
            let started_ms = start.elapsed().as_nanos() as f64 / 1e6;
            let time = stopwatch
                .measure(gpu, runner, &frame)
                .with_context(|| format!("{}, frame {i}", runner.method().name()))?;
            if runner.method() == Method::Quell {
                measured_ms = stopwatch.told_ms(&time);
            }
            if i >= options.warm_up {
                recorders[which].add(started_ms, time, runner.models());
            }
        }
        progress.inc(1);
    }
    progress.finish_and_clear();

    let (width, height) = (walk.gbuffer().width, walk.gbuffer().height);
    let pixels = f64::from(width) * f64::from(height);
    let finish = |(recorder, runner): (MethodRecorder, &MethodRunner)| {
        recorder.finish(runner.method().name(), runner.passes(), &runner.memory(), pixels)
    };
    let methods = recorders.into_iter().zip(&runners).map(finish).collect();
    Ok(SizeReport::new([width, height], baseline.name(), methods))
}

/// Traces a frame: anew every time, since inputs of many frames would not fit into memory, and waited for, so that the tracer is done
/// before a method begins.
fn trace(gpu: &Gpu, walk: &Walk, frame: u32) -> Result<()> {
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    walk.trace(gpu, &mut encoder, frame);
    gpu.queue.submit([encoder.finish()]);
    gpu.device.poll(wgpu::PollType::wait_indefinitely()).context("waiting for the path tracer")?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_baseline_is_one_of_the_methods() {
        let all = [Method::Quell, Method::Accumulate];
        assert_eq!(baseline(&all, None).unwrap(), Method::Accumulate, "quell is compared, not the measure");
        assert_eq!(baseline(&all, Some(Method::Quell)).unwrap(), Method::Quell);
        assert_eq!(baseline(&[Method::Quell], None).unwrap(), Method::Quell);
        let message = baseline(&all, Some(Method::None)).unwrap_err().to_string();
        assert!(message.contains("none") && message.contains("quell, accumulate"), "{message}");
    }

    fn options(method: Method, motion: Motion) -> BenchOptions {
        BenchOptions {
            scene: None,
            sizes: Vec::new(),
            frames: 8,
            warm_up: 1,
            start_s: 0.0,
            motion,
            spp: 1,
            methods: vec![method],
            baseline: None,
            split: Split::None,
            settings: Settings::default(),
            out: PathBuf::new(),
        }
    }

    #[test]
    fn time_stands_still_where_it_is_to() {
        let gpu = Gpu::new().expect("tests need a Vulkan driver");
        let moved = |motion| {
            let (walk, _) = set_up(&gpu, &options(Method::Accumulate, motion), [16, 9]).unwrap();
            walk.view(8).camera.view_from_world != walk.view(0).camera.view_from_world
        };
        assert_eq!([Motion::Walk, Motion::Still, Motion::Cut].map(moved), [true, false, true]);
    }

    #[test]
    fn a_size_beyond_the_device_is_an_error_and_no_panic() {
        let gpu = Gpu::new().expect("tests need a Vulkan driver");
        let beyond = gpu.device.limits().max_texture_dimension_2d + 1;
        let set_up = |method, size| super::set_up(&gpu, &options(method, Motion::Walk), size);
        // Quell checks limits itself; accumulation leaves it to others.
        for method in [Method::Quell, Method::Accumulate] {
            let error = set_up(method, [beyond, 4]).unwrap_err();
            assert!(format!("{error:#}").contains(&beyond.to_string()), "{method:?}: {error:#}");
            assert!(set_up(method, [8, 4]).is_ok());
        }
    }
}
