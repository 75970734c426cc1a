//! What the driver tells of clocks and power.

use std::process::Command;

/// What to ask NVIDIA's driver.
const NVIDIA: &str = "name,driver_version,pstate,clocks.sm,clocks.mem,power.draw,power.limit,temperature.gpu";
/// Files of AMD's, under `/sys/class/drm/card*/device`.
const AMD: [&str; 3] = ["power_dpm_force_performance_level", "pp_dpm_sclk", "pp_dpm_mclk"];

/// As the driver words it; none where it tells nothing.
pub fn power_state() -> Option<String> {
    nvidia().or_else(amd)
}

fn nvidia() -> Option<String> {
    let query = [format!("--query-gpu={NVIDIA}"), "--format=csv".to_owned()];
    let output = Command::new("nvidia-smi").args(query).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    (output.status.success() && !text.trim().is_empty()).then(|| text.trim().to_owned())
}

fn amd() -> Option<String> {
    let cards = std::fs::read_dir("/sys/class/drm").ok()?.flatten();
    let tell = |card: std::path::PathBuf| {
        let lines = AMD.iter().filter_map(|file| {
            let text = std::fs::read_to_string(card.join("device").join(file)).ok()?;
            Some(format!(
                "{} {file}: {}",
                card.file_name()?.to_string_lossy(),
                text.trim().replace('\n', ", ")
            ))
        });
        lines.collect::<Vec<_>>()
    };
    let lines: Vec<_> = cards.flat_map(|card| tell(card.path())).collect();
    (!lines.is_empty()).then(|| lines.join("\n"))
}
