//! What the report found: the content of `report.json`, and all numbers of the page.

use super::columns::{COLUMNS, Column};
use super::events::Event;
use crate::method::Method;
use crate::quality::{FrameReport, MeanReport};
use crate::study::Rect;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write;

/// What `report.json` holds. Infinite values (equal images) are `null`.
#[derive(Debug, Clone, Serialize)]
pub struct SuiteReport {
    pub adapter: String,
    /// Times on a CPU say nothing about a GPU.
    pub is_cpu: bool,
    /// What `ms` is.
    pub clock: &'static str,
    pub stretches: Vec<StretchReport>,
    /// Means over the stretches.
    pub summary: Vec<MethodNumbers>,
    pub margins: Vec<Margin>,
}

/// One sequence that all methods denoised.
#[derive(Debug, Clone, Serialize)]
pub struct StretchReport {
    pub name: String,
    /// Where its frames come from.
    pub source: String,
    pub width: u32,
    pub height: u32,
    pub frames: u32,
    pub events: Vec<Event>,
    /// Frames whose images the page holds.
    pub shown: Vec<ShownFrame>,
    pub methods: Vec<MethodReport>,
}

/// A frame that the page shows.
#[derive(Debug, Clone, Serialize)]
pub struct ShownFrame {
    pub frame: u32,
    pub label: String,
    /// Enlarged parts.
    pub crops: Vec<Rect>,
}

#[derive(Debug, Clone, Serialize)]
pub struct MethodReport {
    #[serde(flatten)]
    pub numbers: MethodNumbers,
    /// Frames with a reference, in order.
    pub frames: Vec<FrameReport>,
}

/// All numbers of a method, on one stretch or as means over all.
#[derive(Debug, Clone, Serialize)]
pub struct MethodNumbers {
    /// See [`Method::name`].
    pub method: &'static str,
    /// Means over frames.
    #[serde(flatten)]
    pub quality: MeanReport,
    /// Median over frames, milliseconds.
    pub ms: f64,
    /// Held on the GPU besides inputs and output, 10^6 bytes.
    pub memory_mb: f64,
}

/// By how much quell is better than another denoiser.
#[derive(Debug, Clone, Serialize)]
pub struct Margin {
    pub rival: &'static str,
    /// The stretch's name; none for the means over all.
    pub stretch: Option<String>,
    /// Per column, in its unit: above 0 where quell is better, whichever way is better.
    pub gains: BTreeMap<&'static str, f64>,
    /// Columns in which the rival wins.
    pub lost: Vec<&'static str>,
}

/// Not a rival: what all start from.
pub const NOISY: &str = "none";

pub fn is_denoiser(method: &str) -> bool {
    method != NOISY
}

/// The name as a reader sees it.
pub fn label(method: &str) -> &str {
    if is_denoiser(method) { method } else { "noisy" }
}

impl SuiteReport {
    pub fn new(
        adapter: String,
        is_cpu: bool,
        clock: &'static str,
        methods: &[Method],
        stretches: Vec<StretchReport>,
    ) -> Self {
        let summary: Vec<MethodNumbers> = methods
            .iter()
            .map(|method| {
                let all = || stretches.iter().filter_map(|stretch| numbers(stretch, method.name()));
                let mean =
                    |value: fn(&MethodNumbers) -> f64| all().map(value).sum::<f64>() / all().count() as f64;
                MethodNumbers {
                    method: method.name(),
                    quality: MeanReport::of(all().map(|n| (n.quality.metrics, n.quality.tpsnr_db))),
                    ms: mean(|n| n.ms),
                    memory_mb: mean(|n| n.memory_mb),
                }
            })
            .collect();
        let margins = margins(&stretches, &summary);
        Self { adapter, is_cpu, clock, stretches, summary, margins }
    }

    /// The means, for a terminal.
    pub fn summary_text(&self) -> String {
        let mut out = format!("{:<12}", "method");
        for Column { title, unit, .. } in &COLUMNS {
            let heading = if unit.is_empty() { (*title).to_owned() } else { format!("{title}, {unit}") };
            let _ = write!(out, "{heading:>12}");
        }
        for row in &self.summary {
            let _ = write!(out, "\n{:<12}", label(row.method));
            COLUMNS.iter().for_each(|column| {
                let _ = write!(out, "{:>12}", column.text(row));
            });
        }
        let _ = writeln!(
            out,
            "\nmeans of {} stretches, on {}; {}",
            self.stretches.len(),
            self.adapter,
            self.clock
        );
        out
    }
}

fn numbers<'a>(stretch: &'a StretchReport, method: &str) -> Option<&'a MethodNumbers> {
    stretch.methods.iter().map(|report| &report.numbers).find(|numbers| numbers.method == method)
}

fn margins(stretches: &[StretchReport], summary: &[MethodNumbers]) -> Vec<Margin> {
    let ours = Method::Quell.name();
    let rivals = summary.iter().map(|row| row.method).filter(|name| *name != ours && is_denoiser(name));
    let between = |rows: &[&MethodNumbers], rival: &'static str, stretch: Option<String>| {
        let find = |name: &str| rows.iter().find(|row| row.method == name);
        let (quell, other) = (find(ours)?, find(rival)?);
        let gains: BTreeMap<_, _> =
            COLUMNS.iter().filter_map(|column| Some((column.key, column.gain(quell, other)?))).collect();
        let lost = COLUMNS.iter().filter(|c| gains.get(c.key).is_some_and(|gain| c.is_loss(*gain)));
        let lost = lost.map(|column| column.key).collect();
        Some(Margin { rival, stretch, gains, lost })
    };
    let mut out = Vec::new();
    for rival in rivals {
        out.extend(between(&summary.iter().collect::<Vec<_>>(), rival, None));
        for stretch in stretches {
            let rows: Vec<_> = stretch.methods.iter().map(|method| &method.numbers).collect();
            out.extend(between(&rows, rival, Some(stretch.name.clone())));
        }
    }
    out
}
