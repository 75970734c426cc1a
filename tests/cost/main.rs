//! What a frame costs, as far as it can be known without a GPU, against the table `tests/cost.md`.
//!
//! `tests/cost.sh` writes the table. Where a figure got worse on purpose, run it and commit what it wrote.

mod compare;
mod driver;
mod page;
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod radv;
mod resources;
mod roofline;
mod shader;
mod table;
mod traffic;
mod work;

use shader::Shader;
use std::io::Write;
use std::sync::OnceLock;

const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/cost.md");
/// Set by `tests/cost.sh`.
const WRITE: &str = "QUELL_COST_WRITE";

/// Budgets of a frame: bytes that move per pixel, and MB that are held at 1920x1080 and at 2560x1440.
const MOST_TRAFFIC: f64 = 200.0;
const MOST_MEMORY: [(&str, &str, f64); 3] = [
    ("all", "MB at 1920x1080", 120.0),
    ("all", "MB at 2560x1440", 210.0),
    ("all of a split", "MB at 1920x1080", 190.0),
];

/// The table as it would be written now.
fn now() -> &'static str {
    static PAGE: OnceLock<String> = OnceLock::new();
    PAGE.get_or_init(|| page::page(&Shader::all()))
}

fn figure(section: &str, row: &str, column: &str) -> f64 {
    table::figures(now())[&(section.to_owned(), row.to_owned(), column.to_owned())]
}

#[test]
fn no_figure_is_worse_than_in_the_table() {
    let before = std::fs::read_to_string(PATH).unwrap_or_default();
    let verdict = compare::compare(&before, now());
    let problems: String = verdict.problems.iter().map(|problem| format!("  {problem}\n")).collect();
    let better: String = verdict.better.iter().map(|figure| format!("  {figure}\n")).collect();
    if let Some(skipped) = verdict.skipped {
        say(&skipped);
    }
    if std::env::var_os(WRITE).is_some() {
        assert!(driver::expected(), "the table is written on Linux on x86_64, where RADV is");
        std::fs::write(PATH, now()).unwrap();
        say(&format!("wrote {PATH}\nworse, new or gone:\n{problems}better:\n{better}"));
        let spills = verdict.problems.iter().any(|problem| matches!(problem, compare::Problem::Spill { .. }));
        assert!(!spills, "registers spill");
        return;
    }
    if !better.is_empty() {
        say(&format!("better than in the table, run tests/cost.sh to keep it so:\n{better}"));
    }
    assert!(
        problems.is_empty(),
        "cost grew, or kernels changed:\n{problems}run tests/cost.sh and commit tests/cost.md if it has to be"
    );
}

/// Also where the test passes, unlike `eprintln!`, which the harness keeps to itself.
fn say(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

#[test]
fn a_frame_moves_no_more_than_its_budget() {
    let bytes = figure("Traffic", "frame", "total");
    assert!(bytes <= MOST_TRAFFIC, "{bytes} bytes a pixel of {MOST_TRAFFIC}");
}

#[test]
fn a_denoiser_holds_no_more_than_its_budget() {
    for (row, size, most) in MOST_MEMORY {
        let held = figure("Memory", row, size);
        assert!(held <= most, "{row}: {held} {size} of {most}");
    }
}
