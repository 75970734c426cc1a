//! The command line.

use crate::method::Method;
use crate::replay::{ReplayOptions, replay};
use anyhow::Result;
use clap::{Args, Parser, Subcommand};
use std::io::Write;
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
    ///
    /// Writes `frame_0000.exr` (linear R, G, B), `frame_0000.png` (as shown) and so on. Where the capture has
    /// reference images, prints metrics and writes them to `metrics.json`.
    Replay(ReplayArgs),
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
    let text = match report {
        Some(report) => report.table(),
        None => format!("wrote {}; the capture has no reference images, so no metrics\n", args.out.display()),
    };
    // Not `print!`, which panics when the reader of a pipe has gone.
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(error.into()),
        _ => Ok(()),
    }
}
