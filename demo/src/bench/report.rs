//! What a benchmark found: the content of `bench.json`, and its tables.

use super::Motion;
use super::machine::Machine;
use super::percentiles::Percentiles;
use super::stopwatch::{Clock, FrameTime};
use crate::table::aligned;
use quell::Allocation;
use serde::Serialize;
use std::fmt::Write;

/// What `bench.json` holds. Times are in milliseconds; what cannot be told is `null`.
#[derive(Debug, Clone, Serialize)]
pub struct BenchReport {
    pub machine: Machine,
    /// What `frame_ms` is read from.
    pub clock: Clock,
    /// What to know about the clock.
    pub note: Option<&'static str>,
    pub scene: String,
    pub start_s: f32,
    pub motion: Motion,
    /// quell's, where they are not the default.
    pub settings: Option<String>,
    pub spp: u32,
    /// Untimed frames before the timed ones.
    pub warm_up: u32,
    pub frames: u32,
    /// The method that ratios are to.
    pub baseline: &'static str,
    pub sizes: Vec<SizeReport>,
    pub skipped: Vec<SkippedSize>,
}

/// A size that the adapter cannot do.
#[derive(Debug, Clone, Serialize)]
pub struct SkippedSize {
    pub width: u32,
    pub height: u32,
    pub reason: String,
}

/// All methods at one size; they took turns frame by frame.
#[derive(Debug, Clone, Serialize)]
pub struct SizeReport {
    pub width: u32,
    pub height: u32,
    pub methods: Vec<MethodReport>,
}

#[derive(Debug, Clone, Serialize)]
pub struct MethodReport {
    pub method: &'static str,
    pub frame_ms: Percentiles,
    /// Median over the baseline's.
    pub ratio: Option<f64>,
    /// What the thread that encodes pays.
    pub cpu_ms: Percentiles,
    /// Missing where the clock is the wall's, but for quell on a CPU adapter.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub passes: Vec<PassReport>,
    pub memory: MemoryReport,
    /// Linear models a frame, where the method has any; a mean.
    pub models: Option<f64>,
    pub samples: Samples,
}

#[derive(Debug, Clone, Serialize)]
pub struct PassReport {
    pub name: &'static str,
    pub ms: Percentiles,
}

/// What a method holds on the GPU besides its inputs and output.
#[derive(Debug, Clone, Serialize)]
pub struct MemoryReport {
    pub resources: Vec<ResourceReport>,
    pub total_bytes: u64,
    pub bytes_per_pixel: f64,
}

#[derive(Debug, Clone, Serialize)]
pub struct ResourceReport {
    pub name: &'static str,
    pub bytes: u64,
}

/// Every timed frame, in order.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Samples {
    /// Since the size's first frame, on one clock for all methods: shows drift, and how methods took turns.
    pub started_ms: Vec<f64>,
    pub frame_ms: Vec<f64>,
    pub cpu_ms: Vec<f64>,
}

/// The times of one method as they come.
#[derive(Debug, Default)]
pub struct MethodRecorder {
    samples: Samples,
    /// By pass, then by frame.
    passes_ms: Vec<Vec<f64>>,
    models: Vec<f64>,
}

impl MethodRecorder {
    pub fn add(&mut self, started_ms: f64, time: FrameTime, models: Option<u32>) {
        self.samples.started_ms.push(started_ms);
        self.samples.frame_ms.push(time.frame_ms);
        self.samples.cpu_ms.push(time.cpu_ms);
        self.passes_ms.resize_with(time.passes_ms.len(), Vec::new);
        for (all, ms) in self.passes_ms.iter_mut().zip(time.passes_ms) {
            all.push(ms);
        }
        self.models.extend(models.map(f64::from));
    }

    /// The report, yet without a ratio.
    pub fn finish(
        self,
        method: &'static str,
        passes: &[&'static str],
        memory: &[Allocation],
        pixels: f64,
    ) -> MethodReport {
        let total_bytes = memory.iter().map(|allocation| allocation.bytes).sum();
        let resource = |&Allocation { name, bytes }: &Allocation| ResourceReport { name, bytes };
        MethodReport {
            method,
            frame_ms: Percentiles::of(&self.samples.frame_ms),
            ratio: None,
            cpu_ms: Percentiles::of(&self.samples.cpu_ms),
            passes: passes
                .iter()
                .zip(&self.passes_ms)
                .map(|(&name, ms)| PassReport { name, ms: Percentiles::of(ms) })
                .collect(),
            memory: MemoryReport {
                resources: memory.iter().map(resource).collect(),
                total_bytes,
                bytes_per_pixel: total_bytes as f64 / pixels,
            },
            models: (!self.models.is_empty())
                .then(|| self.models.iter().sum::<f64>() / self.models.len() as f64),
            samples: self.samples,
        }
    }
}

impl SizeReport {
    /// The report of methods that ran at this size, with ratios to `baseline`.
    pub fn new([width, height]: [u32; 2], baseline: &str, mut methods: Vec<MethodReport>) -> Self {
        let of_baseline = methods.iter().find(|method| method.method == baseline);
        let median = of_baseline.map(|method| method.frame_ms.median).filter(|&ms| ms > 0.0);
        for method in &mut methods {
            method.ratio = median.map(|ms| method.frame_ms.median / ms);
        }
        Self { width, height, methods }
    }

    fn name(&self) -> String {
        format!("{}x{}", self.width, self.height)
    }
}

impl BenchReport {
    /// All tables, for a terminal and as Markdown.
    pub fn text(&self) -> String {
        let Self { machine, scene, frames, warm_up, spp, start_s, .. } = self;
        let motion = match self.motion {
            Motion::Walk => "",
            Motion::Still => ", standing still",
            Motion::Cut => ", each frame after a cut",
        };
        let clock = match self.clock {
            Clock::GpuTimestamps => "GPU time from the begin of the first pass to the end of the last",
            Clock::Wall => "wall time from submission until done",
        };
        let mut out = format!(
            "{machine}- walk: {scene} from {start_s} s{motion}, {spp} spp, {frames} frames after {warm_up} of warm-up; methods take \
             turns frame by frame\n- clock: {clock}\n"
        );
        let _ = self.settings.as_ref().map(|settings| writeln!(out, "- quell's settings: {settings}"));
        let _ = self.note.map(|note| writeln!(out, "- note: {note}"));
        for SkippedSize { width, height, reason } in &self.skipped {
            let _ = writeln!(out, "- skipped: {width}x{height}: {reason}");
        }
        let _ = write!(out, "\n{}", aligned(&self.frames_table(), 2));
        let passes = self.passes_table();
        if passes.len() > 1 {
            let _ = write!(out, "\nPasses, ms:\n\n{}", aligned(&passes, 2));
        }
        let _ =
            write!(out, "\nMemory besides inputs and output, MB:\n\n{}", aligned(&self.memory_table(), 2));
        out
    }

    /// A row per size and method.
    pub fn frames_table(&self) -> Vec<Vec<String>> {
        let ratio = format!("/ {}", self.baseline);
        let headings =
            ["size", "method", "median ms", "p95", "p99", &ratio, "CPU ms", "MB", "B/px", "models"];
        let mut rows = vec![headings.map(str::to_owned).to_vec()];
        for size in &self.sizes {
            rows.extend(size.methods.iter().map(|method| {
                let Percentiles { median, p95, p99 } = method.frame_ms;
                vec![
                    size.name(),
                    method.method.to_owned(),
                    format!("{median:.3}"),
                    format!("{p95:.3}"),
                    format!("{p99:.3}"),
                    or_dash(method.ratio.map(|ratio| format!("{ratio:.2}"))),
                    format!("{:.3}", method.cpu_ms.median),
                    megabytes(method.memory.total_bytes),
                    format!("{:.1}", method.memory.bytes_per_pixel),
                    or_dash(method.models.map(|models| format!("{models:.0}"))),
                ]
            }));
        }
        rows
    }

    /// Median and p95 of each pass, a pair of columns per size.
    pub fn passes_table(&self) -> Vec<Vec<String>> {
        let times = |size: &SizeReport| [format!("{} median", size.name()), "p95".to_owned()];
        self.by_size(
            "pass",
            times,
            |method| method.passes.iter().map(|pass| pass.name).collect(),
            |method, name| {
                let pass = method.passes.iter().find(|pass| pass.name == name)?;
                Some([format!("{:.3}", pass.ms.median), format!("{:.3}", pass.ms.p95)])
            },
        )
    }

    /// Each resource and their total, a column per size.
    fn memory_table(&self) -> Vec<Vec<String>> {
        const TOTAL: &str = "total";
        self.by_size(
            "resource",
            |size| [size.name()],
            |method| method.memory.resources.iter().map(|resource| resource.name).chain([TOTAL]).collect(),
            |method, name| {
                let memory = &method.memory;
                let resource = memory.resources.iter().find(|resource| resource.name == name);
                let bytes = if name == TOTAL { Some(memory.total_bytes) } else { resource.map(|r| r.bytes) };
                bytes.map(|bytes| [megabytes(bytes)])
            },
        )
    }

    /// A table of what methods consist of: a row per method and part, `N` columns per size.
    fn by_size<const N: usize>(
        &self,
        part: &str,
        headings: impl Fn(&SizeReport) -> [String; N],
        parts: impl Fn(&MethodReport) -> Vec<&'static str>,
        cells: impl Fn(&MethodReport, &str) -> Option<[String; N]>,
    ) -> Vec<Vec<String>> {
        let mut rows = vec![vec!["method".to_owned(), part.to_owned()]];
        rows[0].extend(self.sizes.iter().flat_map(headings));
        // All sizes have the same methods, and these the same parts.
        let methods = self.sizes.first().map_or(&[][..], |size| &size.methods);
        for (i, method) in methods.iter().enumerate() {
            for part in parts(method) {
                let mut row = vec![method.method.to_owned(), part.to_owned()];
                for size in &self.sizes {
                    row.extend(
                        cells(&size.methods[i], part)
                            .unwrap_or_else(|| std::array::from_fn(|_| or_dash(None))),
                    );
                }
                rows.push(row);
            }
        }
        rows
    }
}

fn megabytes(bytes: u64) -> String {
    format!("{:.2}", bytes as f64 * 1e-6)
}

fn or_dash(text: Option<String>) -> String {
    text.unwrap_or_else(|| "-".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn method(name: &'static str, frames_ms: &[f64]) -> MethodReport {
        let mut recorder = MethodRecorder::default();
        for (i, &frame_ms) in frames_ms.iter().enumerate() {
            let time = FrameTime { frame_ms, cpu_ms: 0.5, passes_ms: vec![0.25 * frame_ms, 0.5 * frame_ms] };
            recorder.add(i as f64, time, (name == "quell").then_some(100 + i as u32));
        }
        let memory =
            [Allocation { name: "history", bytes: 3_000_000 }, Allocation { name: "x", bytes: 500_000 }];
        recorder.finish(name, &["first", "second"], &memory, 1e6)
    }

    #[test]
    fn ratios_are_of_medians_to_the_baseline() {
        let methods = vec![method("quell", &[1.0, 2.0, 9.0]), method("peer", &[4.0, 4.0, 4.0])];
        let size = SizeReport::new([1000, 1000], "peer", methods);
        let ratios: Vec<_> = size.methods.iter().map(|method| method.ratio).collect();
        assert_eq!(ratios, [Some(0.5), Some(1.0)]);
        let untimed = SizeReport::new([1, 1], "peer", vec![method("peer", &[0.0])]);
        assert_eq!(untimed.methods[0].ratio, None, "not infinite, not NaN");
    }

    #[test]
    fn a_method_reports_passes_memory_and_models() {
        let report = method("quell", &[1.0, 2.0, 9.0]);
        assert_eq!(report.passes[1].name, "second");
        assert_eq!((report.passes[0].ms.median, report.passes[1].ms.median), (0.5, 1.0));
        assert_eq!((report.memory.total_bytes, report.memory.bytes_per_pixel), (3_500_000, 3.5));
        assert_eq!(report.models, Some(101.0));
        assert_eq!(report.samples.started_ms, [0.0, 1.0, 2.0]);
        assert_eq!(method("peer", &[1.0]).models, None);
    }

    #[test]
    fn tables_have_a_column_per_size_and_a_row_per_part() {
        let size = |width, ms: f64| {
            SizeReport::new([width, 1000], "peer", vec![method("quell", &[ms]), method("peer", &[2.0 * ms])])
        };
        let report = BenchReport {
            machine: Machine::of(&crate::gpu::Gpu::new().expect("tests need a Vulkan driver")),
            clock: Clock::GpuTimestamps,
            note: None,
            scene: "test".to_owned(),
            start_s: 0.0,
            motion: Motion::Cut,
            settings: Some("odd".to_owned()),
            spp: 1,
            warm_up: 1,
            frames: 1,
            baseline: "peer",
            sizes: vec![size(1000, 4.0), size(2000, 8.0)],
            skipped: vec![SkippedSize { width: 9, height: 9, reason: "odd".to_owned() }],
        };
        let cells =
            |line: &str| line.trim_matches('|').split('|').map(str::trim).collect::<Vec<_>>().join(" ");
        let text: Vec<_> = report.text().lines().map(cells).collect();
        for line in [
            "2000x1000 quell 8.000 8.000 8.000 0.50 0.500 3.50 3.5 100",
            "2000x1000 peer 16.000 16.000 16.000 1.00 0.500 3.50 3.5 -",
            "method pass 1000x1000 median p95 2000x1000 median p95",
            "quell second 2.000 2.000 4.000 4.000",
            "peer history 3.00 3.00",
            "peer total 3.50 3.50",
            "- skipped: 9x9: odd",
            "- walk: test from 0 s, each frame after a cut, 1 spp, 1 frames after 1 of warm-up; methods take turns frame by frame",
        ] {
            assert!(text.iter().any(|found| found == line), "`{line}` is not in {text:#?}");
        }
    }
}
