//! Whether a budget of time is kept, frame by frame, from the denoiser's first on.

use crate::bench::percentiles::Percentiles;
use crate::bench::stopwatch::Stopwatch;
use crate::bench::{BenchOptions, set_up, trace};
use crate::gpu::Gpu;
use crate::method::MethodFrame;
use anyhow::{Context, Result};
use quell::{Budget, Settings};
use serde::Serialize;
use std::fmt;

/// What of a target slow frames may take and still keep it.
const TOLERANCE: f64 = 1.1;
/// Share of the frames that may take longer.
const SLOW: f64 = 0.05;

/// What came of a budget of time.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Pace {
    pub target_ms: f32,
    /// Every frame, in order.
    pub frame_ms: Vec<f64>,
    /// Linear models, as far as is known when the frame is done.
    pub models: Vec<Option<u32>>,
    /// Of the last half of the frames.
    pub settled_ms: Percentiles,
    /// Frames until all but one in twenty of the rest are within a tenth of the target; none where half of them are not enough.
    pub settled_after: Option<usize>,
}

/// Denoises a walk under a budget of time.
pub fn pace(gpu: &Gpu, options: &BenchOptions, size: [u32; 2], target_ms: f32) -> Result<Pace> {
    let (walk, mut runners) = set_up(gpu, options, size)?;
    let runner = runners.first_mut().context("no method to pace")?;
    let stopwatch = Stopwatch::new(gpu, runner.passes().len());
    let settings = Settings::default().with_budget(Budget::Milliseconds(target_ms));
    let (mut frame_ms, mut models) = (Vec::new(), Vec::new());
    let mut measured_ms = None;
    for i in 0..options.frames {
        trace(gpu, &walk, i)?;
        let frame = MethodFrame::new(walk.gbuffer(), walk.view(i).camera, walk.is_cut(i), &settings);
        let time = stopwatch.measure(gpu, runner, &MethodFrame { measured_ms, ..frame })?;
        measured_ms = stopwatch.told_ms(&time);
        frame_ms.push(time.frame_ms);
        models.push(runner.models());
    }
    Ok(Pace::of(target_ms, frame_ms, models))
}

impl Pace {
    fn of(target_ms: f32, frame_ms: Vec<f64>, models: Vec<Option<u32>>) -> Self {
        let bound = TOLERANCE * f64::from(target_ms);
        let is_kept = |frames: &[f64]| {
            let slow = frames.iter().filter(|&&ms| ms > bound).count();
            slow as f64 <= SLOW * frames.len() as f64
        };
        let half = frame_ms.len() / 2;
        Self {
            target_ms,
            settled_ms: Percentiles::of(&frame_ms[half..]),
            settled_after: (0..=half).find(|&first| is_kept(&frame_ms[first..])),
            frame_ms,
            models,
        }
    }
}

impl fmt::Display for Pace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { target_ms, settled_ms: Percentiles { median, p95, .. }, .. } = self;
        write!(f, "budget of {target_ms} ms: median {median:.3}, p95 {p95:.3} ms at last; ")?;
        match self.settled_after {
            Some(frames) => write!(f, "kept after {frames} frames"),
            None => write!(f, "not kept"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_budget_is_kept_from_where_few_frames_are_slow() {
        let after = |frame_ms: &[f64]| Pace::of(1.0, frame_ms.to_vec(), vec![]).settled_after;
        assert_eq!(after(&[1.09; 40]), Some(0), "within a tenth");
        assert_eq!(after(&[1.11; 40]), None);
        assert_eq!(
            after(&[[2.0; 8], [0.9; 8], [0.9; 8], [0.9; 8], [0.9; 8]].concat()),
            Some(7),
            "one in 33 may be slow"
        );
        assert_eq!(after(&[[0.9; 15], [2.0; 15]].concat()), None, "at last it is lost");
        let pace = Pace::of(1.0, vec![3.0, 3.0, 0.75, 0.75], vec![]);
        assert_eq!(pace.settled_ms.median, 0.75);
        assert_eq!(
            pace.to_string(),
            "budget of 1 ms: median 0.750, p95 0.750 ms at last; kept after 2 frames"
        );
    }
}
