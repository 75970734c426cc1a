//! `quell-demo report` on the command line.

use super::{ReportOptions, report};
use crate::cli::{positive, size};
use crate::gpu::Gpu;
use crate::method::Method;
use crate::split_args::SplitArgs;
use crate::walk::References;
use anyhow::{Result, ensure};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// `quell-demo report`
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// A glTF 2.0 file (.gltf or .glb) to add to the suite
    #[arg(long = "scene", value_name = "FILE")]
    pub scenes: Vec<PathBuf>,
    /// A folder with a capture to add to the suite; its frames with a reference are measured
    #[arg(long = "capture", value_name = "DIR")]
    pub captures: Vec<PathBuf>,
    /// Leave the built-in gallery's stretches out
    #[arg(long)]
    pub no_gallery: bool,
    /// Methods to compare, e.g. quell,accumulate [default: all]; the noisy input is always shown
    #[arg(long = "method", value_enum, value_name = "LIST", value_delimiter = ',')]
    pub methods: Vec<Method>,
    /// Width and height in pixels of what is traced [default: 320x180, with --quick 160x90]
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub size: Option<[u32; 2]>,
    /// Number of frames of what is traced [default: 24, with --quick 10]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub frames: Option<u32>,
    /// Frames per second of scene time of what is traced
    #[arg(long, value_name = "F", default_value_t = 15.0, value_parser = positive)]
    pub fps: f32,
    /// Samples per pixel of the reference images of what is traced [default: 256, with --quick 32]
    #[arg(long, value_name = "SPP", value_parser = clap::value_parser!(u32).range(1..))]
    pub reference: Option<u32>,
    /// Frames that get a reference, e.g. 8,9,20 [default: four pairs spread over each stretch, and those about a light's switch]
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub reference_frames: Option<Vec<u32>>,
    /// Small and short: some seconds on a GPU, some minutes on a CPU
    #[arg(long)]
    pub quick: bool,
    #[command(flatten)]
    pub split: SplitArgs,
    /// Folder for the results, created where needed
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

impl ReportArgs {
    /// Makes the report; returns what to tell.
    pub fn run(self) -> Result<String> {
        let page = self.out.join(super::PAGE);
        let report = report(Gpu::new, &self.options()?)?;
        Ok(format!("{}wrote {}\n", report.summary_text(), page.display()))
    }

    fn options(self) -> Result<ReportOptions> {
        let or = |value: Option<u32>, usual: u32, quick: u32| {
            value.unwrap_or(if self.quick { quick } else { usual })
        };
        let is_empty = self.no_gallery && self.scenes.is_empty() && self.captures.is_empty();
        ensure!(!is_empty, "nothing to report on: --no-gallery needs a --scene or a --capture");
        Ok(ReportOptions {
            size: self.size.unwrap_or(if self.quick { [160, 90] } else { [320, 180] }),
            frames: or(self.frames, 24, 10),
            references: References { spp: or(self.reference, 256, 32), frames: self.reference_frames },
            fps: self.fps,
            methods: compared(&self.methods),
            gallery: !self.no_gallery,
            scenes: self.scenes,
            captures: self.captures,
            split: self.split.split(),
            out: self.out,
        })
    }
}

/// The methods in the order in which they are listed everywhere; the noisy input is one.
fn compared(chosen: &[Method]) -> Vec<Method> {
    let is_compared =
        |method: &Method| chosen.is_empty() || chosen.contains(method) || *method == Method::None;
    Method::value_variants().iter().copied().filter(is_compared).collect()
}
