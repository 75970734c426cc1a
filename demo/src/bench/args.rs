//! `quell-demo bench` on the command line.

use super::{BenchOptions, Motion};
use crate::cli::{finite, size};
use crate::method::Method;
use crate::settings_args::SettingsArgs;
use crate::split_args::SplitArgs;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// `quell-demo bench`
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// A glTF 2.0 file (.gltf or .glb) to walk through instead of the built-in gallery
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Width and height in pixels; may be given several times [default: 1280x720, 1920x1080 and 2560x1440 on a GPU,
    /// 320x180 on a CPU]
    #[arg(long, value_name = "WxH", value_delimiter = ',', value_parser = size)]
    pub size: Vec<[u32; 2]>,
    /// Number of timed frames
    #[arg(long, value_name = "N", default_value_t = 120, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub frames: u32,
    /// Untimed frames before them: pipelines compile in the first, and history fills
    #[arg(long, value_name = "N", default_value_t = 32, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    pub warm_up: u32,
    /// Scene time of the first frame, seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 0.0, value_parser = finite)]
    pub start: f32,
    /// What moves from frame to frame
    #[arg(long, value_enum, default_value_t = Motion::Walk)]
    pub motion: Motion,
    /// Samples per pixel
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1024))]
    pub spp: u32,
    /// What to time; may be given several times [default: all but none]
    #[arg(long, value_enum, value_delimiter = ',')]
    pub method: Vec<Method>,
    /// The method that ratios are to [default: svgf where it is timed, otherwise the first but quell]
    #[arg(long, value_enum)]
    pub baseline: Option<Method>,
    #[command(flatten)]
    pub split: SplitArgs,
    #[command(flatten)]
    pub settings: SettingsArgs,
    /// Folder for the results, created where needed
    #[arg(long, value_name = "DIR", required_unless_present = "compare")]
    pub out: Option<PathBuf>,
    /// Time nothing, but compare the results of two earlier runs
    #[arg(long, value_names = ["A.json", "B.json"], num_args = 2, exclusive = true)]
    pub compare: Option<Vec<PathBuf>>,
}

impl BenchArgs {
    pub fn options(self) -> BenchOptions {
        let all = Method::value_variants().iter().copied().filter(|&method| method != Method::None);
        let mut methods: Vec<Method> = Vec::new();
        for method in if self.method.is_empty() { all.collect() } else { self.method } {
            if !methods.contains(&method) {
                methods.push(method);
            }
        }
        BenchOptions {
            scene: self.scene,
            sizes: self.size,
            frames: self.frames,
            warm_up: self.warm_up,
            start_s: self.start,
            motion: self.motion,
            spp: self.spp,
            methods,
            baseline: self.baseline,
            split: self.split.split(),
            settings: self.settings.settings(f32::INFINITY),
            out: self.out.expect("demanded of all that time"),
        }
    }
}
