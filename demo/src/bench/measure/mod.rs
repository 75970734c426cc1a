//! All that a machine tells of the denoiser's cost in some minutes, as one page: every method over sizes, quell over what its
//! history has to do with and over views, and whether budgets of time are kept.

mod growth;
mod pace;
mod page;
mod power;
mod views;

use super::machine::Machine;
use super::report::BenchReport;
use super::{BenchOptions, Motion, bench, is_cpu};
use crate::cli::{positive, size};
use crate::gpu::Gpu;
use crate::method::Method;
use crate::quality::write_json;
use crate::split_args::SplitArgs;
use anyhow::{Context, Result};
use growth::Growth;
use pace::{Pace, pace};
use power::power_state;
use quell::Settings;
use serde::Serialize;
use std::path::PathBuf;
use views::{Views, views};

/// `quell-demo measure`
#[derive(Debug, Clone, clap::Args)]
pub struct MeasureArgs {
    /// Width and height in pixels of the frames that time and memory are looked at over; may be given several times [default: from
    /// 320x180 to 3840x2160 on a GPU, 64x36 and 128x72 on a CPU]
    #[arg(long, value_name = "WxH", value_delimiter = ',', value_parser = size)]
    pub size: Vec<[u32; 2]>,
    /// Width and height of the frames that histories, views and budgets are looked at with [default: 1920x1080 on a GPU, 128x72 on a CPU]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub at: Option<[u32; 2]>,
    /// Milliseconds that a frame may take, one budget after the other; may be given several times
    #[arg(long, value_name = "MS", value_delimiter = ',', value_parser = positive, default_values_t = [1.0, 0.75, 0.5])]
    pub budget_ms: Vec<f32>,
    /// Number of timed frames; under a budget three times as many
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub frames: u32,
    /// Untimed frames before them; under a budget all are timed
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub warm_up: u32,
    #[command(flatten)]
    pub split: SplitArgs,
    /// Folder for the results, created where needed
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

const GPU_SIZES: [[u32; 2]; 6] =
    [[320, 180], [640, 360], [1280, 720], [1920, 1080], [2560, 1440], [3840, 2160]];
const CPU_SIZES: [[u32; 2]; 2] = [[64, 36], [128, 72]];

/// What `measure.json` holds.
#[derive(Debug, Serialize)]
pub struct MeasureReport {
    pub machine: Machine,
    /// What the driver tells of clocks and power, before and after; none where it tells nothing.
    pub power: [Option<String>; 2],
    /// All methods over sizes, on a walk.
    pub walk: BenchReport,
    /// quell and the baseline at one size where nothing moves, and where no frame has a history.
    pub still: BenchReport,
    pub cut: BenchReport,
    /// How quell's time and memory grow with the number of pixels.
    pub growth: Growth,
    /// Size in pixels of the frames of several views and of those under budgets.
    pub at: [u32; 2],
    /// What one view takes, and what several do.
    pub views: Vec<Views>,
    /// What came of each budget.
    pub paces: Vec<Pace>,
}

/// Measures all. Leaves `measure.json`, `measure.html` and a folder with the results of each `bench` in `out`.
pub fn measure(gpu: &Gpu, args: &MeasureArgs) -> Result<MeasureReport> {
    let (sizes, at) =
        if is_cpu(gpu) { (&CPU_SIZES[..], CPU_SIZES[1]) } else { (&GPU_SIZES[..], GPU_SIZES[3]) };
    let sizes = if args.size.is_empty() { sizes.to_vec() } else { args.size.clone() };
    let at = args.at.unwrap_or(at);
    let all = [Method::Quell, Method::Svgf, Method::Bmfr, Method::Accumulate];
    let options = |folder: &str, motion, sizes: &[[u32; 2]], methods: &[Method]| BenchOptions {
        scene: None,
        sizes: sizes.to_vec(),
        frames: args.frames,
        warm_up: args.warm_up,
        start_s: 0.0,
        motion,
        spp: 1,
        methods: methods.to_vec(),
        baseline: None,
        split: args.split.split(),
        settings: Settings::default(),
        out: args.out.join(folder),
    };
    let before = power_state();
    let walk = bench(gpu, &options("walk", Motion::Walk, &sizes, &all))?;
    let still = bench(gpu, &options("still", Motion::Still, &[at], &all[..2]))?;
    let cut = bench(gpu, &options("cut", Motion::Cut, &[at], &all[..2]))?;
    let quell = |frames| BenchOptions { frames, ..options("walk", Motion::Walk, &[at], &all[..1]) };
    let paces = args.budget_ms.iter().map(|&target_ms| pace(gpu, &quell(3 * args.frames), at, target_ms));
    let paces = paces.collect::<Result<Vec<_>>>()?;
    let views = views(gpu, &quell(args.frames), at)?;
    let report = MeasureReport {
        machine: Machine::of(gpu),
        power: [before, power_state()],
        growth: Growth::of(&walk, Method::Quell),
        walk,
        still,
        cut,
        at,
        views,
        paces,
    };
    write_json(&report, &args.out.join("measure.json"))?;
    let path = args.out.join("measure.html");
    std::fs::write(&path, page::page(&report))
        .with_context(|| format!("{}: cannot write", path.display()))?;
    Ok(report)
}

impl MeasureReport {
    /// What a terminal shows; the page has the rest.
    pub fn text(&self) -> String {
        let mut out = self.walk.text();
        out += &format!("\n{}\n", self.growth);
        for views in &self.views {
            out += &format!("{views}\n");
        }
        for pace in &self.paces {
            out += &format!("{pace}\n");
        }
        out
    }
}
