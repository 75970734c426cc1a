//! The columns of the tables: what is measured, and which way is better.

use super::numbers::{MethodNumbers, is_denoiser};

/// One measure.
pub struct Column {
    /// As in `report.json`.
    pub key: &'static str,
    pub title: &'static str,
    pub unit: &'static str,
    pub higher_is_better: bool,
    decimals: usize,
    value: fn(&MethodNumbers) -> Option<f64>,
}

const fn column(
    [key, title, unit]: [&'static str; 3],
    higher_is_better: bool,
    decimals: usize,
    value: fn(&MethodNumbers) -> Option<f64>,
) -> Column {
    Column { key, title, unit, higher_is_better, decimals, value }
}

pub const COLUMNS: [Column; 8] = [
    column(["psnr_db", "PSNR", "dB"], true, 2, |n| Some(n.quality.metrics.psnr_db)),
    column(["reflective_psnr_db", "reflective", "dB"], true, 2, |n| n.quality.metrics.reflective_psnr_db),
    column(["ssim", "SSIM", ""], true, 4, |n| Some(n.quality.metrics.ssim)),
    column(["flip", "FLIP", ""], false, 4, |n| Some(n.quality.metrics.flip)),
    column(["relative_mse", "rel. MSE", ""], false, 4, |n| Some(n.quality.metrics.relative_mse)),
    column(["tpsnr_db", "tPSNR", "dB"], true, 2, |n| n.quality.tpsnr_db),
    column(["ms", "time", "ms"], false, 2, |n| Some(n.ms)),
    column(["memory_mb", "memory", "MB"], false, 1, |n| Some(n.memory_mb)),
];

impl Column {
    /// The value as in tables.
    pub fn text(&self, numbers: &MethodNumbers) -> String {
        match (self.value)(numbers) {
            Some(value) if value.is_infinite() => "∞".to_owned(),
            Some(value) => format!("{value:.*}", self.decimals),
            None => "–".to_owned(),
        }
    }

    /// By how much `ours` is better; none where either has no finite value.
    pub fn gain(&self, ours: &MethodNumbers, rival: &MethodNumbers) -> Option<f64> {
        let difference = (self.value)(ours)? - (self.value)(rival)?;
        let gain = if self.higher_is_better { difference } else { -difference };
        gain.is_finite().then_some(gain)
    }

    /// A gain as in tables, always with a sign.
    pub fn gain_text(&self, gain: f64) -> String {
        if self.steps(gain) == 0.0 {
            return format!("{:.*}", self.decimals, 0.0);
        }
        format!("{gain:+.*}", self.decimals).replace('-', "−")
    }

    /// Whether a table shows the gain as below 0.
    pub fn is_loss(&self, gain: f64) -> bool {
        self.steps(gain) < 0.0
    }

    /// In units of the last decimal.
    fn steps(&self, gain: f64) -> f64 {
        (gain * 10f64.powi(self.decimals as i32)).round()
    }

    /// The best denoiser's number as in tables, which several may share; the noisy input does not compete.
    pub fn best<'a>(&self, rows: impl Iterator<Item = &'a MethodNumbers>) -> Option<String> {
        let rows = rows.filter(|row| is_denoiser(row.method) && (self.value)(row).is_some());
        let better = |a: &&MethodNumbers, b: &&MethodNumbers| {
            let [a, b] = [a, b].map(|row| (self.value)(row).unwrap_or(f64::NAN));
            if self.higher_is_better { a.total_cmp(&b) } else { b.total_cmp(&a) }
        };
        rows.max_by(better).map(|row| self.text(row))
    }
}
