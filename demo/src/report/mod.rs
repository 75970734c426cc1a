//! All methods on a suite of sequences, as one page that shows where each is better, and as numbers.

mod args;
mod clock;
mod columns;
mod error_map;
mod events;
mod measure;
mod numbers;
mod page;
mod plot;
mod stretch;
mod tables;

pub use args::ReportArgs;
pub use numbers::SuiteReport;

use crate::capture::CaptureReader;
use crate::gbuffer::Split;
use crate::gpu::Gpu;
use crate::method::Method;
use crate::quality::write_json;
use crate::render::progress_bar;
use crate::walk::References;
use anyhow::{Context, Result};
use std::path::PathBuf;

/// The page's name in the folder of results.
pub const PAGE: &str = "report.html";

/// What to report on.
#[derive(Debug, Clone)]
pub struct ReportOptions {
    /// With the built-in gallery's stretches.
    pub gallery: bool,
    /// glTF files.
    pub scenes: Vec<PathBuf>,
    /// Folders of captures.
    pub captures: Vec<PathBuf>,
    /// Size, number of frames and frames per second of what is traced.
    pub size: [u32; 2],
    pub frames: u32,
    pub fps: f32,
    /// Of what is traced. Without frames, those about a light's switch join the ones that are spread.
    pub references: References,
    /// In the order of tables; the noisy input among them.
    pub methods: Vec<Method>,
    /// What quell gets apart, of captures as far as they have it.
    pub split: Split,
    /// Folder for the results, created where needed.
    pub out: PathBuf,
}

/// Makes the report. Leaves `report.html` and `report.json` in `out`.
pub fn report(gpu: impl FnOnce() -> Result<Gpu>, options: &ReportOptions) -> Result<SuiteReport> {
    // Everything that can be wrong with the arguments comes before the GPU is touched.
    options.references.chosen(options.frames)?;
    let open = |folder: &PathBuf| Ok((folder.clone(), CaptureReader::open(folder)?));
    let captures = options.captures.iter().map(open).collect::<Result<_>>()?;
    std::fs::create_dir_all(&options.out)
        .with_context(|| format!("{}: cannot create the folder", options.out.display()))?;

    let gpu = gpu()?;
    let suite = stretch::open(&gpu, options, captures)?;
    let progress = progress_bar(suite.iter().map(stretch::Stretch::steps).sum(), "reporting");
    let mut clock_used = "";
    let (mut reports, mut pictures) = (Vec::new(), Vec::new());
    for mut stretch in suite {
        let measured = measure::measure(&gpu, &mut stretch, &options.methods, &progress)
            .with_context(|| stretch.name.clone())?;
        clock_used = measured.clock;
        reports.push(measured.report);
        pictures.push(measured.pictures);
    }
    progress.finish_and_clear();

    let is_cpu = gpu.adapter.get_info().device_type == wgpu::DeviceType::Cpu;
    let report = SuiteReport::new(gpu.description(), is_cpu, clock_used, &options.methods, reports);
    write_json(&report, &options.out.join("report.json"))?;
    let path = options.out.join(PAGE);
    std::fs::write(&path, page::page(&report, &pictures)?)
        .with_context(|| format!("{}: cannot write", path.display()))?;
    Ok(report)
}
