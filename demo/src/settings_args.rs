//! The denoiser's settings on the command line.

use clap::Args;
use quell::{Budget, Centres, Settings, Windows};

/// Overrides of [`Settings::default`], for comparisons.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Settings of the denoiser")]
pub struct SettingsArgs {
    /// Frames that history may count for, 1 to 1024; higher is smoother, lower follows changes sooner
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub max_history: Option<u16>,
    /// How windows are chosen: ring-error, mallows-cp, or fixed:1 to fixed:3
    #[arg(long, value_name = "RULE", value_parser = windows)]
    pub windows: Option<Windows>,
    /// Where models are placed: adaptive, or uniform:1 (dense), uniform:2, uniform:4
    #[arg(long, value_name = "RULE", value_parser = centres)]
    pub centres: Option<Centres>,
    /// Standard errors by which one sample may move its neighbourhood's mean; inf removes no firefly
    #[arg(long, value_name = "X", value_parser = firefly_limit)]
    pub firefly_limit: Option<f32>,
    /// Do not relight history when the light changes
    #[arg(long)]
    pub no_innovation: bool,
    /// Most models that a frame may fit; those of the coarsest level are always fitted
    #[arg(long, value_name = "N", conflicts_with = "budget_ms")]
    pub budget_models: Option<u32>,
    /// Milliseconds that a frame may take on the GPU, kept by the number of models and by savings
    #[arg(long, value_name = "MS", value_parser = crate::cli::positive)]
    pub budget_ms: Option<f32>,
    /// How many savings are taken, 0 to 2: bilinear history, sparse moments
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=quell::SAVINGS.len() as i64))]
    pub savings: Option<u32>,
    /// Show the models' prediction alone
    #[arg(long)]
    pub no_mix: bool,
}

impl SettingsArgs {
    /// The settings, with `far` as the sequence has it.
    pub fn settings(&self, far: f32) -> Settings {
        let defaults = Settings::default();
        defaults
            .with_far(far)
            .with_max_history(self.max_history.map_or(defaults.max_history, f32::from))
            .with_windows(self.windows.unwrap_or(defaults.windows))
            .with_centres(self.centres.unwrap_or(defaults.centres))
            .with_firefly_limit(self.firefly_limit.unwrap_or(defaults.firefly_limit))
            .with_innovation(!self.no_innovation)
            .with_mix_temporal_mean(!self.no_mix)
            .with_budget(self.budget())
            .with_savings(self.savings.unwrap_or(defaults.savings))
    }

    fn budget(&self) -> Budget {
        let time = self.budget_ms.map(Budget::Milliseconds);
        time.or(self.budget_models.map(Budget::Models)).unwrap_or_default()
    }
}

fn windows(text: &str) -> Result<Windows, String> {
    match text {
        "ring-error" => Ok(Windows::RingError),
        "mallows-cp" => Ok(Windows::MallowsCp),
        "fixed:1" => Ok(Windows::Fixed(1)),
        "fixed:2" => Ok(Windows::Fixed(2)),
        "fixed:3" => Ok(Windows::Fixed(3)),
        _ => Err("expected ring-error, mallows-cp, fixed:1, fixed:2 or fixed:3".to_owned()),
    }
}

fn centres(text: &str) -> Result<Centres, String> {
    match text {
        "adaptive" => Ok(Centres::Adaptive),
        "uniform:1" => Ok(Centres::Uniform(1)),
        "uniform:2" => Ok(Centres::Uniform(2)),
        "uniform:4" => Ok(Centres::Uniform(4)),
        _ => Err("expected adaptive, uniform:1, uniform:2 or uniform:4".to_owned()),
    }
}

fn firefly_limit(text: &str) -> Result<f32, String> {
    let limit = text.parse::<f32>().ok().filter(|&limit| limit > 0.0);
    limit.ok_or_else(|| "expected a number above 0, or inf".to_owned())
}
