//! The command line.

use crate::bench::{BenchArgs, BudgetsArgs, MeasureArgs, bench, budgets, compare, measure};
use crate::check::{CheckArgs, check};
use crate::gpu::Gpu;
use crate::method::Method;
use crate::record::{RecordOptions, record};
use crate::render::{METHODS, RenderOptions, render};
use crate::replay::{ReplayOptions, replay};
use crate::report::ReportArgs;
use crate::sampling::{SamplingArgs, sampling};
use crate::settings_args::SettingsArgs;
use crate::split_args::SplitArgs;
use crate::still::{StillArgs, still};
use crate::study::{Rect, StudyOptions, study};
use crate::tracer::Sampling;
use crate::walk::{References, WalkOptions, load_scene};
use crate::walkthrough::Walkthrough;
use crate::window::{self, ViewState, WindowError, WindowOptions};
use anyhow::Result;
use clap::{Args, Parser, Subcommand};
use std::io::Write;
use std::path::PathBuf;

/// Real-time denoising of path-traced frames: without a command, a walkthrough in a window
#[derive(Debug, Parser)]
#[command(name = "quell-demo", version, propagate_version = true, args_conflicts_with_subcommands = true)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
    #[command(flatten)]
    pub walkthrough: WalkthroughArgs,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render the walk without a window, into pictures and metrics
    ///
    /// Writes PNGs in a folder per method (`noisy/` for none, `denoised/` for quell, otherwise its name) and in
    /// `reference/`, `contact_sheet.png` and `metrics.json`.
    Render(RenderArgs),
    /// Record the walk's inputs as a capture
    ///
    /// Writes `capture.json` and one OpenEXR file per frame, which `replay` reads.
    Record(RecordArgs),
    /// Denoise a captured sequence
    ///
    /// Writes `frame_0000.exr` (linear R, G, B), `frame_0000.png` (as shown) and so on. Where the capture has
    /// reference images, prints metrics and writes them to `metrics.json`.
    Replay(ReplayArgs),
    /// Say what looks wrong with the inputs in a captured sequence, and which to look at
    ///
    /// Judges by how well they agree with each other over the frames, and says what these could not tell. Ends with 0 where
    /// nothing looks wrong, and with 1 where something does or the capture cannot be read.
    Check(CheckArgs),
    /// Compare all methods on a suite of sequences, as one page
    ///
    /// Writes `report.html`, which needs no other file, and its numbers as `report.json`. All methods of a sequence see the
    /// very same frames.
    Report(ReportArgs),
    /// Compare dense, uniform and adaptive models on one image, estimated with true errors, and errors over frames
    ///
    /// Writes `study.html`, which needs no other file, its numbers as `study.json`, and its pictures.
    Study(StudyArgs),
    /// Render one image in rounds, with samples where the denoiser expects them to help most
    ///
    /// Writes `still.png`, `still.exr`, `samples.png`, `expected_error.png` and `still.json`; with `--reference` also
    /// `reference.png`, `uniform.png` and `error.svg`, which compare with uniform sampling.
    Still(StillArgs),
    /// Compare ways to place samples: uniform, checkerboard, adaptive
    ///
    /// Denoises the walk of a capture that has references, at each number of samples in each way. Writes `sampling.md`,
    /// `sampling.json`, and the last frame of each with the samples it asks for.
    Sampling(SamplingArgs),
    /// Time every method, frame by frame in turns, and list its memory
    ///
    /// Writes `bench.json` and the tables as `bench.md`.
    Bench(BenchArgs),
    /// Measure this machine in some minutes: all methods over sizes, histories, several views, budgets of time, clocks and power
    ///
    /// Writes `measure.html`, which needs no other file, its numbers as `measure.json`, and the results of each bench.
    Measure(MeasureArgs),
    /// Compare budgets of models and of time on captures: times, metrics, models
    ///
    /// Writes `budgets.json` and the tables as `budgets.md`.
    Budgets(BudgetsArgs),
}

/// What the window shows.
#[derive(Debug, Args)]
pub struct WalkthroughArgs {
    /// A glTF 2.0 file (.gltf or .glb) to walk through instead of the built-in gallery
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Scene time to begin at, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = finite)]
    pub start: f32,
    /// Another seed gives other noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// End after so many frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub exit_after: Option<u32>,
    #[command(flatten)]
    pub split: SplitArgs,
}

/// A walk that is traced frame by frame.
#[derive(Debug, Args)]
pub struct WalkArgs {
    /// A glTF 2.0 file (.gltf or .glb) to walk through instead of the built-in gallery
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "320x180", value_parser = size)]
    pub size: [u32; 2],
    /// Number of frames
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,
    /// Frames per second of scene time
    #[arg(long, value_name = "F", default_value_t = 30.0, value_parser = positive)]
    pub fps: f32,
    /// Scene time of the first frame, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = finite)]
    pub start: f32,
    /// Samples per pixel and frame, in the mean: 0.0625 to 64
    #[arg(long, value_name = "N", default_value_t = 1.0, value_parser = samples_per_pixel)]
    pub spp: f32,
    /// Which pixels get them
    #[arg(long, value_enum, default_value_t)]
    pub sampling: Sampling,
    /// Another seed gives other noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// Move the samples within the pixel from frame to frame, and average references over the pixel
    #[arg(long)]
    pub jitter: bool,
    /// Also trace reference images of this many samples per pixel, and measure against them
    #[arg(long, value_name = "SPP", default_value_t = 0)]
    pub reference: u32,
    /// Frames that get a reference, e.g. 8,9,20 [default: four pairs spread over the walk]
    #[arg(long, value_name = "LIST", value_delimiter = ',', requires = "reference")]
    pub reference_frames: Option<Vec<u32>>,
    #[command(flatten)]
    pub split: SplitArgs,
    /// Folder for the results, created where needed
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

impl WalkArgs {
    fn walk(&self) -> WalkOptions {
        let [width, height] = self.size;
        WalkOptions {
            scene: self.scene.clone(),
            width,
            height,
            frames: self.frames,
            fps: self.fps,
            start_s: self.start,
            spp: self.spp,
            sampling: self.sampling,
            seed: self.seed,
            jitter: self.jitter,
            split: self.split.split(),
        }
    }

    fn references(&self) -> References {
        References { spp: self.reference, frames: self.reference_frames.clone() }
    }
}

/// `quell-demo render`
#[derive(Debug, Args)]
pub struct RenderArgs {
    #[command(flatten)]
    pub walk: WalkArgs,
    /// What to show side by side, e.g. none,svgf,quell; may be given more than once
    #[arg(long, value_enum, value_name = "LIST", value_delimiter = ',', default_values_t = METHODS)]
    pub method: Vec<Method>,
    /// Follow every method by temporal antialiasing
    #[arg(long, requires = "jitter")]
    pub antialias: bool,
}

/// `quell-demo record`
#[derive(Debug, Args)]
pub struct RecordArgs {
    #[command(flatten)]
    pub walk: WalkArgs,
    /// Replace a capture that is in the folder already
    #[arg(long)]
    pub overwrite: bool,
}

/// `quell-demo replay`
#[derive(Debug, Args)]
pub struct ReplayArgs {
    /// Folder of the capture (with capture.json in it)
    #[arg(value_name = "DIR")]
    pub capture: PathBuf,
    /// Folder for the results, created where needed
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// How to denoise
    #[arg(long, value_enum, default_value_t = Method::Quell)]
    pub method: Method,
    #[command(flatten)]
    pub split: SplitArgs,
    #[command(flatten)]
    pub settings: SettingsArgs,
}

/// `quell-demo study`
#[derive(Debug, Args)]
pub struct StudyArgs {
    /// A glTF 2.0 file (.gltf or .glb) instead of the built-in gallery
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "320x180", value_parser = size)]
    pub size: [u32; 2],
    /// Scene time, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = finite)]
    pub start: f32,
    /// Samples per pixel of the image to denoise
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub spp: u32,
    /// Samples per pixel of the reference
    #[arg(long, value_name = "SPP", default_value_t = 256, value_parser = clap::value_parser!(u32).range(2..))]
    pub reference: u32,
    /// Another seed gives other noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    /// Images with independent noise over which true errors are averaged
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub runs: u32,
    /// Frames of the still view, 1 sample per pixel each, over which convergence is measured; 0 leaves it out
    #[arg(long, value_name = "N", default_value_t = 64, value_parser = clap::value_parser!(u32).range(..=100_000))]
    pub frames: u32,
    /// Part of the image to enlarge, in pixels [default: where the most detail is]
    #[arg(long, value_name = "X,Y,W,H", value_parser = rect)]
    pub zoom: Option<Rect>,
    /// Pixels whose errors are plotted over window size [default: an edge, a shadow, a texture, a flat wall]
    #[arg(long, value_name = "X,Y", num_args = 1.., value_parser = pixel)]
    pub pixels: Vec<[u32; 2]>,
    /// Folder for the results, created where needed
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Where the walkthrough goes without a display.
const HEADLESS_OUT: &str = "out/walk";
/// How much of it: a CPU adapter needs a minute or two.
const HEADLESS_FRAMES: u32 = 96;

/// Does what the command line says.
pub fn run(cli: Cli) -> Result<()> {
    match cli.command {
        None => run_walkthrough(cli.walkthrough),
        Some(Command::Render(args)) => run_render(&args),
        Some(Command::Record(args)) => run_record(&args),
        Some(Command::Replay(args)) => run_replay(args),
        Some(Command::Check(args)) => run_check(&args),
        Some(Command::Report(args)) => say(&args.run()?),
        Some(Command::Study(args)) => run_study(args),
        Some(Command::Bench(args)) => run_bench(args),
        Some(Command::Sampling(args)) => run_sampling(args),
        Some(Command::Still(args)) => run_still(args),
        Some(Command::Measure(args)) => {
            let report = measure(&Gpu::new()?, &args)?;
            say(&format!("{}wrote {}\n", report.text(), args.out.display()))
        }
        Some(Command::Budgets(args)) => {
            let report = budgets(&Gpu::new()?, &args)?;
            say(&format!("{}wrote {}\n", report.text(), args.out.display()))
        }
    }
}

fn run_walkthrough(args: WalkthroughArgs) -> Result<()> {
    let scene = load_scene(args.scene.as_deref())?;
    let pose = scene.camera(args.start);
    let options = WindowOptions {
        title: format!("quell: {}", scene.name),
        // What is looked at is reached in some seconds, whatever the unit. Not from the bounds: a ground may be far
        // larger than the room on it.
        speed: pose.eye.distance(pose.target) / 4.0,
        max_frames: args.exit_after.map(u64::from),
        view: ViewState { signals: args.split.split(), ..ViewState::default() },
        ..WindowOptions::default()
    };
    match window::run(options, |gpu| Walkthrough::new(gpu, scene, args.seed, args.start)) {
        Err(WindowError::NoDisplay(reason)) => {
            say(&format!("no display ({reason}); rendering the walk into {HEADLESS_OUT} instead\n"))?;
            let walk = WalkArgs {
                scene: args.scene,
                size: [320, 180],
                frames: args.exit_after.unwrap_or(HEADLESS_FRAMES),
                fps: 15.0,
                start: args.start,
                spp: 1.0,
                sampling: Sampling::Uniform,
                seed: args.seed,
                jitter: false,
                reference: 0,
                reference_frames: None,
                split: args.split,
                out: HEADLESS_OUT.into(),
            };
            run_render(&RenderArgs { walk, method: METHODS.to_vec(), antialias: false })
        }
        result => Ok(result?),
    }
}

fn run_render(args: &RenderArgs) -> Result<()> {
    let walk = &args.walk;
    let mut methods = Vec::new();
    for &method in &args.method {
        // One named twice has one folder and one line of metrics.
        if !methods.contains(&method) {
            methods.push(method);
        }
    }
    let options = RenderOptions {
        walk: walk.walk(),
        references: walk.references(),
        methods,
        antialias: args.antialias,
        out: walk.out.clone(),
    };
    let report = render(&Gpu::new()?, &options)?;
    say(&format!("{}wrote {}\n", report.summary(), walk.out.display()))
}

fn run_record(args: &RecordArgs) -> Result<()> {
    let walk = &args.walk;
    let options = RecordOptions {
        walk: walk.walk(),
        references: walk.references(),
        out: walk.out.clone(),
        overwrite: args.overwrite,
    };
    record(&Gpu::new()?, &options)?;
    say(&format!("wrote {}\n", walk.out.display()))
}

fn run_replay(args: ReplayArgs) -> Result<()> {
    let report = replay(&ReplayOptions {
        capture: args.capture,
        out: args.out.clone(),
        method: args.method,
        settings: args.settings,
        split: args.split.split(),
    })?;
    say(&match report {
        Some(report) => report.table(),
        None => format!("wrote {}; the capture has no reference images, so no metrics\n", args.out.display()),
    })
}

fn run_check(args: &CheckArgs) -> Result<()> {
    let checked = check(args)?;
    say(&checked.text())?;
    // What is printed is the result; this is for whoever looks at the exit code.
    anyhow::ensure!(checked.findings.is_empty(), "{}: inputs look wrong", args.capture.display());
    Ok(())
}

fn run_study(args: StudyArgs) -> Result<()> {
    let page = args.out.join("study.html");
    let [width, height] = args.size;
    let options = StudyOptions {
        scene: args.scene,
        width,
        height,
        start_s: args.start,
        spp: args.spp,
        reference_spp: args.reference,
        seed: args.seed,
        runs: args.runs,
        frames: args.frames,
        zoom: args.zoom,
        pixels: args.pixels,
        out: args.out,
    };
    let report = study(&Gpu::new()?, &options)?;
    say(&format!("{}wrote {}\n", report.summary(), page.display()))
}

fn run_bench(args: BenchArgs) -> Result<()> {
    if let Some([a, b]) = args.compare.as_deref() {
        return say(&compare([a, b])?);
    }
    let options = args.options();
    let report = bench(&Gpu::new()?, &options)?;
    say(&format!("{}wrote {}\n", report.text(), options.out.display()))
}

fn run_still(args: StillArgs) -> Result<()> {
    let options = args.options();
    let report = still(&Gpu::new()?, &options)?;
    say(&format!("{}wrote {}\n", report.summary(), options.out.display()))
}

fn run_sampling(args: SamplingArgs) -> Result<()> {
    let options = args.options();
    let report = sampling(&Gpu::new()?, &options)?;
    say(&format!("{}wrote {}\n", report.table(), options.out.display()))
}

/// Not `print!`, which panics when the reader of a pipe has gone.
fn say(text: &str) -> Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}

pub fn size(text: &str) -> Result<[u32; 2], String> {
    let parse = |side: &str| side.parse::<u32>().ok().filter(|side| (1..=8192).contains(side));
    let sides = text.split_once('x').and_then(|(width, height)| Some([parse(width)?, parse(height)?]));
    sides.ok_or_else(|| "expected WIDTHxHEIGHT with sides of 1 to 8192 pixels, e.g. 640x360".to_owned())
}

/// Whole numbers between commas.
fn numbers<const N: usize>(text: &str) -> Option<[u32; N]> {
    let numbers: Option<Vec<u32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    numbers?.try_into().ok()
}

fn pixel(text: &str) -> Result<[u32; 2], String> {
    numbers(text).ok_or_else(|| "expected X,Y in pixels from the upper left corner, e.g. 160,90".to_owned())
}

fn rect(text: &str) -> Result<Rect, String> {
    let [x, y, width, height] =
        numbers(text).ok_or("expected X,Y,WIDTH,HEIGHT in pixels, e.g. 120,60,80,45")?;
    Ok(Rect { x, y, width, height })
}

pub(crate) fn finite(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|number| number.is_finite());
    number.ok_or_else(|| "expected a finite number".to_owned())
}

pub fn positive(text: &str) -> Result<f32, String> {
    finite(text).ok().filter(|&number| number > 0.0).ok_or_else(|| "expected a number above 0".to_owned())
}

/// As the denoiser's sample map takes them.
pub fn samples_per_pixel(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|number| (1.0 / 16.0..=64.0).contains(number));
    number.ok_or_else(|| "expected samples per pixel, 0.0625 to 64".to_owned())
}
