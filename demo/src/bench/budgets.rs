//! What budgets of models and of time cost and keep: a capture over and over, under one budget after the other.

use super::machine::Machine;
use super::percentiles::Percentiles;
use super::stopwatch::{Clock, Stopwatch};
use super::wall_note;
use crate::capture::{CaptureReader, Frame, gbuffer_for, upload};
use crate::gbuffer::Split;
use crate::gpu::Gpu;
use crate::image::ImageRgb;
use crate::method::{Method, MethodFrame, MethodRunner};
use crate::quality::{QualityRecorder, write_json};
use crate::render::progress_bar;
use crate::split_args::SplitArgs;
use crate::table::aligned;
use anyhow::{Context, Result};
use quell::{Budget, SAVINGS, Settings, Statistics};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// `quell-demo budgets`
#[derive(Debug, Clone, clap::Args)]
pub struct BudgetsArgs {
    /// Folders of captures with reference images
    #[arg(value_name = "DIR", required = true)]
    pub captures: Vec<PathBuf>,
    /// Times that each capture is played under a budget of time; the last third is measured
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = clap::value_parser!(u32).range(3..=10_000))]
    pub rounds: u32,
    #[command(flatten)]
    pub split: SplitArgs,
    /// Folder for the results, created where needed
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

/// Of what a frame comes to without a budget, in percent.
const SHARES: [u32; 4] = [75, 50, 25, 0];
/// Likewise, of the time.
const TIME_SHARES: [u32; 5] = [100, 85, 70, 60, 50];
/// Rounds where nothing has to settle; the first two thirds only warm up.
const UNPACED_ROUNDS: u32 = 3;
/// Each round begins with a cut, whose frames take longer; what is measured is the steady state after it.
const CUT_FRAMES: usize = 4;

/// What `budgets.json` holds.
#[derive(Debug, Serialize)]
pub struct BudgetsReport {
    pub machine: Machine,
    pub clock: Clock,
    pub note: Option<&'static str>,
    pub rounds: u32,
    pub captures: Vec<CaptureReport>,
}

#[derive(Debug, Serialize)]
pub struct CaptureReport {
    pub capture: String,
    pub width: u32,
    pub height: u32,
    pub rows: Vec<Row>,
}

/// One budget.
#[derive(Debug, Clone, Serialize)]
pub struct Row {
    pub budget: String,
    /// Where the budget is one of time.
    pub target_ms: Option<f32>,
    /// Of the measured rounds.
    pub frame_ms: Percentiles,
    /// Of the last round, over the frames that have a reference.
    pub psnr_db: f64,
    pub tpsnr_db: Option<f64>,
    /// Means of the measured rounds.
    pub models: f64,
    pub models_kept: f64,
    pub savings: f64,
}

/// Runs all budgets on all captures. Leaves `budgets.json` and `budgets.md` in `out`.
pub fn budgets(gpu: &Gpu, args: &BudgetsArgs) -> Result<BudgetsReport> {
    let out = &args.out;
    std::fs::create_dir_all(out).with_context(|| format!("{}: cannot create the folder", out.display()))?;
    let captures = args.captures.iter().map(|folder| of_capture(gpu, folder, args));
    let captures = captures.collect::<Result<_>>()?;
    let clock = Stopwatch::new(gpu, 1).clock();
    let note = wall_note(gpu, clock);
    let report = BudgetsReport { machine: Machine::of(gpu), clock, note, rounds: args.rounds, captures };
    write_json(&report, &out.join("budgets.json"))?;
    let path = out.join("budgets.md");
    std::fs::write(&path, report.text()).with_context(|| format!("{}: cannot write", path.display()))?;
    Ok(report)
}

fn of_capture(gpu: &Gpu, folder: &Path, args: &BudgetsArgs) -> Result<CaptureReport> {
    let reader = CaptureReader::open(folder)?;
    let header = *reader.header();
    let frames = (0..reader.len()).map(|i| reader.read(i)).collect::<std::result::Result<Vec<_>, _>>()?;
    let played = Played { gpu, reader: &reader, frames: &frames, split: args.split.split() };
    let progress = progress_bar((1 + SHARES.len() + SAVINGS.len() + TIME_SHARES.len()) as u64, "budgets");
    let run = |name: String, settings: Settings, rounds| {
        let row = played.row(name, settings.with_far(header.far), rounds);
        progress.inc(1);
        row.with_context(|| folder.display().to_string())
    };
    let default = Settings::default();
    let full = run("unlimited".to_owned(), default, UNPACED_ROUNDS)?;
    let mut rows = vec![full.clone()];
    for share in SHARES {
        let models = (full.models * f64::from(share) / 100.0).round() as u32;
        let settings = default.with_budget(Budget::Models(models));
        rows.push(run(format!("{models} models, {share} %"), settings, UNPACED_ROUNDS)?);
    }
    for (savings, saving) in (1..).zip(SAVINGS) {
        // The first is taken before models are given up, the others after.
        let budget = if savings == 1 { Budget::Unlimited } else { Budget::Models(0) };
        let settings = default.with_budget(budget).with_savings(savings);
        let models = if budget == Budget::Unlimited { "all models" } else { "least models" };
        let name = format!("{saving}, {models}");
        rows.push(run(name, settings, UNPACED_ROUNDS)?);
    }
    for share in TIME_SHARES {
        let target_ms = (full.frame_ms.median * f64::from(share) / 100.0) as f32;
        rows.push(run(
            format!("{target_ms:.2} ms, {share} %"),
            default.with_budget(Budget::Milliseconds(target_ms)),
            args.rounds,
        )?);
    }
    progress.finish_and_clear();
    let capture = folder.file_name().unwrap_or(folder.as_os_str()).to_string_lossy().into_owned();
    Ok(CaptureReport { capture, width: header.width, height: header.height, rows })
}

/// A capture in memory.
struct Played<'a> {
    gpu: &'a Gpu,
    reader: &'a CaptureReader,
    frames: &'a [Frame],
    split: Split,
}

impl Played<'_> {
    fn row(&self, budget: String, settings: Settings, rounds: u32) -> Result<Row> {
        let gpu = self.gpu;
        let header = self.reader.header();
        let mut runner = MethodRunner::new(gpu, Method::Quell, header.width, header.height)?;
        let stopwatch = Stopwatch::new(gpu, runner.passes().len());
        let mut gbuffer = None;
        let mut quality = QualityRecorder::new();
        let (mut times_ms, mut counts): (Vec<f64>, Vec<Statistics>) = (vec![], vec![]);
        let mut measured_ms = None;
        for round in 0..rounds {
            for (i, capture) in self.frames.iter().enumerate() {
                let gbuffer = gbuffer.get_or_insert_with(|| gbuffer_for(&gpu.device, capture));
                upload(&gpu.device, &gpu.queue, capture, gbuffer);
                gpu.queue.submit([]);
                gpu.device.poll(wgpu::PollType::wait_indefinitely()).context("waiting for the upload")?;
                let info = self.reader.info(i);
                let frame = MethodFrame {
                    measured_ms,
                    split: self.split,
                    ..MethodFrame::new(gbuffer, info.camera(), info.restart || i == 0, &settings)
                };
                let time = stopwatch.measure(gpu, &mut runner, &frame)?;
                measured_ms = stopwatch.told_ms(&time);
                if 3 * round >= 2 * rounds && i >= CUT_FRAMES.min(self.frames.len() / 2) {
                    times_ms.push(time.frame_ms);
                    counts.extend(runner.statistics());
                }
                if round + 1 == rounds {
                    let image = ImageRgb::read_back(gpu, runner.output().texture())?;
                    quality.add(i, image, capture.reference_image(), &[])?;
                }
            }
        }
        let size = [header.width, header.height];
        let quality = quality.finish("", "", "", size).context("the capture has no reference images")?;
        let mean = |of: fn(&Statistics) -> u32| {
            counts.iter().map(|found| f64::from(of(found))).sum::<f64>() / counts.len() as f64
        };
        Ok(Row {
            budget,
            target_ms: match settings.budget {
                Budget::Milliseconds(target_ms) => Some(target_ms),
                _ => None,
            },
            frame_ms: Percentiles::of(&times_ms),
            psnr_db: quality.mean.metrics.psnr_db,
            tpsnr_db: quality.mean.tpsnr_db,
            models: mean(Statistics::models),
            models_kept: mean(|found| found.models_kept),
            savings: mean(|found| found.savings),
        })
    }
}

impl BudgetsReport {
    /// All tables, for a terminal and as Markdown.
    pub fn text(&self) -> String {
        let mut out = format!("{}", self.machine);
        out += &self.note.map(|note| format!("- note: {note}\n")).unwrap_or_default();
        for capture in &self.captures {
            let CaptureReport { capture: name, width, height, .. } = capture;
            out += &format!("\n{name}, {width}x{height}:\n\n{}", aligned(&capture.table(), 1));
        }
        out
    }
}

impl CaptureReport {
    fn table(&self) -> Vec<Vec<String>> {
        let headings =
            ["budget", "median ms", "p95", "p95 / budget", "PSNR", "tPSNR", "models", "kept", "savings"];
        let mut rows = vec![headings.map(str::to_owned).to_vec()];
        rows.extend(self.rows.iter().map(|row| {
            let share = row.target_ms.map(|target| format!("{:.2}", row.frame_ms.p95 / f64::from(target)));
            vec![
                row.budget.clone(),
                format!("{:.2}", row.frame_ms.median),
                format!("{:.2}", row.frame_ms.p95),
                share.unwrap_or_else(|| "-".to_owned()),
                format!("{:.2}", row.psnr_db),
                row.tpsnr_db.map_or("-".to_owned(), |tpsnr| format!("{tpsnr:.2}")),
                format!("{:.0}", row.models),
                format!("{:.0}", row.models_kept),
                format!("{:.1}", row.savings),
            ]
        }));
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_budgets_of_time_are_compared_with_their_target() {
        let row = |budget: &str, target_ms| Row {
            budget: budget.to_owned(),
            target_ms,
            frame_ms: Percentiles { median: 3.8, p95: 4.2, p99: 4.4 },
            psnr_db: 30.0,
            tpsnr_db: None,
            models: 100.0,
            models_kept: 12.0,
            savings: 1.0,
        };
        let rows = vec![row("unlimited", None), row("4 ms", Some(4.0))];
        let table = CaptureReport { capture: "x".to_owned(), width: 8, height: 8, rows }.table();
        assert_eq!(table[1], ["unlimited", "3.80", "4.20", "-", "30.00", "-", "100", "12", "1.0"]);
        assert_eq!(table[2][3], "1.05");
    }
}
