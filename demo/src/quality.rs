//! Quality of a sequence: metrics per frame, their means, a table and `metrics.json`.

use crate::image::ImageRgb;
use crate::metrics::{FrameMetrics, MetricError, compare_reflective, temporal_psnr};
use anyhow::{Context, Result};
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// Metrics of one frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct FrameReport {
    /// Number of the frame, from 0.
    pub frame: usize,
    #[serde(flatten)]
    pub metrics: FrameMetrics,
    /// Missing where the previous frame has no reference; `null` in JSON where it is infinite.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tpsnr_db: Option<f64>,
}

/// Means over the frames that have the value.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MeanReport {
    #[serde(flatten)]
    pub metrics: FrameMetrics,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tpsnr_db: Option<f64>,
}

/// What `metrics.json` holds. Infinite values (equal images) are `null`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct QualityReport {
    /// What was denoised: a capture's folder, a scene.
    pub source: String,
    pub method: String,
    /// The GPU that it ran on.
    pub adapter: String,
    pub width: u32,
    pub height: u32,
    pub mean: MeanReport,
    /// Linear models per frame, where the method has any; a mean over all frames.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub models: Option<f64>,
    /// Frames with a reference, in order.
    pub frames: Vec<FrameReport>,
}

/// Measures the frames of a sequence as they come.
#[derive(Debug, Default)]
pub struct QualityRecorder {
    frames: Vec<FrameReport>,
    /// Image and reference of the frame before, where it had one.
    previous: Option<(ImageRgb, ImageRgb)>,
    /// Linear models of each frame that told.
    models: Vec<f64>,
}

impl QualityRecorder {
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds what a frame came to, where the method tells.
    pub fn add_models(&mut self, models: Option<u32>) {
        self.models.extend(models.map(f64::from));
    }

    /// Adds the next frame of the sequence; without a reference it only interrupts the temporal metric. `reflective` says of each
    /// pixel whether its surface is, and may be empty.
    pub fn add(
        &mut self,
        frame: usize,
        image: ImageRgb,
        reference: Option<ImageRgb>,
        reflective: &[bool],
    ) -> Result<(), MetricError> {
        let Some(reference) = reference else {
            self.previous = None;
            return Ok(());
        };
        let metrics = compare_reflective(&image, &reference, reflective)?;
        let tpsnr_db = match &self.previous {
            Some((i, r)) => Some(temporal_psnr(i, &image, r, &reference)?),
            None => None,
        };
        self.frames.push(FrameReport { frame, metrics, tpsnr_db });
        self.previous = Some((image, reference));
        Ok(())
    }

    /// The frames that had a reference.
    pub fn into_frames(self) -> Vec<FrameReport> {
        self.frames
    }

    /// The report, or none where no frame had a reference.
    pub fn finish(self, source: &str, method: &str, adapter: &str, size: [u32; 2]) -> Option<QualityReport> {
        if self.frames.is_empty() {
            return None;
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        Some(QualityReport {
            source: source.to_owned(),
            method: method.to_owned(),
            adapter: adapter.to_owned(),
            width: size[0],
            height: size[1],
            mean: MeanReport::of(self.frames.iter().map(|frame| (frame.metrics, frame.tpsnr_db))),
            models: (!self.models.is_empty()).then(|| mean(&self.models)),
            frames: self.frames,
        })
    }
}

impl MeanReport {
    /// Each metric's mean over what has it.
    pub fn of(values: impl Iterator<Item = (FrameMetrics, Option<f64>)> + Clone) -> Self {
        let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
        let mean_of = |value: fn(&FrameMetrics) -> f64| {
            mean(values.clone().map(|(metrics, _)| value(&metrics)).collect())
        };
        let mean_if_any = |values: Vec<f64>| (!values.is_empty()).then(|| mean(values));
        let reflective = values.clone().filter_map(|(metrics, _)| metrics.reflective_psnr_db).collect();
        let tpsnr = values.clone().filter_map(|(_, tpsnr_db)| tpsnr_db).collect();
        Self {
            metrics: FrameMetrics {
                psnr_db: mean_of(|m| m.psnr_db),
                reflective_psnr_db: mean_if_any(reflective),
                ssim: mean_of(|m| m.ssim),
                flip: mean_of(|m| m.flip),
                relative_mse: mean_of(|m| m.relative_mse),
                bias_percent: mean_of(|m| m.bias_percent),
            },
            tpsnr_db: mean_if_any(tpsnr),
        }
    }
}

impl QualityReport {
    /// One line per frame and the means, for a terminal.
    pub fn table(&self) -> String {
        let mut out = format!("{:>6}{HEADINGS}", "frame");
        for frame in &self.frames {
            let _ = write!(out, "{:>6}{}", frame.frame, columns(&frame.metrics, frame.tpsnr_db));
        }
        let _ = write!(out, "{:>6}{}", "mean", columns(&self.mean.metrics, self.mean.tpsnr_db));
        if let Some(models) = self.models {
            let pixels = f64::from(self.width) * f64::from(self.height);
            let _ = writeln!(out, "{models:.0} models a frame, one per {:.1} pixels", pixels / models);
        }
        out
    }

    pub fn write_json(&self, path: &Path) -> Result<()> {
        write_json(self, path)
    }
}

/// Headings of [`columns`].
pub const HEADINGS: &str = "     PSNR     SSIM     FLIP       rMSE  bias, %    tPSNR reflective\n";

/// The metrics of one line of a table, after its label.
pub fn columns(m: &FrameMetrics, tpsnr_db: Option<f64>) -> String {
    let decibels = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.2}"));
    let FrameMetrics { psnr_db, reflective_psnr_db, ssim, flip, relative_mse, bias_percent } = m;
    let (tpsnr, reflective) = (decibels(tpsnr_db), decibels(*reflective_psnr_db));
    format!(
        " {psnr_db:>8.2} {ssim:>8.4} {flip:>8.4} {relative_mse:>10.5} {bias_percent:>8.2} {tpsnr:>8} {reflective:>10}\n"
    )
}

/// The value in the middle of a sorted list.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// Writes a report as indented JSON.
pub fn write_json(report: &impl Serialize, path: &Path) -> Result<()> {
    let text = serde_json::to_string_pretty(report)? + "\n";
    std::fs::write(path, text).with_context(|| format!("{}: cannot write", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(value: f32) -> ImageRgb {
        ImageRgb::from_fn(12, 12, |_, _| [value; 3])
    }

    #[test]
    fn means_skip_what_is_missing_and_json_stays_valid() {
        let mut recorder = QualityRecorder::new();
        recorder.add(0, grey(0.5), Some(grey(0.6)), &[]).unwrap();
        recorder.add(1, grey(0.5), None, &[]).unwrap();
        recorder.add(2, grey(0.7), Some(grey(0.6)), &[]).unwrap();
        recorder.add(3, grey(0.7), Some(grey(0.6)), &[]).unwrap();
        let report = recorder.finish("test", "none", "cpu", [12, 12]).unwrap();
        let with_tpsnr: Vec<_> = report.frames.iter().filter(|f| f.tpsnr_db.is_some()).collect();
        assert_eq!(with_tpsnr.len(), 1, "only frame 3 follows a frame with a reference");
        assert_eq!(with_tpsnr[0].frame, 3);
        let sum: f64 = report.frames.iter().map(|f| f.metrics.psnr_db).sum();
        assert!((report.mean.metrics.psnr_db - sum / 3.0).abs() < 1e-12);

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("metrics.json");
        report.write_json(&path).unwrap();
        let json: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
        assert_eq!(json["frames"].as_array().unwrap().len(), 3);
        assert!(json["frames"][0].get("tpsnr_db").is_none());
        assert!(json["frames"][2]["tpsnr_db"].is_null(), "no change in either: infinite");
        assert_eq!(report.table().lines().count(), 5);
    }

    #[test]
    fn the_median_is_in_the_middle() {
        assert_eq!(median(vec![]), None);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
    }

    #[test]
    fn no_reference_no_report() {
        let mut recorder = QualityRecorder::new();
        recorder.add(0, grey(0.5), None, &[]).unwrap();
        assert!(recorder.finish("test", "none", "cpu", [12, 12]).is_none());
    }
}
