use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    match quell_demo::cli::run(quell_demo::cli::Cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            // The alternate form is the whole chain of causes on one line.
            eprintln!("error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
