//! The command line.

use crate::method::Method;
use crate::replay::{ReplayOptions, replay};
use anyhow::Result;
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Real-time denoising of path-traced frames
#[derive(Debug, Parser)]
#[command(name = "quell-demo", version, propagate_version = true)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Denoise a captured sequence
    Replay(ReplayArgs),
}

/// Denoises every frame of a capture, writes `frame_0000.exr` (linear R, G, B) and `frame_0000.png` (as shown) and so
/// on, and where the capture has reference images prints their metrics and writes them to `metrics.json`.
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
    /// Frames that history may count for, 1 to 1024; higher is smoother, lower follows changes sooner
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub max_history: Option<u16>,
}

/// Does what the command line says.
pub fn run(cli: Cli) -> Result<()> {
    match cli.command {
        Command::Replay(args) => run_replay(args),
    }
}

fn run_replay(args: ReplayArgs) -> Result<()> {
    let report = replay(&ReplayOptions {
        capture: args.capture,
        out: args.out.clone(),
        method: args.method,
        max_history: args.max_history.map(f32::from),
    })?;
    match report {
        Some(report) => print!("{}", report.table()),
        None => println!("wrote {}; the capture has no reference images, so no metrics", args.out.display()),
    }
    Ok(())
}
