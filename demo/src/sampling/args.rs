//! `quell-demo sampling` on the command line.

use super::SamplingOptions;
use crate::cli::{finite, samples_per_pixel};
use crate::split_args::SplitArgs;
use clap::Args;
use std::path::PathBuf;

/// `quell-demo sampling`
#[derive(Debug, Args)]
pub struct SamplingArgs {
    /// Folder of a capture of the walk, made by `record`, with references of its first four frames and of later ones
    pub capture: PathBuf,
    /// The glTF 2.0 file that was recorded, if it was not the built-in gallery
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Scene time that the recording began at, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = finite)]
    pub start: f32,
    /// Samples per pixel, in the mean; may be given several times
    #[arg(long, value_name = "LIST", value_delimiter = ',', default_values_t = [0.25, 0.5, 1.0, 2.0],
          value_parser = samples_per_pixel)]
    pub spp: Vec<f32>,
    /// Walks with independent noise over which all figures are averaged
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=64))]
    pub runs: u32,
    /// Another seed gives other noise
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u32,
    #[command(flatten)]
    pub split: SplitArgs,
    /// Folder for the results, created where needed
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
}

impl SamplingArgs {
    pub fn options(self) -> SamplingOptions {
        let Self { capture, scene, start, spp, runs, seed, split, out } = self;
        SamplingOptions { capture, scene, start_s: start, spp, runs, seed, split: split.split(), out }
    }
}
