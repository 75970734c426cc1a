//! `quell-demo still` on the command line.

use super::StillOptions;
use crate::cli::{finite, positive, size};
use crate::split_args::SplitArgs;
use crate::tracer::Sampling;
use clap::Args;
use std::path::PathBuf;

/// `quell-demo still`
#[derive(Debug, Args)]
pub struct StillArgs {
    /// A glTF 2.0 file (.gltf or .glb) to show instead of the built-in gallery
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Width and height in pixels
    #[arg(long, value_name = "WxH", default_value = "320x180", value_parser = size)]
    pub size: [u32; 2],
    /// Scene time, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = finite)]
    pub start: f32,
    /// Samples per pixel to spend, in the mean
    #[arg(long, value_name = "N", default_value_t = 32.0, value_parser = positive)]
    pub spp: f32,
    /// Stop after so many seconds, though samples are left
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub time: Option<f32>,
    /// Stop once the expected relative mean squared error is so low
    #[arg(long, value_name = "ERROR", value_parser = positive)]
    pub target_error: Option<f32>,
    /// Where the samples go after the first four of each pixel
    #[arg(long, value_enum, default_value_t = Sampling::Adaptive)]
    pub sampling: Sampling,
    /// Also trace a reference of so many samples per pixel, and compare adaptive with uniform sampling by it
    #[arg(long, value_name = "SPP", default_value_t = 0)]
    pub reference: u32,
    /// Another seed gives other noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    #[command(flatten)]
    pub split: SplitArgs,
    /// Folder for the results, created where needed
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

impl StillArgs {
    pub fn options(self) -> StillOptions {
        let [width, height] = self.size;
        StillOptions {
            scene: self.scene,
            width,
            height,
            start_s: self.start,
            spp: self.spp,
            time_s: self.time,
            target_error: self.target_error.map(f64::from),
            sampling: self.sampling,
            reference_spp: self.reference,
            seed: self.seed,
            split: self.split.split(),
            out: self.out,
        }
    }
}
